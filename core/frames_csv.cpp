#include <array>
#include <charconv>

#include "core/take_layout.h"
#include "core/text.h"

namespace floatstage {
namespace {

constexpr std::string_view kHeader =
    "sequence,device_time_ns,studio_time_ns,exposure_ns,status,media_index\n";

enum Field { kSequence, kDeviceTime, kStudioTime, kExposure, kStatus, kMediaIndex, kFields };
using Fields = std::array<std::string_view, kFields>;

std::optional<Fields> split(std::string_view line) {
  Fields fields;
  for (std::size_t i = 0; i < kFields; ++i) {
    const std::size_t comma = line.find(',');
    if ((comma == std::string_view::npos) != (i + 1 == kFields)) return std::nullopt;
    fields[i] = line.substr(0, comma);
    line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
  }
  return fields;
}

template <class T>
bool read(std::string_view field, T& value) {
  const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
  return error == std::errc() && end == field.data() + field.size();
}

// An empty field is an absent value; false when it is neither empty nor a number.
bool read_optional(std::string_view field, std::optional<std::int64_t>& value) {
  if (field.empty()) return true;
  std::int64_t number = 0;
  if (!read(field, number)) return false;
  value = number;
  return true;
}

// What is wrong with a line, or nothing.
std::optional<std::string> read_row(std::string_view line, FrameRow& row) {
  const std::optional<Fields> split_line = split(line);
  if (!split_line) return text("not ", static_cast<int>(kFields), " fields");
  const Fields& f = *split_line;
  std::optional<std::int64_t> device_time, exposure;
  if (!read(f[kSequence], row.info.sequence)) return "the sequence is not a number";
  if (!read(f[kStudioTime], row.info.exposure_start.ns))
    return "the studio time is not a number of nanoseconds";
  if (!read_optional(f[kDeviceTime], device_time)) return "the device time is not a number of nanoseconds";
  if (!read_optional(f[kExposure], exposure)) return "the exposure is not a number of nanoseconds";
  if (!read_optional(f[kMediaIndex], row.media_index) || row.media_index.value_or(0) < 0)
    return "the media index is not a whole number from 0";
  if (device_time) row.info.device_time = Nanoseconds{*device_time};
  if (exposure) row.info.exposure = Nanoseconds{*exposure};
  const std::optional<FrameStatus> status = frame_status_named(f[kStatus]);
  if (!status) return text("unknown status '", f[kStatus], "'");
  row.info.status = *status;
  if (*status == FrameStatus::Lost && row.media_index) return "a lost frame has a picture";
  return std::nullopt;
}

}  // namespace

std::string frames_csv_header() { return std::string(kHeader); }

std::string to_csv(const FrameRow& row) {
  auto optional = [](const auto& value) { return value ? text(*value) : std::string(); };
  auto nanoseconds = [](const std::optional<Nanoseconds>& value) {
    return value ? text(value->count) : std::string();
  };
  return text(row.info.sequence, ',', nanoseconds(row.info.device_time), ',', row.info.exposure_start.ns, ',',
              nanoseconds(row.info.exposure), ',', name_of(row.info.status), ',', optional(row.media_index),
              '\n');
}

Result<std::vector<FrameRow>> parse_frames_csv(std::string_view csv, int camera, std::string_view name) {
  std::vector<FrameRow> rows;
  // The recorder may have been killed before the header was out.
  if (csv.size() < kHeader.size() && kHeader.starts_with(csv)) return rows;
  if (!csv.starts_with(kHeader))
    return fail(ErrorCode::BadData, text(name, ": line 1: not the header of a frames.csv (",
                                         kHeader.substr(0, kHeader.size() - 1), ")"));
  csv.remove_prefix(kHeader.size());
  for (std::size_t line = 2;; ++line) {
    const std::size_t end = csv.find('\n');
    if (end == std::string_view::npos) return rows;  // the end, or a line cut off mid-write
    FrameRow row;
    row.info.camera = camera;
    if (const std::optional<std::string> wrong = read_row(csv.substr(0, end), row))
      return fail(ErrorCode::BadData,
                  text(name, ": line ", line, ": ", *wrong, "; the take's side file was damaged or edited"));
    rows.push_back(row);
    csv.remove_prefix(end + 1);
  }
}

}  // namespace floatstage
