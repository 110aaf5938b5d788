#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "capture/sound/sound_record.h"

namespace floatstage::capture {

/// When the samples of one run were taken: on a line, since a sound card's clock is a crystal's.
struct SoundRun {
  std::int64_t first = 0, end = 0;  ///< samples of the track
  double start_ns = 0;              ///< of sample `first`, from SoundClock::origin()
  double rate = 0;                  ///< samples a second of the take's clock
  double ppm = 0;                   ///< how much faster than the device says
  double jitter_ns = 0;             ///< of the stamps about the line: the median of their distances
};

/// Maps samples to the take's clock. Each run has a line of its own, fitted to all of its stamps so that
/// those that are late (a recorder that was not scheduled) do not bend it: iteratively reweighted least
/// squares with Tukey's biweight, from the line through medians. A clock is nominal until its stamps say
/// otherwise: a term of 100 ppm, which crystals keep, stands against stamps that cannot tell over a short
/// time.
class SoundClock {
 public:
  SoundClock() = default;
  /// `samples`: of the track. Stamps beyond are ignored; so is a run that has none.
  SoundClock(const std::vector<SoundStamp>& stamps, int nominal_rate, std::int64_t samples);

  const std::vector<SoundRun>& runs() const { return runs_; }
  /// When the sample was taken; nothing without runs.
  std::optional<Timestamp> time_of(std::int64_t sample) const;
  /// Which sample of a run is taken at that time, with its fraction; outside of the run too.
  double sample_at(const SoundRun& run, Timestamp time) const;
  Timestamp start_of(const SoundRun& run) const;
  Timestamp end_of(const SoundRun& run) const;

 private:
  Timestamp origin_;
  std::vector<SoundRun> runs_;
};

}  // namespace floatstage::capture
