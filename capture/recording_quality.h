#pragma once

#include <map>
#include <optional>

#include "capture/recorder.h"

namespace floatstage {

/// Judges a recording from the facts of its frames, in any order of cameras. Not thread-safe.
class QualityMeter {
 public:
  QualityMeter(std::vector<std::string> serials, double frame_rate, RecordingLimits limits);

  /// A picture went into `row`.
  void recorded(int camera, std::uint64_t row, const FrameInfo& info);
  void duplicate(int camera) { ++cameras_[static_cast<std::size_t>(camera)].quality.duplicates; }
  void queue_peak(int camera, std::size_t frames) {
    cameras_[static_cast<std::size_t>(camera)].quality.queue_peak = frames;
  }

  RecordingQuality judge() const;

 private:
  struct Camera {
    RecordedCamera quality;
    std::optional<Timestamp> first, last;
    std::uint64_t first_row = 0, last_row = 0;
  };
  struct Instant {
    Timestamp earliest, latest;
  };
  void complain(RecordingQuality& quality) const;

  double frame_rate_;
  RecordingLimits limits_;
  std::vector<Camera> cameras_;
  std::vector<std::optional<Instant>> instants_;  // by row
};

}  // namespace floatstage
