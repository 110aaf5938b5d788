#include "pipeline/matte/consistent_verdict.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

constexpr float kClearly = 0.75f;   // log-odds: three of four others hold a place for subject …
constexpr float kDenied = -1.5f;    // … or not even one, or one is sure of the opposite
constexpr double kFewPixels = 100;  // of subject at the turns' size: too few to learn its colours from
constexpr double kMuch = 0.5;       // share that is missing or denied
constexpr double kDeniedInMost =
    0.05;                         // share that is denied in half of the cameras: as kAllowed of the audit
constexpr double kUnsure = 0.6;   // share of pixels that colours bear out
constexpr double kFills = 0.7;    // share of the picture
constexpr double kLeaves = 0.02;  // share of the border
constexpr double kOneSide = 20;   // degrees between the two cameras that differ most

ConsistentView measured(const ViewEvidence& e) {
  ConsistentView view;
  if (e.label.empty()) return view;
  view.pictured = true;
  const int w = e.label.width, h = e.label.height;
  long subject = 0, clear = 0, missing = 0, surplus = 0, either = 0, borne = 0, border = 0;
  for (std::size_t p = 0; p < e.label.pixels.size(); ++p) {
    const bool is = e.label.pixels[p] != 0, said = e.others[p] > kClearly;
    const int x = static_cast<int>(p) % w, y = static_cast<int>(p) / w;
    subject += is;
    clear += said;
    missing += said && !is;
    surplus += is && e.others[p] < kDenied;
    either += is || said;
    borne += (is || said) && (e.odds[p] > 0) == is;
    border += is && (x == 0 || y == 0 || x == w - 1 || y == h - 1);
  }
  const auto share = [](long part, double of) { return of > 0 ? static_cast<double>(part) / of : 0; };
  view.subject = share(subject, static_cast<double>(e.label.pixels.size()));
  view.missing = share(missing, static_cast<double>(clear));
  view.surplus = share(surplus, static_cast<double>(subject));
  view.sure = share(borne, static_cast<double>(either));
  view.border = share(border, 2.0 * (w + h) - 4);
  return view;
}

struct Named {
  std::string words;  // "04 (62 %), 07 (55 %)", or nothing
  std::vector<int> cameras;
};

Named named(const Rig& rig, const std::vector<ConsistentView>& views,
            const std::function<std::optional<double>(const ConsistentView&, std::size_t)>& figure) {
  Named names;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (!views[i].pictured) continue;
    const std::optional<double> f = figure(views[i], i);
    if (!f) continue;
    names.words +=
        text(names.words.empty() ? "" : ", ", rig.cameras[i].serial, " (", std::lround(100 * *f), " %)");
    names.cameras.push_back(static_cast<int>(i));
  }
  return names;
}

double widest_angle(const Rig& rig, const Eigen::Vector3d& fixation) {
  double least = 1;
  for (const RigCamera& a : rig.cameras)
    for (const RigCamera& b : rig.cameras) {
      const Eigen::Vector3d x = (a.cam_from_world.center() - fixation).normalized(),
                            y = (b.cam_from_world.center() - fixation).normalized();
      least = std::min(least, x.dot(y));
    }
  return std::acos(std::clamp(least, -1.0, 1.0)) * 180 / 3.14159265358979323846;
}

}  // namespace

void judge(const Rig& rig, const recon::SharedView& shared, std::span<const ViewEvidence> evidence,
           ConsistentMattes& mattes) {
  mattes.views.clear();
  for (const ViewEvidence& e : evidence) mattes.views.push_back(measured(e));
  const auto say = [&](const Named& cameras, const char* what, bool wrong) {
    if (cameras.words.empty()) return;
    mattes.remarks.push_back(text("cameras ", cameras.words, ": ", what));
    mattes.trusted = mattes.trusted && !wrong;
    if (wrong) mattes.wrong.emplace_back(what, cameras.cameras);
  };
  const auto above = [&](double ConsistentView::*figure, double limit) {
    return named(rig, mattes.views, [&](const ConsistentView& v, std::size_t) {
      return v.*figure > limit ? std::optional(v.*figure) : std::nullopt;
    });
  };
  Named astray;
  for (const int i : shared.astray)
    astray.words += text(astray.words.empty() ? "" : ", ", rig.cameras[static_cast<std::size_t>(i)].serial);
  say(astray, "their pictures do not show the point that the others look at", false);
  const Named none = named(rig, mattes.views, [&](const ConsistentView& v, std::size_t i) {
    const bool few = v.subject * static_cast<double>(evidence[i].label.pixels.size()) < kFewPixels;
    return few ? std::optional(v.subject) : std::nullopt;
  });
  say(none, "no subject was found around the point that the cameras look at, or too little to tell", true);
  say(above(&ConsistentView::subject, kFills), "what was found fills the picture", true);
  say(above(&ConsistentView::missing, kMuch), "so much of what the others see is missing", true);
  say(above(&ConsistentView::surplus, kMuch), "so much of the subject is denied by the others", true);
  const auto pictured = std::count_if(mattes.views.begin(), mattes.views.end(),
                                      [](const ConsistentView&v) { return v.pictured; }),
             denied = std::count_if(mattes.views.begin(), mattes.views.end(),
                                    [](const ConsistentView&v) { return v.surplus > kDeniedInMost; });
  if (2 * denied >= pictured)
    say(above(&ConsistentView::surplus, kDeniedInMost),
        "so much of the subject is denied by the others, in half of the cameras: subject and backdrop share "
        "colours, and a part of either is taken for the other",
        true);
  say(named(rig, mattes.views,
            [](const ConsistentView& v, std::size_t) {
              return v.subject > 0 && v.sure < kUnsure ? std::optional(v.sure) : std::nullopt;
            }),
      "colours bear out only so much of the subject", true);
  say(above(&ConsistentView::border, kLeaves), "the subject leaves the picture, over so much of its border",
      false);
  if (const double angle = widest_angle(rig, shared.fixation); angle < kOneSide) {
    mattes.remarks.push_back(text("all cameras look from one side, at most ", std::lround(angle),
                                  " degrees apart: they cannot tell the subject from what is behind it"));
    mattes.trusted = false;
    mattes.wrong.emplace_back("all cameras look from one side", std::vector<int>());
  }
}

}  // namespace floatstage::pipeline
