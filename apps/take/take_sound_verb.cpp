#include <charconv>
#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/take/take_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "core/log.h"
#include "core/text.h"
#include "pipeline/derive/set_sound.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

struct TakeSoundArguments {
  fs::path json;
  pipeline::SetSoundOptions sound;
  std::string at, clap;
  bool stamp = false;
  int ltc = -1;
};

// "12.25" or "10:00:03:11".
Result<pipeline::SoundPlace> said_place(const std::string& at) {
  if (at.find(':') != std::string::npos) return pipeline::SoundPlace(pipeline::SoundAtCode{at});
  constexpr double kMost = 1e6;  // a take of eleven days
  double seconds = 0;
  const char *begin = at.data(), *end = begin + at.size();
  const auto [next, error] = std::from_chars(begin, end, seconds);
  if (error != std::errc() || next != end || !(std::abs(seconds) <= kMost))
    return fail(ErrorCode::InvalidArgument,
                text("--at: '", at,
                     "' is neither seconds after the first picture, up to a million either way, "
                     "nor a time code hh:mm:ss:ff"));
  return pipeline::SoundPlace(pipeline::SoundAt{seconds});
}

Result<pipeline::SoundPlace> place_of(const TakeSoundArguments& given) {
  const int said = (given.at.empty() ? 0 : 1) + (given.clap.empty() ? 0 : 1) + (given.stamp ? 1 : 0) +
                   (given.ltc >= 0 ? 1 : 0);
  if (said != 1)
    return fail(ErrorCode::InvalidArgument,
                "say by what the sound finds its place: one of --at, --clap, --stamp and --ltc");
  if (!given.at.empty()) return said_place(given.at);
  if (!given.clap.empty()) return pipeline::SoundPlace(pipeline::SoundByClap{given.clap == "flash"});
  if (given.stamp) return pipeline::SoundPlace(pipeline::SoundByStamp{});
  return pipeline::SoundPlace(pipeline::SoundByLtc{given.ltc});
}

std::string signs_of(const TakeSoundArguments& given, const pipeline::SetSoundReport& report) {
  if (report.signs == 0) return "";
  const std::string sign = given.ltc >= 0          ? "frames of time code"
                           : given.clap == "flash" ? "claps that met flashes"
                                                   : "claps that met the take's";
  char said[160];
  std::snprintf(said, sizeof said, ", by %d %s (off by %.2f ms in the median)%s", report.signs, sign.c_str(),
                1e3 * report.spread,
                report.signs > 1
                    ? text("; its clock ran ", std::round(report.ppm * 10) / 10, " ppm fast").c_str()
                    : "");
  return said;
}

Result<void> run_take_sound(const TakeSoundArguments& given) {
  pipeline::SetSoundOptions options = given.sound;
  const Result<pipeline::SoundPlace> place = place_of(given);
  if (!place) return forward(place);
  options.place = *place;
  ProgressBar progress;
  options.progress = &progress;
  const Result<pipeline::SetSoundReport> report = pipeline::set_sound(options);
  if (!report) return forward(report);
  for (const std::string& note : report->take.notes) log::info(note);
  std::printf("%s: sound '%s' lasts %.3f s from %+.4f s on%s\n", options.out.c_str(),
              report->track.name.c_str(), report->seconds, report->begins, signs_of(given, *report).c_str());
  if (given.json.empty()) return {};
  return pipeline::save_json({{"take", options.out.string()},
                              {"from", options.take.string()},
                              {"file", options.file.string()},
                              {"track", report->track.name},
                              {"rate", report->track.rate},
                              {"channels", report->track.channels},
                              {"bits", report->track.bits},
                              {"begins", report->begins},
                              {"seconds", report->seconds},
                              {"ppm", report->ppm},
                              {"signs", report->signs},
                              {"spread_ms", 1e3 * report->spread},
                              {"shared_bytes", report->take.shared},
                              {"copied_bytes", report->take.copied},
                              {"notes", report->take.notes}},
                             given.json);
}

}  // namespace

void add_take_set_sound(CLI::App& take, Chosen& chosen) {
  auto options = std::make_shared<TakeSoundArguments>();
  CLI::App* verb =
      add_verb(take, chosen, "set-sound", "The same recording with another recorder's sound, as a new take",
               {"floatstage take set-sound T recorder.wav --clap sound -o with-sound",
                "floatstage take set-sound T music.flac --at 2.5 --name music -o danced"});
  add_take(*verb, options->sound.take);
  verb->add_option("file", options->sound.file,
                   "A recording of sound: WAV, FLAC, or whatever else libav reads")
      ->required();
  add_out(*verb, options->sound.out, "The new take's folder; it shares the media")->required();
  verb->add_option("--at", options->at,
                   "It begins so many seconds after the first picture, or at this time code")
      ->type_name("SECONDS|HH:MM:SS:FF");
  verb->add_option("--clap", options->clap,
                   "Claps in it are those of the take's own sound, or flashes in its pictures")
      ->check(one_of({"sound", "flash"}));
  verb->add_flag("--stamp", options->stamp,
                 "Its file says when it began (Broadcast Wave), by the take's time code");
  verb->add_option("--ltc", options->ltc, "Its channel, from 0 on, that has the take's linear time code")
      ->check(CLI::NonNegativeNumber)
      ->type_name("CHANNEL");
  verb->add_option("--name", options->sound.name, "The track's name (default: the file's)")
      ->type_name("NAME");
  verb->add_option("--label", options->sound.label, "The new take's label (default: as it was)");
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_take_sound(*options); }; });
}

}  // namespace floatstage::apps
