#include <charconv>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/take/take_verbs.h"
#include "apps/terminal/flags.h"
#include "capture/sound/time_code.h"
#include "core/text.h"
#include "pipeline/derive/derived_take.h"
#include "pipeline/derive/list_takes.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

struct TakeTimeCodeArguments {
  fs::path take, out, json;
  std::string code, rate = "25", ltc;
};

// At the first picture, as a person says it.
Result<capture::TimeCode> by_hand(const TakeTimeCodeArguments& given, const capture::TakeReader& take) {
  const std::optional<capture::TimeCodeRate> rate = capture::time_code_rate_named(given.rate);
  const std::optional<std::int64_t> frames = rate ? capture::frames_of(given.code, *rate) : std::nullopt;
  if (!frames)
    return fail(ErrorCode::InvalidArgument, text("'", given.code, "' is no time code of ", given.rate,
                                                 " frames a second; write hh:mm:ss:ff"));
  const std::optional<Timestamp> first = pipeline::begin_of(take);
  if (!first) return fail(ErrorCode::InvalidArgument, text(given.take.string(), " has no picture"));
  return capture::TimeCode{*rate, *frames, *first, "hand"};
}

// "sound:1": a track and a channel, counted from 0.
Result<capture::TimeCode> from_ltc(const TakeTimeCodeArguments& given, const capture::TakeReader& take) {
  const std::size_t colon = given.ltc.rfind(':');
  int channel = 0;
  if (colon != std::string::npos) {
    const char *at = given.ltc.data() + colon + 1, *end = given.ltc.data() + given.ltc.size();
    if (const auto [next, error] = std::from_chars(at, end, channel); error != std::errc() || next != end)
      return fail(ErrorCode::InvalidArgument,
                  text("'", given.ltc, "' names no channel; write TRACK:CHANNEL"));
  }
  const Result<std::vector<capture::SoundTrack>> tracks = capture::load_sound_tracks(take.layout());
  if (!tracks) return forward(tracks);
  const Result<capture::SoundTrack> track = capture::sound_track_named(*tracks, given.ltc.substr(0, colon));
  if (!track) return forward(track);
  const Result<std::unique_ptr<capture::SoundReader>> sound =
      capture::SoundReader::open(take.layout(), *track);
  if (!sound) return forward(sound);
  return capture::read_ltc(**sound, channel);
}

Result<void> run_take_time_code(const TakeTimeCodeArguments& given) {
  if (given.code.empty() == given.ltc.empty())
    return fail(ErrorCode::InvalidArgument, "say where the time code comes from: either --code or --ltc");
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  const Result<capture::TimeCode> code = given.ltc.empty() ? by_hand(given, **take) : from_ltc(given, **take);
  if (!code) return forward(code);
  const Result<pipeline::DerivedReport> report = pipeline::derive_take(
      **take,
      {.rig = std::nullopt, .how = text("set-time-code ", code->from), .label = "", .time_code = *code},
      given.out);
  if (!report) return forward(report);
  const std::string first = code->code_at(pipeline::begin_of(**take).value_or(code->at));
  std::printf("%s: begins at %s, %s frames a second\n", given.out.c_str(), first.c_str(),
              capture::name_of(code->rate).c_str());
  if (given.json.empty()) return {};
  return pipeline::save_json({{"take", given.out.string()},
                              {"from", given.take.string()},
                              {"begins", first},
                              {"rate", capture::name_of(code->rate)},
                              {"source", code->from}},
                             given.json);
}

}  // namespace

void add_take_set_time_code(CLI::App& take, Chosen& chosen) {
  auto options = std::make_shared<TakeTimeCodeArguments>();
  CLI::App* verb = add_verb(take, chosen, "set-time-code",
                            "The same recording with time code, as a new take: by hand or from LTC",
                            {"floatstage take set-time-code T --code 10:00:00:00 --rate 25 -o coded",
                             "floatstage take set-time-code T --ltc sound:1 -o coded"});
  add_take(*verb, options->take);
  add_out(*verb, options->out, "The new take's folder; it shares the media")->required();
  verb->add_option("--code", options->code, "The code of the first picture")->type_name("HH:MM:SS:FF");
  verb->add_option("--rate", options->rate, "Frames a second of --code")
      ->capture_default_str()
      ->check(CLI::IsMember({"23.976", "24", "25", "29.97", "29.97df", "30"}));
  verb->add_option("--ltc", options->ltc,
                   "The sound track, and its channel from 0 on, that has linear time code")
      ->type_name("TRACK:CHANNEL");
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_take_time_code(*options); }; });
}

}  // namespace floatstage::apps
