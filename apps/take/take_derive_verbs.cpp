#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/take/take_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/text_options.h"
#include "calib/rig_formats.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/derive/derived_take.h"
#include "pipeline/derive/join.h"
#include "pipeline/derive/set_times.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

struct TakeDeriveArguments {
  fs::path take, out, json, times;
  calib::RigFile rig;
  std::vector<fs::path> takes;
  std::string frames, label;
};

Result<void> say(const pipeline::DerivedReport& report, const TakeDeriveArguments& given) {
  for (const std::string& note : report.notes) log::info(note);
  std::printf("%s: %d frames, %.1f MB of media shared with %s, %.1f MB copied\n", given.out.c_str(),
              report.frames, static_cast<double>(report.shared) / 1e6, given.take.c_str(),
              static_cast<double>(report.copied) / 1e6);
  if (given.json.empty()) return {};
  return pipeline::save_json({{"take", given.out.string()},
                              {"from", given.take.string()},
                              {"frames", report.frames},
                              {"shared_bytes", report.shared},
                              {"copied_bytes", report.copied},
                              {"notes", report.notes}},
                             given.json);
}

Result<void> set_rig(const TakeDeriveArguments& given) {
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  const Result<calib::ForeignRig> known = calib::read_rig(given.rig);
  if (!known) return forward(known);
  Result<Rig> rig = pipeline::rig_for(**take, known->rig, given.rig.path.string());
  if (!rig) return forward(rig);
  const Result<pipeline::DerivedReport> report = pipeline::derive_take(
      **take,
      {.rig = std::move(*rig), .how = text("set-rig ", given.rig.path.string()), .label = given.label},
      given.out);
  return report ? say(*report, given) : Result<void>(forward(report));
}

Result<void> set_times(const TakeDeriveArguments& given) {
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  const Result<capture::TimeOffsetFile> times = given.times.empty()
                                                    ? capture::load_time_offsets((*take)->layout())
                                                    : capture::load_time_offsets(given.times);
  if (!times) return forward(times);
  const Result<pipeline::SetTimesReport> report = pipeline::set_times(**take, *times, given.out);
  if (!report) return forward(report);
  for (const std::string& sentence : report->sentences) std::printf("%s\n", sentence.c_str());
  return say(report->take, given);
}

Result<void> trim(const TakeDeriveArguments& given) {
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  const Result<std::vector<int>> frames = parse_frames(given.frames, (*take)->frame_count());
  if (!frames) return forward(frames);
  if (static_cast<int>(frames->size()) != frames->back() - frames->front() + 1)
    return fail(ErrorCode::InvalidArgument,
                text("--frames ", given.frames, " leaves frames out between; say A:B without a step"));
  const Result<pipeline::DerivedReport> report = pipeline::derive_take(**take,
                                                                       {.rig = std::nullopt,
                                                                        .first = frames->front(),
                                                                        .end = frames->back() + 1,
                                                                        .how = text("trim ", given.frames),
                                                                        .label = given.label},
                                                                       given.out);
  return report ? say(*report, given) : Result<void>(forward(report));
}

Result<void> join(const TakeDeriveArguments& given) {
  ProgressBar progress;
  const Result<pipeline::JoinReport> report = pipeline::join_takes(given.takes, given.out, &progress);
  if (!report) return forward(report);
  for (const std::string& note : report->notes) log::info(note);
  std::printf("%s: %d frames of %zu takes\n", given.out.c_str(), report->frames, given.takes.size());
  if (given.json.empty()) return {};
  nlohmann::json from = nlohmann::json::array();
  for (const fs::path& take : given.takes) from.push_back(take.string());
  return pipeline::save_json(
      {{"take", given.out.string()}, {"from", from}, {"frames", report->frames}, {"notes", report->notes}},
      given.json);
}

}  // namespace

void add_take_derivations(CLI::App& take, Chosen& chosen) {
  auto rig = std::make_shared<TakeDeriveArguments>();
  CLI::App* verb =
      add_verb(take, chosen, "set-rig", "The same recording with another calibration, as a new take",
               {"floatstage take set-rig T rig.json -o calibrated",
                "floatstage take set-rig T calibration/ --format opencv -o calibrated"});
  add_take(*verb, rig->take);
  verb->add_option("rig", rig->rig.path, "A calibration of any format, a file or the folder that holds it")
      ->required();
  add_out(*verb, rig->out, "The new take's folder; it shares the media")->required();
  std::vector<std::string> formats = {std::string(calib::kAnyRigFormat)};
  for (const calib::RigFormat& f : calib::rig_formats()) formats.emplace_back(f.name);
  verb->add_option("--format", rig->rig.format, "The calibration's format")
      ->capture_default_str()
      ->check(one_of(formats));
  verb->add_option("--metres-per-unit", rig->rig.metres_per_unit,
                   "Length of the calibration's unit, where it states none")
      ->capture_default_str()
      ->check(CLI::PositiveNumber);
  verb->add_option("--label", rig->label, "The new take's label (default: as it was)");
  add_json(*verb, rig->json);
  verb->callback([rig, &chosen] { chosen.run = [rig] { return set_rig(*rig); }; });

  auto timed = std::make_shared<TakeDeriveArguments>();
  verb = add_verb(take, chosen, "set-times",
                  "The same recording with every camera's pictures at their instants, as a new take",
                  {"floatstage take set-times T -o together",
                   "floatstage take set-times T --times rehearsal/times.json -o together"});
  add_take(*verb, timed->take);
  add_out(*verb, timed->out, "The new take's folder; it shares the media")->required();
  verb->add_option("--times", timed->times,
                   "What `calibrate times` wrote (default: the take's own times.json)")
      ->type_name("FILE");
  add_json(*verb, timed->json);
  verb->callback([timed, &chosen] { chosen.run = [timed] { return set_times(*timed); }; });

  auto part = std::make_shared<TakeDeriveArguments>();
  verb = add_verb(take, chosen, "trim", "A part of a recording as a new take",
                  {"floatstage take trim T --frames 100:350 -o scene2",
                   "floatstage take trim T --frames :250 -o begin --label rehearsal"});
  add_take(*verb, part->take);
  add_frames(*verb, part->frames, "all")->required();
  add_out(*verb, part->out, "The new take's folder; it shares the media")->required();
  verb->add_option("--label", part->label, "The new take's label (default: as it was)");
  add_json(*verb, part->json);
  verb->callback([part, &chosen] { chosen.run = [part] { return trim(*part); }; });

  auto several = std::make_shared<TakeDeriveArguments>();
  verb = add_verb(take, chosen, "join", "Recordings of the same cameras, one after the other, as one take",
                  {"floatstage take join scene1 scene2 -o both",
                   "floatstage take join scene1 scene2 scene3 -o all --json J.json"});
  verb->add_option("takes", several->takes, "The takes' folders, in order")->required()->expected(2, 1000);
  add_out(*verb, several->out, "The new take's folder")->required();
  add_json(*verb, several->json);
  verb->callback([several, &chosen] { chosen.run = [several] { return join(*several); }; });
}

}  // namespace floatstage::apps
