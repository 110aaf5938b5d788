#include <algorithm>
#include <cstdio>
#include <iomanip>
#include <map>

#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "calib/color_balance.h"
#include "calib/surface_colors.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/mesh_io.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/calibrate/report_pictures.h"
#include "pipeline/json_report.h"
#include "pipeline/measured_json.h"

namespace floatstage::apps {
namespace {

struct ColorArguments {
  std::filesystem::path take, rig, out, report, json;
  std::string reference;
  bool chart = false;
  int frame_count = 5;
  double bar = 1.5;
};

struct ChartFound {
  std::array<Eigen::Vector3d, 24> seen;
  calib::ColorFit fit;
};

// The first picture of a camera, of a few, that shows the whole chart.
Result<ChartFound> look_for_chart(capture::TakeReader& take, int camera, int looks) {
  std::string reason = "it has no picture";
  const int step = std::max(1, take.frame_count() / std::max(1, looks));
  for (int i = 0; i < take.frame_count(); i += step) {
    const Result<Frame> frame = take.frame(camera, i);
    if (!frame) return forward(frame);
    if (frame->empty()) continue;
    const Result<Image> image = to_rgb(*frame);
    if (!image) return forward(image);
    const auto seen = calib::find_color_chart(*image);
    if (!seen) {
      reason = seen.error().message;
      continue;
    }
    std::vector<calib::ColorPair> pairs;
    for (std::size_t k = 0; k < 24; ++k) pairs.push_back({(*seen)[k], calib::chart_colors()[k]});
    const Result<calib::ColorFit> fit = calib::fit_color(pairs);
    if (!fit) {
      reason = fit.error().message;
      continue;
    }
    return ChartFound{*seen, *fit};
  }
  return fail(ErrorCode::NotFound, reason);
}

// What the cameras see of the surfaces that `process` left.
Result<std::vector<calib::ColorSample>> overlap(capture::TakeReader& take, const Rig& rig, int wanted) {
  std::vector<int> frames;
  for (int i = 0; i < take.frame_count(); ++i)
    if (is_there(take.layout().mesh(i))) frames.push_back(i);
  if (frames.empty())
    return fail(ErrorCode::NotFound, text(take.layout().folder().string(),
                                          ": there are no meshes; run `floatstage process` on it first, or "
                                          "show a 24-patch chart to every camera and add --chart"));
  std::vector<calib::ColorSample> sights;
  const std::size_t step =
      std::max<std::size_t>(1, frames.size() / static_cast<std::size_t>(std::max(1, wanted)));
  ProgressBar bar;
  pipeline::ProgressPart progress(&bar, "colours", (frames.size() + step - 1) / step);
  int first_point = 0;
  constexpr int kMost = 6000;
  for (std::size_t k = 0; k < frames.size(); k += step, first_point += 2 * kMost) {
    const Result<Mesh> mesh = load_ply(take.layout().mesh(frames[k]));
    if (!mesh) return forward(mesh);
    const Result<FrameSet> set = take.frame_set(frames[k]);
    if (!set) return forward(set);
    std::vector<Image> images;
    for (const Frame& frame : set->frames) {
      images.emplace_back();
      if (frame.empty()) continue;
      Result<Image> image = to_rgb(frame);
      if (!image) return forward(image);
      images.back() = *std::move(image);
    }
    const std::vector<calib::ColorSample> here =
        calib::surface_colors(*mesh, rig, images, first_point, kMost);
    sights.insert(sights.end(), here.begin(), here.end());
    progress.advance();
  }
  return sights;
}

// The camera that shares its points with most others.
int busiest(const std::vector<calib::ColorSample>& sights, std::size_t cameras) {
  std::vector<int> counts(cameras);
  for (const calib::ColorSample& s : sights) ++counts[static_cast<std::size_t>(s.camera)];
  return static_cast<int>(std::max_element(counts.begin(), counts.end()) - counts.begin());
}

std::string css(const Eigen::Vector3d& rgb) {
  const auto byte = [](double v) { return std::lround(255 * std::clamp(v, 0.0, 1.0)); };
  return text("rgb(", byte(rgb[0]), ",", byte(rgb[1]), ",", byte(rgb[2]), ")");
}

struct Row {
  std::string serial;
  calib::ColorAgreement agreement;
  bool reference = false;
  std::vector<std::array<Eigen::Vector3d, 3>> swatches;  // seen, after, wanted

