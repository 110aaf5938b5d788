#include "pipeline/matte/matte_doubts.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "core/file_presence.h"
#include "core/matte_edits.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/matte/doubt_pictures.h"
#include "pipeline/matte/doubt_sheet.h"
#include "pipeline/matte/matte_job.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

constexpr double kMostUnseen = 0.8;  // of the subject, where its plate knows nothing
constexpr double kMostBorder = 0.5;  // of the border: a majority, as rim_check.h has it
constexpr double kMostJump = 0.5;    // of the larger of two areas, from a frame to the next: a majority
constexpr double kSlowest = 10;      // frames a second: in between a body may turn
constexpr double kStep = 0.03;       // of the longer side: kReach of carried_guidance.cpp, a frame's motion
constexpr double kSpeck = 1e-4;      // of the picture: 10x10 of a megapixel

constexpr const char* kClick =
    "; click on it in the editor of `play`, give mattes with --guide, or choose another --matte with --redo";

// The frames of each reason, over all cameras.
struct Reason {
  std::vector<const MatteJob*> jobs;
  std::map<int, int> frames;  // and how many cameras
  bool now = false;           // some were made in this run
};

std::map<std::string, Reason> reasons_in(const MatteStore& store, const std::vector<MatteJob>& jobs) {
  std::map<std::string, Reason> reasons;
  for (const MatteJob& job : jobs) {
    const CameraRecord* record = store.find(job.serial);
    if (!record) continue;
    for (const auto& [why, frames] : record->doubts) {
      bool any = false;
      for (const int frame : frames) {
        const auto f = static_cast<std::size_t>(frame);
        const bool others = frame < 0 || f >= job.wanted.size() || !job.wanted[f] ||
                            !record->files.contains(frame) || (job.there[f] && !job.ours[f]);
        if (others) continue;
        Reason& reason = reasons[why];
        ++reason.frames[frame];
        reason.now = reason.now || job.todo[f];
        any = true;
      }
      if (any) reasons[why].jobs.push_back(&job);
    }
  }
  return reasons;
}

// That most cameras share; of equals the one whose matte is farthest from what is usual in its camera.
int worst_of(const Reason& reason) {
  std::map<int, double> odd;
  for (const MatteJob* job : reason.jobs) {
    std::vector<double> areas;
    for (const auto& [frame, shape] : job->shapes) areas.push_back(shape.area);
    if (areas.empty()) continue;
    std::nth_element(areas.begin(), areas.begin() + static_cast<std::ptrdiff_t>(areas.size() / 2),
                     areas.end());
    const double usual = areas[areas.size() / 2];
    for (const auto& [frame, shape] : job->shapes) odd[frame] += std::abs(shape.area - usual) + shape.border;
  }
  int worst = reason.frames.begin()->first;
  for (const auto& [frame, cameras] : reason.frames) {
    const int most = reason.frames.at(worst);
    if (cameras > most || (cameras == most && odd[frame] > odd[worst])) worst = frame;
  }
  return worst;
}

// Whether a doubt is still said of a camera and frame that the jobs are not about.
bool held_elsewhere(const MatteStore& store, const std::vector<MatteJob>& jobs, const DoubtPicture& picture) {
  const auto frame = static_cast<std::size_t>(picture.frame);
  const auto asked = [&](const std::string& serial) {
    return std::any_of(jobs.begin(), jobs.end(), [&](const MatteJob& job) {
      return job.serial == serial && frame < job.wanted.size() && job.wanted[frame];
    });
  };
  return std::any_of(picture.cameras.begin(), picture.cameras.end(), [&](const std::string& serial) {
    const CameraRecord* record = asked(serial) ? nullptr : store.find(serial);
    if (!record) return false;
    const auto said = record->doubts.find(picture.why);
    return said != record->doubts.end() && said->second.contains(picture.frame);
  });
}

// What mattes tell by their sizes.
void note_shapes(const MatteJob& job, CameraRecord& record) {
  const MatteShape* before = nullptr;
  int frame_before = -1;
  for (const auto& [frame, shape] : job.shapes) {
    if (shape.border > kMostBorder)
      record
          .doubts[text("the subject covers more than half of the picture's border, as a backdrop does",
                       kClick)]
          .insert(frame);
    const bool follows = before && frame_before == frame - 1 && job.frame_rate >= kSlowest;
    const double larger = follows ? std::max(shape.area, before->area) : 0,
                 change = follows ? std::abs(shape.area - before->area) : 0,
                 passing = follows ? std::max(shape.passing, before->passing) : 0;
    if (larger > kSpeck && change - passing > kMostJump * larger)
      record
          .doubts[text("more than half of the subject ", shape.area > before->area ? "comes" : "goes",
                       " from one frame to the next", kClick)]
          .insert(frame);
    before = &shape;
    frame_before = frame;
  }
}

bool sees_nobody(const MatteJob& job) {
  return std::all_of(job.shapes.begin(), job.shapes.end(),
                     [](const auto& of) { return of.second.area < kSpeck; });
}

}  // namespace

MatteShape shape_of(const Image& matte) {
  MatteShape shape;
  long subject = 0, border = 0;
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      if (*matte.at(x, y) < 128) continue;
      ++subject;
      border += x == 0 || y == 0 || x == matte.width - 1 || y == matte.height - 1;
    }
  const double all = static_cast<double>(matte.width) * matte.height,
               rim = std::max(1.0, 2.0 * (matte.width + matte.height) - 4);
  if (all > 0)
    shape = {static_cast<double>(subject) / all, static_cast<double>(border) / rim,
             static_cast<double>(border) * kStep * std::max(matte.width, matte.height) / all};
  return shape;
}

