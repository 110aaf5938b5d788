// docs/adr/0273-time-code.md

#include <algorithm>
#include <array>
#include <cmath>

#include <ltc.h>

#include "capture/sound/time_code.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

struct Closes {
  void operator()(LTCDecoder* decoder) const { ltc_decoder_free(decoder); }
};

struct Heard {
  std::int64_t sample = 0;
  int hours = 0, minutes = 0, seconds = 0, frame = 0;
  bool drop = false;
};

constexpr std::size_t kFewest = 10;  // frames: fewer may be noise
constexpr double kAgree = 0.8;       // of them, on one count
constexpr double kSameRate = 0.02;   // 24 and 25 are 4 % apart
constexpr double kMostLtcPpm = 300;  // between two clocks; 29.97 and 30 are 1000 apart

Result<std::vector<Heard>> hear(SoundReader& sound, int channel) {
  const auto channels = static_cast<std::size_t>(sound.track().channels);
  // It adapts to other speeds than the one that it begins with.
  const std::unique_ptr<LTCDecoder, Closes> decoder(ltc_decoder_create(sound.track().rate / 25, 64));
  FLOATSTAGE_CHECK(decoder != nullptr, "out of memory");
  std::vector<Heard> heard;
  constexpr std::size_t kAtOnce = 1024;  // less than a frame: the queue never overflows
  std::vector<float> levels(kAtOnce * channels);
  std::array<float, kAtOnce> own = {};
  for (std::int64_t at = 0; at < sound.samples(); at += kAtOnce) {
    if (Result<void> ok = sound.read(at, levels); !ok) return forward(ok);
    for (std::size_t i = 0; i < kAtOnce; ++i)
      own[i] = levels[i * channels + static_cast<std::size_t>(channel)];
    ltc_decoder_write_float(decoder.get(), own.data(), kAtOnce, at);
    LTCFrameExt frame = {};
    while (ltc_decoder_read(decoder.get(), &frame) > 0) {
      SMPTETimecode time = {};
      ltc_frame_to_time(&time, &frame.ltc, 0);
      if (frame.reverse == 0)
        heard.push_back(
            {frame.off_start, time.hours, time.mins, time.secs, time.frame, frame.ltc.dfbit != 0});
    }
  }
  if (heard.size() < kFewest || sound.clock().runs().empty())
    return fail(ErrorCode::BadData, text("no time code is heard (", heard.size(), " frames of LTC)"));
  return heard;
}

std::string digits_of(const Heard& h) {
  char digits[16];
  std::snprintf(digits, sizeof digits, "%02d:%02d:%02d:%02d", h.hours % 100, h.minutes % 100, h.seconds % 100,
                h.frame % 100);
  return digits;
}

Result<void> check_channel(const SoundReader& sound, int channel) {
  if (channel >= 0 && channel < sound.track().channels) return {};
  return fail(ErrorCode::InvalidArgument, text("sound '", sound.track().name, "', channel ", channel,
                                               ": there are ", sound.track().channels, " channels"));
}

}  // namespace