  Measured figure(double number) const {
    return Measured::of(number, agreement.points, "it shares no colour with other cameras");
  }
};

std::string html(const std::vector<Row>& rows, const nlohmann::json& json) {
  std::string out =
      "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Colour "
      "calibration</title><style>body{font:15px/1.45 system-ui,sans-serif;max-width:960px;"
      "margin:2em auto;padding:0 1em}table{border-collapse:collapse}td,th{padding:.2em "
      ".7em;text-align:right;border-bottom:1px solid #ddd}td:first-child,th:first-child{text-align:left}"
      ".s{display:inline-block;width:22px;height:14px}</style></head><body>";
  out += text("<h1>Colour calibration: ", json["pass"].get<bool>() ? "PASS" : "FAIL",
              "</h1><p>CIEDE2000 between a camera and what the others see of the same surfaces (or the "
              "chart's nominal colours); the bar is ",
              json["bar"].get<double>(),
              ". Below 1 nobody sees a difference; above 3 blends between cameras show.</p>");
  out +=
      "<table><tr><th>camera</th><th>colours</th><th>strays</th><th>before</th><th>after</th><th>P95</th></"
      "tr>";
  for (const Row& r : rows)
    out += text("<tr><td>", pipeline::escaped(r.serial), r.reference ? " (the others look like it)" : "",
                "</td><td>", r.agreement.points, "</td><td>", r.agreement.strays, "</td><td>",
                short_words(r.figure(r.agreement.mean_before), 2), "</td><td>",
                short_words(r.figure(r.agreement.mean_after), 2), "</td><td>",
                short_words(r.figure(r.agreement.p95_after), 2), "</td></tr>");
  out += "</table>";
  for (const Row& r : rows) {
    if (r.swatches.empty()) continue;
    out += text("<h2>Camera ", pipeline::escaped(r.serial), "</h2><p>as seen, corrected, wanted</p>");
    for (int k = 0; k < 3; ++k) {
      for (const auto& s : r.swatches)
        out +=
            text("<span class=\"s\" style=\"background:", css(s[static_cast<std::size_t>(k)]), "\"></span>");
      out += "<br>";
    }
  }
  return out + "</body></html>\n";
}

// A few of a camera's points for the report, from dark to bright.
std::vector<std::array<Eigen::Vector3d, 3>> swatches(const std::vector<calib::ColorSample>& sights,
                                                     int camera, const calib::ColorBalance& balance) {
  std::map<int, std::pair<Eigen::Vector3d, int>> sums;
  for (const calib::ColorSample& s : sights)
    if (s.camera != camera) {
      auto& [sum, n] = sums.try_emplace(s.point, Eigen::Vector3d::Zero(), 0).first->second;
      sum += apply(balance.transforms[static_cast<std::size_t>(s.camera)], s.seen);
      ++n;
    }
  std::vector<std::array<Eigen::Vector3d, 3>> all;
  for (const calib::ColorSample& s : sights)
    if (s.camera == camera)
      if (const auto found = sums.find(s.point); found != sums.end())
        all.push_back({s.seen, apply(balance.transforms[static_cast<std::size_t>(camera)], s.seen),
                       found->second.first / found->second.second});
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a[2].sum() < b[2].sum(); });
  constexpr std::size_t kShown = 36;
  std::vector<std::array<Eigen::Vector3d, 3>> out;
  for (std::size_t i = 0; i < std::min(kShown, all.size()); ++i)
    out.push_back(all[i * all.size() / std::min(kShown, all.size())]);
  return out;
}

Result<void> finish(const ColorArguments& given, Rig rig, const std::vector<Row>& rows) {
  nlohmann::json cameras = nlohmann::json::array();
  bool pass = true;
  for (const Row& r : rows) {
    const bool good = r.reference || (r.agreement.points > 0 && r.agreement.mean_after <= given.bar);
    pass = pass && good;
    nlohmann::json camera = {{"serial", r.serial},
                             {"points", r.agreement.points},
                             {"strays", r.agreement.strays},
                             {"reference", r.reference},
                             {"pass", good}};
    pipeline::put(camera, "delta_e_before", r.figure(r.agreement.mean_before));
    pipeline::put(camera, "delta_e", r.figure(r.agreement.mean_after));
    pipeline::put(camera, "delta_e_p95", r.figure(r.agreement.p95_after));
    camera.erase("counts");  // `points`, all of them
    cameras.push_back(std::move(camera));
    std::printf("%s: dE00 %s before, %s after (P95 %s), %d colours, %d strays%s\n", r.serial.c_str(),
                short_words(r.figure(r.agreement.mean_before), 2).c_str(),
                short_words(r.figure(r.agreement.mean_after), 2).c_str(),
                short_words(r.figure(r.agreement.p95_after), 2).c_str(), r.agreement.points,
                r.agreement.strays, r.reference ? "; the others look like it" : "");
  }
  std::printf("%s\n", pass ? "PASS" : "FAIL");
  const nlohmann::json json = {{"pass", pass}, {"bar", given.bar}, {"cameras", cameras}};
  if (!given.json.empty())
    if (Result<void> ok = pipeline::save_json(json, given.json); !ok) return ok;
  if (!given.report.empty()) {
    if (Result<void> ok = make_folder(given.report); !ok) return ok;
    if (Result<void> ok = write_file(given.report / "color.html", html(rows, json)); !ok) return ok;
    if (Result<void> ok = pipeline::save_json(json, given.report / "color.json"); !ok) return ok;
  }
  if (!pass)
    return fail(ErrorCode::BadData, text(given.take.string(), ": the cameras' colours do not agree to dE00 ",
                                         given.bar, "; ", given.out.string(), " was not written"));
  return save_rig(rig, given.out);
}

