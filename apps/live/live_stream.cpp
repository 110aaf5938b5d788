#include "apps/live/live_stream.h"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/terminal/interrupt.h"
#include "studio/live/live_stats.h"

namespace floatstage::apps {
namespace {

capture::StreamOptions options_of(const StreamFlags& flags) {
  return {flags.size.width, flags.size.height, flags.fps, flags.kbit, interrupted};
}

studio::Series latency_of(const capture::StreamReport& report) {
  studio::Series series;
  for (const double ms : report.latency_ms) series.add(ms);
  return series;
}

}  // namespace

void add_stream_flags(CLI::App& verb, StreamFlags& flags) {
  verb.add_option(
          "--stream", flags.url,
          "Send the pictures out while they are drawn: srt://127.0.0.1:9000?mode=listener (players call), "
          "srt://HOST:PORT, udp://HOST:PORT, rtp://HOST:PORT, rtsp://HOST:PORT/NAME, file:OUT.ts, or "
          "v4l2:/dev/videoN")
      ->type_name("URL")
      ->group(kGroupPicture);
  verb.add_option("--stream-fps", flags.fps, "Its pictures a second; missing ones are repeated")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 240.0))
      ->group(kGroupPicture);
  add_size(verb, flags.size, "Its pictures' size (default: the view's; in a window 1280x720)",
           "--stream-size")
      ->default_str("")
      ->group(kGroupPicture);
  verb.add_option("--stream-kbit", flags.kbit, "Its kbit a second, at most")
      ->capture_default_str()
      ->check(CLI::Range(100, 1'000'000))
      ->group(kGroupPicture);
}

Result<void> settle(StreamFlags& flags, Size view) {
  if (flags.size.width == 0) flags.size = view;
  return flags.url.empty() ? Result<void>() : capture::StreamOutput::check(flags.url, options_of(flags));
}

Result<std::unique_ptr<capture::StreamOutput>> open_stream(const StreamFlags& flags) {
  if (flags.url.empty()) return std::unique_ptr<capture::StreamOutput>();
  return capture::StreamOutput::open(flags.url, options_of(flags));
}

nlohmann::ordered_json to_json(const capture::StreamOutput& stream, const StreamFlags& flags) {
  const capture::StreamReport r = stream.report();
  const studio::Series latency = latency_of(r);
  nlohmann::ordered_json json = {{"to", stream.address()},
                                 {"width", flags.size.width},
                                 {"height", flags.size.height},
                                 {"fps", flags.fps},
                                 {"receivers", r.receivers},
                                 {"pictures", r.offered},
                                 {"sent", r.sent},
                                 {"dropped", {{"overtaken", r.overtaken}, {"unwatched", r.unwatched}}},
                                 {"instants_repeated", r.again},
                                 {"instants_missed", r.missed},
                                 {"bytes", r.bytes}};
  if (latency.count() > 0)
    json["latency_ms"] = {{"mean", latency.mean()},
                          {"p50", latency.percentile(0.5)},
                          {"p99", latency.percentile(0.99)},
                          {"max", latency.largest()}};
  if (!r.trouble.empty()) json["trouble"] = r.trouble;
  return json;
}

void print_stream(const capture::StreamOutput& stream) {
  const capture::StreamReport r = stream.report();
  const studio::Series latency = latency_of(r);
  const auto number = [](std::uint64_t n) { return static_cast<unsigned long long>(n); };
  std::printf("  stream: %llu of %llu pictures sent, %llu overtaken, %llu while nobody received",
              number(r.sent), number(r.offered), number(r.overtaken), number(r.unwatched));
  if (latency.count() > 0)
    std::printf("; exposure to packet p50 %.0f ms, p99 %.0f ms", latency.percentile(0.5),
                latency.percentile(0.99));
  std::printf("\n");
}

}  // namespace floatstage::apps