Result<TimeCode> read_ltc(SoundReader& sound, int channel) {
  const std::string name = text("sound '", sound.track().name, "', channel ", channel);
  if (Result<void> ok = check_channel(sound, channel); !ok) return forward(ok);
  const Result<std::vector<Heard>> heard = hear(sound, channel);
  const auto none = [&](const std::string& why) {
    return fail(ErrorCode::BadData,
                text(name, ": ", why, "; name another channel, or give the code by hand"));
  };
  if (!heard && heard.error().code == ErrorCode::BadData) return none(heard.error().message);
  if (!heard) return forward(heard);
  std::vector<double> apart;
  std::size_t drops = 0;
  for (std::size_t i = 1; i < heard->size(); ++i)
    apart.push_back(
        seconds(*sound.clock().time_of((*heard)[i].sample) - *sound.clock().time_of((*heard)[i - 1].sample)));
  for (const Heard& h : *heard) drops += h.drop ? 1 : 0;
  const bool drop = 2 * drops > heard->size();
  // Rates a thousandth apart are told by the whole recording, whose middle distance is exact to a sample
  // only.
  const double middle = median(apart);
  const auto usual = [&](double d) { return std::abs(d - middle) < 0.05 * middle; };
  double sum = 0, count = 0;
  for (const double d : apart)
    if (usual(d)) sum += d, ++count;
  const double hertz = count / sum;
  TimeCode code;
  double nearest = 1e9;
  for (const char* rate : {"23.976", "24", "25", "29.97", "29.97df", "30"}) {
    const TimeCodeRate known = *time_code_rate_named(rate);
    const double off = std::abs(known.hertz() - hertz);
    if (known.drop == drop && off < nearest) nearest = off, code.rate = known;
  }
  if (nearest > 0.01 * hertz) return none(text("LTC of ", hertz, " frames a second, which no rate is"));
  // What the count was at sample 0, by each frame.
  const Timestamp begin = *sound.clock().time_of(0);
  std::vector<double> counts;
  for (const Heard& h : *heard) {
    if (const std::optional<std::int64_t> frames = frames_of(digits_of(h), code.rate))
      counts.push_back(static_cast<double>(*frames) -
                       seconds(*sound.clock().time_of(h.sample) - begin) * code.rate.hertz());
  }
  if (counts.size() < kFewest) return none("its LTC counts what no clock does");
  const double at_begin = median(counts);
  const auto agreeing =
      std::count_if(counts.begin(), counts.end(), [&](double c) { return std::abs(c - at_begin) < 0.5; });
  if (static_cast<double>(agreeing) < kAgree * static_cast<double>(heard->size()))
    return none(text("its time code jumps: ", agreeing, " of ", heard->size(), " frames count as one clock"));
  // The anchor lies where a frame begins.
  code.frames = static_cast<std::int64_t>(std::ceil(at_begin - 1e-6));
  code.at =
      begin +
      Nanoseconds{std::llround((static_cast<double>(code.frames) - at_begin) / code.rate.hertz() * 1e9)};
  const std::int64_t day = frames_of("23:59:59:23", code.rate).value_or(0);
  if (code.frames < 0 || code.frames > day)
    code.frames = *frames_of(code_of(code.frames, code.rate), code.rate);
  code.from = text("ltc ", sound.track().name, ":", channel);
  return code;
}

Result<std::vector<SoundStamp>> ltc_stamps(SoundReader& sound, int channel, const TimeCode& of) {
  if (Result<void> ok = check_channel(sound, channel); !ok) return forward(ok);
  const Result<std::vector<Heard>> heard = hear(sound, channel);
  if (!heard) return forward(heard);
  const auto bad = [](const auto&... why) { return fail(ErrorCode::BadData, text(why...)); };
  std::vector<SoundStamp> stamps;
  std::size_t drops = 0;
  for (const Heard& h : *heard) {
    drops += h.drop ? 1 : 0;
    const std::optional<std::int64_t> frames = frames_of(digits_of(h), of.rate);
    if (frames && (stamps.empty() || h.sample > stamps.back().sample))
      stamps.push_back({h.sample, time_of_code(of, *frames), 0});
  }
  const std::string rate = name_of(of.rate);
  if ((2 * drops > heard->size()) != of.rate.drop)
    return bad("its LTC ", of.rate.drop ? "drops no" : "drops", " frame numbers, the take's time code of ",
               rate, of.rate.drop ? " does" : " does not");
  // Of other numbers a second the counts meet once in each.
  std::vector<double> apart;
  for (std::size_t i = 1; i < heard->size(); ++i)
    apart.push_back(static_cast<double>((*heard)[i].sample - (*heard)[i - 1].sample));
  if (const double hertz = sound.track().rate / median(apart);
      std::abs(hertz / of.rate.hertz() - 1) > kSameRate)
    return bad("its LTC has ", hertz, " frames a second, the take's time code ", rate);
  if (stamps.size() < kFewest) return bad("its LTC counts what time code of ", rate, " never does");
  const int nominal = sound.track().rate;
  const SoundClock clock(stamps, nominal, sound.samples());
  std::vector<SoundStamp> agreeing;
  for (const SoundStamp& s : stamps)
    if (std::abs(seconds(*clock.time_of(s.sample) - s.time)) * of.rate.hertz() < 0.5) agreeing.push_back(s);
  if (static_cast<double>(agreeing.size()) < kAgree * static_cast<double>(heard->size()))
    return bad("its time code jumps, or is none of ", rate,
               " frames a second as the take's: ", agreeing.size(), " of ", heard->size(),
               " frames count as one clock");
  if (const double ppm = clock.runs().front().ppm; std::abs(ppm) > kMostLtcPpm)
    return bad("its time code runs ", ppm * 1e-4, " % faster than the take's ", rate,
               ", which no clock does: its rate is another one");
  return agreeing;
}

}  // namespace floatstage::capture