void note_guidance(const CameraMatting::Link& made, CameraRecord& record) {
  if (made.guided) record.guided.insert(made.frame);
  for (const std::string& ended : made.ended) record.doubts[ended].insert(made.frame);
}

CameraMatting::Link link_of(const CameraRecord* record, int frame, Image matte) {
  CameraMatting::Link link{frame, std::move(matte)};
  if (record && record->files.contains(frame) && !record->guided.contains(frame)) link.base = link.matte;
  return link;
}

bool heals_on(MatteStore& store, const std::string& serial, const CameraEdits& edits,
              const CameraMatting::Link& made) {
  if (made.guided || made.matte.empty() || !store.healed_apart(serial, made.frame)) return false;
  const Result<Image> there = load_png(store.layout().matte(serial, made.frame));
  if (!there || there->pixels.size() != made.matte.pixels.size()) return false;
  Image said(there->width, there->height, 1, 128);
  for (const MatteKeyframe& keyframe : edits.keyframes)
    if (keyframe.frame == made.frame) paint_strokes(keyframe.strokes, 1, said);
  for (std::size_t p = 0; p < said.pixels.size(); ++p)
    if (said.pixels[p] != 128 && (said.pixels[p] == 255) != (there->pixels[p] >= 128)) return false;
  return true;
}

void note_doubts(const MatteJob& job, CameraRecord& record) {
  for (const CameraMatting::Link& made : job.guidance) note_guidance(made, record);
  const CameraKey& key = job.matting->key();
  if (key.kind() == CameraKey::Kind::Guide) return;
  note_shapes(job, record);
  if (job.report.clicks > 0) return;
  std::set<int> made;
  for (const auto& [frame, shape] : job.shapes) made.insert(frame);
  if (key.kind() == CameraKey::Kind::None)
    record
        .doubts[text("nothing tells the subject, so it was guessed",
                     key.reason().empty() ? kClick : text(" (", key.reason(), ")"))]
        .insert(made.begin(), made.end());
  if (key.kind() == CameraKey::Kind::Keyer && !key.reason().empty())
    record
        .doubts[text("most of the picture is not before the cloth that was keyed (", key.spec(),
                     "), and there is no other backdrop (", key.reason(), ")")]
        .insert(made.begin(), made.end());
  if (key.found() && sees_nobody(job))
    record
        .doubts[text("no plate was shot, and nobody stands out from the one that was found behind the "
                     "performance: who hardly moves is in it; shoot a plate, record for longer",
                     kClick)]
        .insert(made.begin(), made.end());
  if (key.unseen() > kMostUnseen)
    record
        .doubts[text("no plate was shot, and nearly all of the subject stands where no picture shows the "
                     "place without it, so its outline is not known; shoot a plate, record for longer",
                     kClick)]
        .insert(made.begin(), made.end());
}

Result<std::vector<MatteDoubt>> doubts_of(capture::TakeReader& take, const MatteStore& store,
                                          const std::vector<MatteJob>& jobs) {
  std::vector<MatteDoubt> doubts;
  std::set<fs::path> drawn;
  DoubtPictures pictures(doubts_folder(take.layout()));
  for (const auto& [why, reason] : reasons_in(store, jobs)) {
    MatteDoubt doubt{.why = why,
                     .cameras = {},
                     .frames = static_cast<int>(reason.frames.size()),
                     .worst = 0,
                     .picture = {}};
    for (const MatteJob* job : reason.jobs) doubt.cameras.push_back(job->serial);
    doubt.worst = worst_of(reason);
    if (const std::optional<int> shown = pictures.frame_of(why, doubt.cameras);
        !reason.now && shown && reason.frames.contains(*shown))
      doubt.worst = *shown;  // sizes were known when it was drawn
    const auto file_named = [&](const std::string& end) {
      return doubts_folder(take.layout()) / text(doubt.cameras.front(), "-", doubt.worst, end, ".png");
    };
    fs::path file = file_named("");
    for (int i = 2; !drawn.insert(file).second; ++i) file = file_named(text("-", i));
    std::vector<int> cameras;
    for (const MatteJob* job : reason.jobs) cameras.push_back(job->camera);
    if (reason.now || !is_there(file)) {
      const Result<Image> sheet = doubt_sheet(take, cameras, doubt.worst);
      if (!sheet) return forward(sheet);
      const DoubtPicture what{.of = "mattes", .why = why, .cameras = doubt.cameras, .frame = doubt.worst};
      if (Result<void> ok = pictures.put(file.filename(), what, *sheet); !ok) return forward(ok);
    }
    if (is_there(file)) doubt.picture = file;
    doubts.push_back(std::move(doubt));
  }
  const auto holds = [&](const std::string& name, const DoubtPicture& picture) {
    return drawn.contains(doubts_folder(take.layout()) / name) || held_elsewhere(store, jobs, picture);
  };
  if (Result<void> ok = pictures.keep("mattes", holds); !ok) return forward(ok);
  std::stable_sort(doubts.begin(), doubts.end(), [](const MatteDoubt& a, const MatteDoubt& b) {
    return a.cameras.size() > b.cameras.size();
  });
  return doubts;
}

fs::path doubts_folder(const TakeLayout& layout) { return layout.mattes() / "doubts"; }

std::string sentence(const MatteDoubt& doubt) {
  std::string who;
  for (const std::string& serial : doubt.cameras) who += text(who.empty() ? "" : ", ", "'", serial, "'");
  return text(doubt.cameras.size() > 1 ? "cameras " : "camera ", who, ", frame ", doubt.worst,
              doubt.frames > 1 ? text(" (", doubt.frames, " frames in all)") : "", ": ", doubt.why,
              doubt.picture.empty() ? "" : text(": ", doubt.picture.string()));
}

}  // namespace floatstage::pipeline
