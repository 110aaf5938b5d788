#include "capture/epoch_grid.h"

#include <algorithm>
#include <cmath>

namespace floatstage::capture {
namespace {

// Critically damped (beta = alpha^2 / (2 - alpha)), over some twenty rows: jitter of single exposures hardly
// moves the grid, and a rate that is off by 1 % is followed within a tenth of a period.
constexpr double kPhaseGain = 0.1;
constexpr double kPeriodGain = kPhaseGain * kPhaseGain / (2 - kPhaseGain);
constexpr double kPeriodBound = 0.02;
// Of a period: how far a picture may be from the row that its camera's count gives it.
constexpr double kTrustInCount = 0.75;

}  // namespace

EpochGrid::EpochGrid(double frame_rate, Timestamp origin)
    : nominal_period_(1e9 / frame_rate), period_(nominal_period_), anchor_ns_(origin.ns) {}

double EpochGrid::surprise(Timestamp time, std::int64_t row) const {
  return static_cast<double>(time.ns - anchor_ns_) - anchor_rest_ -
         static_cast<double>(row - anchor_row_) * period_;
}

std::int64_t EpochGrid::nearest(Timestamp time) const {
  return anchor_row_ + std::llround(surprise(time, anchor_row_) / period_);
}

Timestamp EpochGrid::instant(std::int64_t row) const {
  return {anchor_ns_ + std::llround(anchor_rest_ + static_cast<double>(row - anchor_row_) * period_)};
}

std::int64_t EpochGrid::row_of(Timestamp time, std::optional<std::int64_t> expected) {
  std::int64_t row = nearest(time);
  if (expected && std::abs(surprise(time, *expected)) <= kTrustInCount * period_) row = *expected;
  if (row <= anchor_row_) return row;
  // The first exposure of a new row carries the grid on.
  const double off = surprise(time, row);
  const auto steps = static_cast<double>(row - anchor_row_);
  const double moved = anchor_rest_ + steps * period_ + kPhaseGain * off;
  const std::int64_t whole = std::llround(moved);
  anchor_ns_ += whole;
  anchor_rest_ = moved - static_cast<double>(whole);
  anchor_row_ = row;
  period_ = std::clamp(period_ + kPeriodGain * off / steps, nominal_period_ * (1 - kPeriodBound),
                       nominal_period_ * (1 + kPeriodBound));
  return row;
}

}  // namespace floatstage::capture
