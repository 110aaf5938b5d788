#pragma once

#include <string>
#include <vector>

#include "calib/silhouettes/silhouette_times.h"
#include "capture/take.h"
#include "capture/time_offsets.h"
#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// Frames in which one camera shows the same silhouette, to the last point, while most others' change.
struct Standstill {
  std::size_t camera = 0;
  int first = 0, last = 0;  ///< frames
};

struct TakeTimes {
  calib::TimeOffsets offsets;           ///< in frames, what is left beside the take's stamps
  capture::TimeOffsetFile file;         ///< the same in nanoseconds, for the synchroniser
  std::vector<Standstill> standstills;  ///< of four frames and more, a camera's longest
  /// Sentences: cameras that are measured too poorly to be used, and those that the synchroniser leaves out
  /// of live sets once it knows their instants, with what to do.
  std::vector<std::string> warnings;
};

/// The sigma above which an offset is no longer good for its purpose, in frames: the share of a frame that
/// offsets are to be known to.
inline constexpr double kSureFrames = 0.05;

/// When the cameras of a take really took their pictures, from how silhouettes move
/// (calib::measure_time_offsets()): `frames`, in a row, of a take that has mattes. What the cameras' stamps
/// say already, by which they may be a constant apart, counts: an offset is what must be added to a stamp.
/// Errors: InvalidArgument for frames that do not follow one another, and as measure_time_offsets();
/// NotFound for a take without a frame rate.
Result<TakeTimes> measure_take_times(const capture::TakeReader& take, const std::vector<int>& frames,
                                     const calib::TimeOffsetOptions& options, Progress* progress);

}  // namespace floatstage::pipeline
