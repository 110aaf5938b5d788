#pragma once

#include <map>
#include <optional>

#include "capture/recorder.h"

namespace floatstage::capture {

/// Judges a recording from the facts of its frames, in any order of cameras. Not thread-safe.
class QualityMeter {
 public:
  QualityMeter(std::vector<std::string> serials, double frame_rate, RecordingLimits limits);

  /// A picture went into `row`. `counted`: by how many pictures the camera's own count went on since its last
  /// one here; absent where it began anew.
  void recorded(int camera, std::uint64_t row, const FrameInfo& info, std::optional<std::uint64_t> counted);
  /// `rows` rows after its last picture have none.
  void missing_at_end(int camera, std::uint64_t rows) {
    cameras_[static_cast<std::size_t>(camera)].quality.skips += rows;
  }
  void failed(int camera, std::uint64_t pictures) {
    cameras_[static_cast<std::size_t>(camera)].quality.failed = pictures;
  }
  /// Pictures of its own count that went into no row: lost, but for the last, a duplicate.
  void counted_elsewhere(int camera, std::uint64_t pictures);
  void duplicate(int camera) { ++cameras_[static_cast<std::size_t>(camera)].quality.duplicates; }
  void queue_peak(int camera, std::size_t frames) {
    cameras_[static_cast<std::size_t>(camera)].quality.queue_peak = frames;
  }

  RecordingQuality judge() const;

 private:
  struct Camera {
    RecordedCamera quality;
    std::optional<Timestamp> first, last;
    std::uint64_t last_row = 0;
    std::uint64_t rows_before_first = 0;
    std::uint64_t skips_between = 0;  // its first picture and its last
    std::uint64_t counted = 0;        // pictures by its own count, since the first
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

}  // namespace floatstage::capture
