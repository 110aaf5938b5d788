#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "calib/drift.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/measured_json.h"

namespace floatstage::apps {
namespace {

constexpr std::size_t kFewestPatches = 12;

struct DriftArguments {
  std::filesystem::path take, reference, make, json;
  double every = 2, alarm = 0.1;
};

// The empty stage where a plate was shot, else the first picture.
Result<Image> still(capture::TakeReader& take, int camera) {
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  if (const auto plate = take.layout().plate(serial); is_there(plate)) return load_png(plate);
  for (int i = 0; i < take.frame_count(); ++i) {
    const Result<Frame> frame = take.frame(camera, i);
    if (!frame) return forward(frame);
    if (!frame->empty()) return to_rgb(*frame);
  }
  return fail(ErrorCode::NotFound,
              text("camera '", serial, "' has no picture in ", take.layout().folder().string()));
}

Result<void> make_reference(capture::TakeReader& take, const DriftArguments& given) {
  std::vector<Image> images;
  for (int c = 0; c < static_cast<int>(take.rig().cameras.size()); ++c) {
    Result<Image> image = still(take, c);
    if (!image) return forward(image);
    images.push_back(*std::move(image));
  }
  const Result<calib::DriftReference> reference = calib::make_drift_reference(take.rig(), images);
  if (!reference) return forward(reference);
  nlohmann::json cameras = nlohmann::json::array();
  for (std::size_t c = 0; c < images.size(); ++c) {
    const std::size_t patches = reference->patches[c].size();
    if (patches < kFewestPatches)
      return fail(ErrorCode::BadData,
                  text("camera '", reference->serials[c], "' sees only ", patches,
                       " textured spots of the background and ", kFewestPatches,
                       " are needed; put stickers or printed markers where every camera sees some"));
    std::printf("%s: %zu patches\n", reference->serials[c].c_str(), patches);
    cameras.push_back({{"serial", reference->serials[c]}, {"patches", patches}});
  }
  if (Result<void> ok = calib::save_drift_reference(*reference, given.make); !ok) return ok;
  if (given.json.empty()) return {};
  return pipeline::save_json({{"reference", given.make.string()}, {"cameras", cameras}}, given.json);
}

// Beside what the recorder found out.
Result<void> add_to_quality(const std::filesystem::path& file, nlohmann::json drift) {
  nlohmann::json quality = nlohmann::json::object();
  if (is_there(file)) {
    const Result<std::string> bytes = read_file(file);
    if (!bytes) return forward(bytes);
    Result<nlohmann::json> parsed = parse_json(*bytes, file.string());
    if (parsed) quality = std::move(*parsed);
    if (!parsed || !quality.is_object())
      return fail(ErrorCode::BadData, text(file.string(), ": is no JSON object; move it away"));
  }
  quality["drift"] = std::move(drift);
  return pipeline::save_json(quality, file);
}

// One camera's pictures, `every` so many seconds.
Result<nlohmann::json> watch_camera(capture::TakeReader& take, int camera, const DriftArguments& given,
                                    calib::DriftWatch& drift, pipeline::ProgressPart& progress,
                                    nlohmann::json& alarms) {
  const std::vector<FrameRow>& rows = take.rows(camera);
  double largest = 0, parallax = 0, next = 0;
  int checks = 0, known = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    progress.advance();
    const double time = seconds(rows[i].info.exposure_start - rows[0].info.exposure_start);
    if (time < next || !rows[i].media_index) continue;
    const Result<Frame> frame = take.frame(camera, static_cast<int>(i));
    if (!frame) return forward(frame);
    if (frame->empty()) continue;
    const Result<Image> image = to_rgb(*frame);
    if (!image) return forward(image);
    next = time + given.every;
    ++checks;
    if (const std::optional<calib::DriftAlarm> alarm = drift.check(camera, time, *image)) {
      std::printf("%.1f s: %s\n", time, alarm->sentence.c_str());
      alarms.push_back({{"camera", alarm->serial},
                        {"seconds", time},
                        {"degrees", alarm->degrees},
                        {"residual_px", alarm->residual_px},
                        {"moved", alarm->moved},
                        {"parallax_px", alarm->parallax_px},
                        {"sentence", alarm->sentence}});
    }
    const calib::CameraTurn& turn = drift.turns()[static_cast<std::size_t>(camera)];
    known += turn.known;
    if (turn.known)
      largest = std::max(largest, turn.degrees), parallax = std::max(parallax, turn.parallax_px);
  }
  const std::string& serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
  if (2 * known < checks)
    std::printf("%s: its background was seen in only %d of %d checks: whether it turned is not known\n",
                serial.c_str(), known, checks);
  nlohmann::json out = {{"serial", serial}, {"checks", checks}, {"known", known}};
  const char* const unseen = "in no check enough of its background was seen";
  pipeline::put(out, "largest_degrees", Measured::of(largest, known, unseen));
  pipeline::put(out, "largest_parallax_px", Measured::of(parallax, known, unseen));
  out.erase("counts");  // `known`, both
  return out;
}

Result<void> watch(capture::TakeReader& take, const DriftArguments& given) {
  Result<calib::DriftReference> reference = calib::load_drift_reference(given.reference);
  if (!reference) return forward(reference);
  Result<calib::DriftWatch> drift =
      calib::DriftWatch::create(take.rig(), *std::move(reference), {.alarm_degrees = given.alarm});
  if (!drift) return forward(drift);
  nlohmann::json alarms = nlohmann::json::array(), cameras = nlohmann::json::array();
  const std::size_t count = take.rig().cameras.size();
  ProgressBar bar;
  pipeline::ProgressPart progress(&bar, "watching for drift",
                                  count * static_cast<std::size_t>(take.frame_count()));
  for (int c = 0; c < static_cast<int>(count); ++c) {
    Result<nlohmann::json> camera = watch_camera(take, c, given, *drift, progress, alarms);
    if (!camera) return forward(camera);
    cameras.push_back(std::move(*camera));
  }
  if (alarms.empty()) std::printf("no camera was seen to turn by more than %g degrees\n", given.alarm);
  const nlohmann::json report = {{"alarms", alarms}, {"cameras", cameras}};
  if (!given.json.empty())
    if (Result<void> ok = pipeline::save_json(report, given.json); !ok) return ok;
  return add_to_quality(take.layout().quality(), report);
}

Result<void> run_drift(const DriftArguments& given) {
  if (given.reference.empty() == given.make.empty())
    return fail(ErrorCode::InvalidArgument,
                "give either --reference FILE to compare with, or --make-reference FILE to write one");
  if (!(given.every > 0)) return fail(ErrorCode::InvalidArgument, "--every must be positive");
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  return given.make.empty() ? watch(**take, given) : make_reference(**take, given);
}

}  // namespace

void add_calibrate_drift(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<DriftArguments>();
  CLI::App* verb = add_verb(calibrate, chosen, "drift",
                            "Has a camera turned since the calibration? Written to the take's quality.json",
                            {"floatstage calibrate drift monday --make-reference studio.drift",
                             "floatstage calibrate drift friday --reference studio.drift --alarm 0.05"});
  add_take(*verb, options->take);
  verb->add_option("--reference", options->reference, "Patches of the background to compare with")
      ->type_name("FILE");
  verb->add_option("--make-reference", options->make, "Write them, from the take's plates or first pictures")
      ->type_name("FILE");
  verb->add_option("--alarm", options->alarm, "Degrees that raise an alarm")->capture_default_str();
  add_json(*verb, options->json);
  verb->add_option("--every", options->every, "Seconds from one check to the next")
      ->capture_default_str()
      ->group(kGroupTuning);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_drift(*options); }; });
}

}  // namespace floatstage::apps