Result<void> run_chart(const ColorArguments& given, capture::TakeReader& take, Rig rig) {
  std::vector<Row> rows;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const Result<ChartFound> found = look_for_chart(take, static_cast<int>(c), 4 * given.frame_count);
    if (!found)
      return fail(found.error().code, text("camera '", rig.cameras[c].serial, "': ", found.error().message));
    rig.cameras[c].color = found->fit.transform;
    Row row{.serial = rig.cameras[c].serial,
            .agreement = {found->fit.used, 24 - found->fit.used, found->fit.mean_before,
                          found->fit.mean_delta_e, found->fit.p95_delta_e},
            .reference = false,
            .swatches = {}};
    for (std::size_t k = 0; k < 24; ++k)
      row.swatches.push_back(
          {found->seen[k], apply(found->fit.transform, found->seen[k]), calib::chart_colors()[k]});
    rows.push_back(std::move(row));
  }
  return finish(given, std::move(rig), rows);
}

Result<void> run_color(ColorArguments given) {
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  if (given.out.empty()) given.out = (*take)->layout().colors();
  Rig rig = (*take)->rig();
  if (!given.rig.empty()) {
    Result<Rig> other = load_rig(given.rig);
    if (!other) return forward(other);
    bool same = other->cameras.size() == rig.cameras.size();
    for (std::size_t c = 0; same && c < rig.cameras.size(); ++c)
      same = other->cameras[c].serial == rig.cameras[c].serial;
    if (!same)
      return fail(ErrorCode::InvalidArgument,
                  text(given.rig.string(), ": its cameras are not those of the take, in their order"));
    rig = *std::move(other);
  }
  if (given.chart) return run_chart(given, **take, std::move(rig));
  const Result<std::vector<calib::ColorSample>> sights = overlap(**take, rig, given.frame_count);
  if (!sights) return forward(sights);
  const int reference =
      given.reference.empty() ? busiest(*sights, rig.cameras.size()) : camera_index(rig, given.reference);
  if (reference < 0) return fail(ErrorCode::NotFound, text("the take has no camera '", given.reference, "'"));
  std::vector<std::optional<ColorTransform>> known(rig.cameras.size());
  known[static_cast<std::size_t>(reference)] = ColorTransform{};
  std::vector<std::string> serials;
  for (const RigCamera& c : rig.cameras) serials.push_back(c.serial);
  const Result<calib::ColorBalance> balance = calib::balance_colors(*sights, known, serials);
  if (!balance) return forward(balance);
  std::vector<Row> rows;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    rig.cameras[c].color = balance->transforms[c];
    rows.push_back({serials[c], balance->cameras[c], static_cast<int>(c) == reference,
                    swatches(*sights, static_cast<int>(c), *balance)});
  }
  return finish(given, std::move(rig), rows);
}

}  // namespace

void add_calibrate_color(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<ColorArguments>();
  CLI::App* verb =
      add_verb(calibrate, chosen, "color",
               "Cameras' colours made to agree, by a chart or by the surfaces that several of them see",
               {"floatstage calibrate color take --report report",
                "floatstage calibrate color chart-take --chart -o rig.json"});
  add_take(*verb, options->take, "The take's folder; processed (meshes), or showing a 24-patch chart");
  add_out(*verb, options->out,
          "The rig.json to write, with a colour transform for every camera (default: the take's colors.json, "
          "which render and play use)");
  verb->add_option("--rig", options->rig, "Geometry from this rig.json and not from the take")
      ->type_name("FILE");
  verb->add_flag("--chart", options->chart,
                 "Every camera sees a 24-patch chart somewhere in the take: colours become its nominal ones");
  verb->add_option("--reference", options->reference,
                   "Without a chart: the camera, by serial, that the others are to look like (default: the "
                   "one that sees most)")
      ->type_name("SERIAL");
  add_frame_count(*verb, options->frame_count, "How many instants are looked at");
  verb->add_option("--report", options->report, "Folder for color.html and color.json")->type_name("FOLDER");
  add_json(*verb, options->json);
  verb->add_option("--bar", options->bar, "CIEDE2000 that every camera must reach, on average")
      ->capture_default_str()
      ->group(kGroupTuning);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_color(*options); }; });
}

}  // namespace floatstage::apps
