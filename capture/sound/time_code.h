#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "capture/sound/sound_reader.h"

namespace floatstage::capture {

/// How time code counts (SMPTE ST 12-1).
struct TimeCodeRate {
  int frames = 25;    ///< in a counted second: 24, 25 or 30
  bool ntsc = false;  ///< seconds are 1001/1000 long
  bool drop = false;  ///< two numbers a minute are left out, but for every tenth: of 30 with ntsc
  bool operator==(const TimeCodeRate&) const = default;

  double hertz() const { return ntsc ? frames / 1.001 : frames; }
};
/// "23.976", "24", "25", "29.97", "29.97df", "30".
std::optional<TimeCodeRate> time_code_rate_named(std::string_view name);
std::string name_of(const TimeCodeRate& rate);

/// Frames since 00:00:00:00; nothing for a code that its rate does not have. "hh:mm:ss:ff", with ';' before
/// the frames where numbers are dropped (read alike).
std::optional<std::int64_t> frames_of(std::string_view code, const TimeCodeRate& rate);
/// After 24 hours it begins again; before 0 too.
std::string code_of(std::int64_t frames, const TimeCodeRate& rate);

/// The time code of a take: what it was at one instant of the take's clock. It runs at its rate from there.
struct TimeCode {
  TimeCodeRate rate;
  std::int64_t frames = 0;  ///< at `at`
  Timestamp at;
  std::string from;  ///< "hand", "ltc sound:1"
  bool operator==(const TimeCode&) const = default;

  /// The code nearest to an instant.
  std::string code_at(Timestamp time) const;
};

/// timecode.json: {"floatstage_time_code": 1, "rate": "25", "code": "10:00:00:00", "at_ns", "from"}.
Result<TimeCode> parse_time_code(std::string_view json, std::string_view name_for_errors);
std::string to_json(const TimeCode& code);
std::filesystem::path time_code_file(const TakeLayout& take);
/// A take's; nothing where it has none.
Result<std::optional<TimeCode>> load_time_code(const TakeLayout& take);
Result<void> save_time_code(const TimeCode& code, const TakeLayout& take);

/// The linear time code (LTC) on a channel of a track, from 0 on, by its clock: the median over all frames
/// that were heard, so that a few that were misread do not matter. BadData when there is none, or it jumps.
Result<TimeCode> read_ltc(SoundReader& sound, int channel);

/// The same of a recorder that ran on the take's time code, and whose own clock is not the take's: when each
/// frame of its LTC was, by `of`, the take's. Those that lie on one line. BadData when there is none, another
/// rate, or it jumps.
Result<std::vector<SoundStamp>> ltc_stamps(SoundReader& sound, int channel, const TimeCode& of);

/// When a code of a take's rate was, of all days the one nearest to the take's anchor.
Timestamp time_of_code(const TimeCode& of, std::int64_t frames);

}  // namespace floatstage::capture
