#include <cstdio>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "apps/terminal/flags.h"
#include "apps/terminal/interrupt.h"
#include "apps/verbs.h"
#include "capture/sound/sound_source.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "studio/node/capture_session.h"
#include "studio/node/publishing.h"

namespace floatstage::apps {
namespace {

struct CaptureArguments {
  std::filesystem::path config, json;
  std::vector<std::string> sounds;
  studio::CaptureOptions capture;
};

nlohmann::ordered_json to_json(const studio::PublishingCounters& c) {
  const studio::wire::PublisherCounters& p = c.publisher;
  const auto each_second = [&](std::uint64_t n) {
    return c.seconds > 0 ? static_cast<double>(n) / c.seconds : 0.0;
  };
  return {{"seconds", c.seconds},
          {"bytes_per_second", each_second(p.outline_bytes + p.tile_bytes + p.status_bytes)},
          {"instants", c.looked},
          {"instants_overtaken", c.sets.overtaken},
          {"instants_troubled", c.troubled},
          {"outlines", {{"sent", p.outlines}, {"bytes", p.outline_bytes}}},
          {"tiles", {{"sent", p.tiles}, {"bytes", p.tile_bytes}}},
          {"tiles_by_camera", p.tiles_by_camera},
          {"dropped", p.dropped},
          {"left_out", p.left_out},
          {"refused", p.refused + c.control.refused},
          {"turned_away", p.turned_away},
          {"malformed", p.malformed + p.other_version + c.control.malformed + c.control.other_version},
          {"requests", c.control.requests}};
}

nlohmann::ordered_json to_report(const studio::CaptureReport& report,
                                 const std::optional<studio::PublishingCounters>& published) {
  nlohmann::ordered_json json;
  json["cameras"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < report.cameras.size(); ++i) {
    const studio::CapturedCamera& c = report.cameras[i];
    nlohmann::ordered_json camera = {{"serial", c.serial},         {"delivered", c.stats.delivered},
                                     {"failed", c.stats.failed},   {"lost", c.stats.lost},
                                     {"corrupt", c.stats.corrupt}, {"starved", c.stats.starved},
                                     {"fps", c.frame_rate},        {"reconnects", c.reconnects}};
    if (report.recording) {  // what concerns the take, from its first instant to its last
      const capture::RecordedCamera& r = report.recording->cameras[i];
      camera["delivered"] = r.recorded;
      camera["lost"] = r.lost;
      camera["failed"] = r.failed;
      camera["gaps"] = r.skips;
      camera["unexposed"] = r.unexposed;
      camera["duplicates"] = r.duplicates;
      camera["fps"] = r.frame_rate;
    }
    json["cameras"].push_back(std::move(camera));
  }
  if (published) json["published"] = to_json(*published);
  if (report.recording) {
    json["spread_ms"] = {{"p50", report.recording->spread_p50_ms}, {"max", report.recording->spread_max_ms}};
    json["verdict"] = report.recording->pass() ? "PASS" : "FAIL";
    json["complaints"] = report.recording->complaints;
    json["take"] = report.take.string();
  }
  return json;
}

// One line that is written over, and nothing where nobody watches.
void show(const studio::CaptureReport& report) {
  if (isatty(STDERR_FILENO) == 0) return;
  std::string line;
  for (const studio::CapturedCamera& c : report.cameras) {
    char part[96];
    std::snprintf(part, sizeof part, "%s%s %.1f fps, %llu lost", line.empty() ? "" : " | ", c.serial.c_str(),
                  c.frame_rate, static_cast<unsigned long long>(c.stats.lost));
    line += part;
  }
  std::fprintf(stderr, "\r\033[K%s", line.c_str());
}

Result<void> run_capture(const CaptureArguments& options) {
  Result<studio::CaptureConfig> config = studio::load_capture_config(options.config);
  if (!config) return forward(config);
  config->sounds.insert(config->sounds.end(), options.sounds.begin(), options.sounds.end());
  std::optional<studio::PublishingCounters> published;
  studio::CaptureOptions capture = options.capture;
  capture.companion = [&published](studio::CaptureNode& node) -> Result<std::shared_ptr<void>> {
    Result<std::unique_ptr<studio::PublishingNode>> made = studio::publish(node);
    if (!made) return forward(made);
    if (!*made) return std::shared_ptr<void>();
    return std::shared_ptr<void>(made->release(), [&published](void* ended) {
      const std::unique_ptr<studio::PublishingNode> telling(static_cast<studio::PublishingNode*>(ended));
      published = telling->counters();
    });
  };
  const Result<studio::CaptureReport> report = studio::run_capture(*config, capture, interrupted, show);
  if (!report) return forward(report);
  if (!options.json.empty())
    if (Result<void> saved = pipeline::save_json(to_report(*report, published), options.json); !saved)
      return saved;
  if (!report->recording) return {};
  std::printf("%s: %s\n", report->take.c_str(), report->recording->pass() ? "PASS" : "FAIL");
  for (const std::string& complaint : report->recording->complaints) std::printf("  %s\n", complaint.c_str());
  return {};
}

}  // namespace

void add_capture(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<CaptureArguments>();
  CLI::App* verb =
      add_verb(app, chosen, "capture", "Streams a studio's cameras and records a take",
               {"floatstage capture --config studio.toml",
                "floatstage capture --config studio.toml --record --seconds 60 -o take --json report.json"});
  verb->add_option("--config", options->config, "The studio: cameras, recording and limits (TOML)")
      ->required()
      ->type_name("FILE");
  verb->add_flag("--record", options->capture.record, "Record a take");
  add_out(*verb, options->capture.take,
          "The new take's folder (default: named by the time, where the config says)");
  verb->add_option(
          "--sound", options->sounds,
          text("Record sound beside what the config says, again for several: ", capture::kSoundUsage))
      ->type_name("SOURCE");
  add_seconds(*verb, options->capture.seconds, "How long (default: until Ctrl-C)");
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_capture(*options); }; });
}

}  // namespace floatstage::apps
