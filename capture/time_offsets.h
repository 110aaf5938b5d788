#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"
#include "core/rig.h"
#include "core/take_layout.h"
#include "core/time.h"

namespace floatstage::capture {

/// When a camera that runs freely really takes its pictures: at what its stamp says plus `offset`.
struct CameraTimeOffset {
  std::string serial;
  std::optional<Nanoseconds> offset;  ///< absent: not measured
  std::optional<Nanoseconds> sigma;   ///< one standard deviation; 0 of the reference
  std::string not_measured;           ///< why not
  bool operator==(const CameraTimeOffset&) const = default;
};

/// times.json of the take that they were measured on: {"floatstage_times": 1, "from": "silhouettes",
/// "cameras": [{"serial", "offset_ns", "sigma_ns"} or {"serial", "not_measured"}]}. Offsets are against one
/// of the cameras, whose own is 0.
struct TimeOffsetFile {
  std::string from;  ///< what they were measured by: "silhouettes", "targets"
  std::vector<CameraTimeOffset> cameras;
  bool operator==(const TimeOffsetFile&) const = default;
};

std::filesystem::path times_file(const TakeLayout& take);
std::string to_json(const TimeOffsetFile& times);
Result<TimeOffsetFile> parse_time_offsets(std::string_view json, std::string_view name_for_errors);
Result<TimeOffsetFile> load_time_offsets(const std::filesystem::path& file);
/// A take's own; without cameras where it has none.
Result<TimeOffsetFile> load_time_offsets(const TakeLayout& take);
Result<void> save_time_offsets(const TimeOffsetFile& times, const std::filesystem::path& file);

/// One a camera, in the order of `serials`; 0 for a camera that was not measured or is not there.
std::vector<Nanoseconds> offsets_of(const TimeOffsetFile& times, const std::vector<std::string>& serials);
std::vector<Nanoseconds> offsets_of(const TimeOffsetFile& times, const Rig& rig);

}  // namespace floatstage::capture
