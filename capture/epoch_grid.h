#pragma once

#include <cstdint>
#include <optional>

#include "core/time.h"

namespace floatstage::capture {

/// Numbers the instants of a recording: row 0 is the origin, and a row follows each period. The cameras'
/// common rate is known only nominally (crystals differ by 100 ppm, and fake cameras are off by more), so
/// phase and period follow the exposures through a slow loop; rows never slip against the cameras however
/// long the recording is.
///
/// A camera's own count says which row its picture should have; its time decides where the two disagree by
/// more than three quarters of a period. So jitter of less loses nothing, a camera that misses a trigger
/// without counting it is put back in its place, and a camera that runs freely at another phase stays in its
/// rows.
///
/// Not thread-safe. Results depend on the calls alone.
class EpochGrid {
 public:
  /// `frame_rate` > 0, nominal.
  EpochGrid(double frame_rate, Timestamp origin);

  /// The row of an exposure at `time`. `expected`: what the camera's count says; absent for its first
  /// picture. Negative before the origin.
  std::int64_t row_of(Timestamp time, std::optional<std::int64_t> expected);
  /// The row nearest to `time`, which is no exposure.
  std::int64_t nearest(Timestamp time) const;
  /// The instant of a row.
  Timestamp instant(std::int64_t row) const;

 private:
  double surprise(Timestamp time, std::int64_t row) const;  // ns

  double nominal_period_, period_;  // ns
  // The newest row that an exposure has been seen of, and its instant.
  std::int64_t anchor_row_ = 0;
  std::int64_t anchor_ns_;
  double anchor_rest_ = 0;  // the fraction of a nanosecond
};

}  // namespace floatstage::capture
