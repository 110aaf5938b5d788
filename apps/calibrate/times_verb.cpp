#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "capture/take.h"
#include "core/log.h"
#include "pipeline/json_report.h"
#include "pipeline/take_times.h"

namespace floatstage::apps {
namespace {

using nlohmann::json;

struct TimesArguments {
  std::filesystem::path take, out, json_file;
  std::string frames;
  int threads = 0;
};

json to_json(const Rig& rig, const pipeline::TakeTimes& times, double rate) {
  json cameras = json::array();
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const calib::TimeOffset& one = times.offsets.cameras[c];
    json j = {{"serial", rig.cameras[c].serial}, {"measured", one.measured}};
    if (one.measured) {
      j["frames"] = {{"value", one.frames}, {"sigma", one.sigma_frames}};
      j["ms"] = {{"value", 1e3 * one.frames / rate}, {"sigma", 1e3 * one.sigma_frames / rate}};
    } else {
      j["not_measured"] = one.not_measured;
    }
    cameras.push_back(std::move(j));
  }
  const int reference = times.offsets.reference;
  return {
      {"from", "silhouettes"},
      {"frame_rate", rate},
      {"reference", reference < 0 ? json() : json(rig.cameras[static_cast<std::size_t>(reference)].serial)},
      {"cameras", cameras},
      {"warnings", times.warnings}};
}

Result<void> run_times(const TimesArguments& given) {
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  const Result<std::vector<int>> frames = frames_of_take(given.take, given.frames);
  if (!frames) return forward(frames);
  ProgressBar bar;
  const Result<pipeline::TakeTimes> times =
      pipeline::measure_take_times(**take, *frames, {.threads = given.threads}, &bar);
  if (!times) return forward(times);
  const Rig& rig = (*take)->rig();
  const double rate = (*take)->manifest().frame_rate;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const calib::TimeOffset& one = times->offsets.cameras[c];
    const char* const serial = rig.cameras[c].serial.c_str();
    if (!one.measured) {
      std::printf("%s: not measured, because %s\n", serial, one.not_measured.c_str());
    } else if (static_cast<int>(c) == times->offsets.reference) {
      std::printf("%s: the reference\n", serial);
    } else {
      std::printf("%s: %+.3f +- %.3f frames (%+.2f ms)\n", serial, one.frames, one.sigma_frames,
                  1e3 * one.frames / rate);
    }
  }
  for (const std::string& warning : times->warnings) log::warning(warning);
  if (times->offsets.reference >= 0) {
    const std::filesystem::path file = given.out.empty() ? capture::times_file((*take)->layout()) : given.out;
    if (Result<void> ok = capture::save_time_offsets(times->file, file); !ok) return ok;
    std::printf("written to %s\n", file.c_str());
  }
  if (given.json_file.empty()) return {};
  return pipeline::save_json(to_json(rig, *times, rate), given.json_file);
}

}  // namespace

void add_calibrate_times(CLI::App& calibrate, Chosen& chosen) {
  auto options = std::make_shared<TimesArguments>();
  CLI::App* verb = add_verb(calibrate, chosen, "times",
                            "By what part of a frame free-running cameras are apart, from moving silhouettes",
                            {"floatstage calibrate times rehearsal --frames 100:160",
                             "floatstage calibrate times rehearsal -o times.json --json report.json"});
  add_take(*verb, options->take);
  add_out(*verb, options->out, "Where the offsets go (default: times.json in the take)");
  add_frames(*verb, options->frames, "all");
  add_threads(*verb, options->threads);
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_times(*options); }; });
}

}  // namespace floatstage::apps
