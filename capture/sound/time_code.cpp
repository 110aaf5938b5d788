#include "capture/sound/time_code.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/file_presence.h"
#include "core/json_fields.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

struct Named {
  const char* name;
  TimeCodeRate rate;
};
constexpr std::array<Named, 6> kRates = {{{"23.976", {24, true, false}},
                                          {"24", {24, false, false}},
                                          {"25", {25, false, false}},
                                          {"29.97", {30, true, false}},
                                          {"29.97df", {30, true, true}},
                                          {"30", {30, false, false}}}};

constexpr std::int64_t kTenMinutes = 10 * 60 * 30 - 18;  // frames, of which numbers are dropped
constexpr std::int64_t kLatest = std::numeric_limits<std::int64_t>::max() / 4;

std::int64_t day_of(const TimeCodeRate& rate) {
  return rate.drop ? 144 * kTenMinutes : std::int64_t{24} * 3600 * rate.frames;
}

}  // namespace

std::optional<TimeCodeRate> time_code_rate_named(std::string_view name) {
  for (const Named& known : kRates)
    if (name == known.name) return known.rate;
  return std::nullopt;
}

std::string name_of(const TimeCodeRate& rate) {
  for (const Named& known : kRates)
    if (rate == known.rate) return known.name;
  return "";
}

std::optional<std::int64_t> frames_of(std::string_view code, const TimeCodeRate& rate) {
  if (code.size() != 11) return std::nullopt;
  std::array<int, 4> parts = {};
  for (std::size_t i = 0; i < 4; ++i) {
    const char a = code[3 * i], b = code[3 * i + 1];
    if (a < '0' || a > '9' || b < '0' || b > '9') return std::nullopt;
    if (i < 3 && code[3 * i + 2] != ':' && !(i == 2 && code[8] == ';')) return std::nullopt;
    parts[i] = (a - '0') * 10 + (b - '0');
  }
  const auto [hours, minutes, seconds, frames] = parts;
  if (hours > 23 || minutes > 59 || seconds > 59 || frames >= rate.frames) return std::nullopt;
  const std::int64_t all_minutes = hours * 60 + minutes;
  std::int64_t count = (all_minutes * 60 + seconds) * rate.frames + frames;
  if (rate.drop) {
    if (seconds == 0 && frames < 2 && minutes % 10 != 0) return std::nullopt;
    count -= 2 * (all_minutes - all_minutes / 10);
  }
  return count;
}

std::string code_of(std::int64_t count, const TimeCodeRate& rate) {
  const std::int64_t day = day_of(rate);
  count = (count % day + day) % day;
  if (rate.drop) {
    const std::int64_t tens = count / kTenMinutes, rest = count % kTenMinutes;
    count += 18 * tens;
    if (rest >= 1800) count += 2 * ((rest - 1800) / 1798 + 1);
  }
  const std::int64_t seconds = count / rate.frames;
  char code[32];
  std::snprintf(code, sizeof code, "%02d:%02d:%02d%c%02d", static_cast<int>(seconds / 3600),
                static_cast<int>(seconds / 60 % 60), static_cast<int>(seconds % 60), rate.drop ? ';' : ':',
                static_cast<int>(count % rate.frames));
  return code;
}

std::string TimeCode::code_at(Timestamp time) const {
  return code_of(frames + std::llround(seconds(time - at) * rate.hertz()), rate);
}

Timestamp time_of_code(const TimeCode& of, std::int64_t frames) {
  const std::int64_t day = day_of(of.rate);
  std::int64_t after = (frames - of.frames) % day;
  if (2 * after > day) after -= day;
  if (2 * after < -day) after += day;
  return of.at + Nanoseconds{std::llround(static_cast<double>(after) / of.rate.hertz() * 1e9)};
}

Result<TimeCode> parse_time_code(std::string_view json, std::string_view name) {
  const Result<nlohmann::json> document = parse_json(json, name);
  if (!document) return forward(document);
  JsonProblem problem;
  const std::string where(name);
  JsonFields fields(*document, where, problem);
  const int version = fields.integer("floatstage_time_code");
  if (!problem.first && version != 1)
    return fail(ErrorCode::Unsupported, text(name, ": format ", version, " of time code is not known; 1 is"));
  TimeCode code;
  const std::string rate = fields.string("rate"), digits = fields.string("code");
  const nlohmann::json* at = fields.child("at_ns");
  code.from = fields.string("from");
  fields.refuse_others();
  if (const std::optional<TimeCodeRate> known = time_code_rate_named(rate))
    code.rate = *known;
  else
    problem.note(where, text("'", rate, "' is no rate of time code"));
  if (const std::optional<std::int64_t> frames = frames_of(digits, code.rate))
    code.frames = *frames;
  else
    problem.note(where, text("'", digits, "' is no time code of ", rate, " frames a second"));
  if (at && at->is_number_integer() && at->get<std::int64_t>() < kLatest &&
      at->get<std::int64_t>() > -kLatest)
    code.at = {at->get<std::int64_t>()};
  else
    problem.note(where, "'at_ns' is no time");
  if (problem.first) return fail(ErrorCode::BadData, *problem.first);
  return code;
}

std::string to_json(const TimeCode& code) {
  return print_json({{"floatstage_time_code", 1},
                     {"rate", name_of(code.rate)},
                     {"code", code_of(code.frames, code.rate)},
                     {"at_ns", code.at.ns},
                     {"from", code.from}});
}

std::filesystem::path time_code_file(const TakeLayout& take) { return take.folder() / "timecode.json"; }

Result<std::optional<TimeCode>> load_time_code(const TakeLayout& take) {
  const std::filesystem::path file = time_code_file(take);
  if (!is_there(file)) return std::optional<TimeCode>();
  const Result<std::string> bytes = read_file(file);
  if (!bytes) return forward(bytes);
  Result<TimeCode> code = parse_time_code(*bytes, file.string());
  if (!code) return forward(code);
  return std::optional(std::move(*code));
}

Result<void> save_time_code(const TimeCode& code, const TakeLayout& take) {
  return write_file(time_code_file(take), to_json(code));
}

}  // namespace floatstage::capture
