#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/sound/film_sound.h"
#include "capture/take.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// A stretch of a film in which the take plays as it was recorded, so that its sound is heard.
struct SoundCut {
  std::int64_t first = 0, end = 0;  ///< samples of the film, capture::kPlayOutRate a second
  Timestamp from;                   ///< of the take, at sample `first`
  double speed = 1;                 ///< seconds of the take a second of the film: what their clocks differ by
};

/// Where a film whose picture p shows frame frames[p] has sound: where pictures go on as fast as they were
/// recorded. Stills, slow and fast motion and pictures without times are silent; a jump begins a new cut.
std::vector<SoundCut> sound_cuts(const capture::TakeReader& take, const std::vector<int>& frames,
                                 double frame_rate);

/// The channels of a track that are heard: its first two, without that which the take's time code was read
/// from (TimeCode::from), which nobody wants to hear.
std::vector<int> heard_channels(const capture::SoundTrack& track, const std::string& time_code);

/// The sound of a film of these pictures, of the take's track of this name (the first for ""): one channel or
/// its first two, without that of the take's LTC. Cuts are faded for 5 ms. Nothing where the take has none or
/// no cut is heard. NotFound names the tracks that there are; errors of SoundReader.
class FilmSounds {
 public:
  static Result<std::unique_ptr<FilmSounds>> open(const capture::TakeReader& take,
                                                  const std::vector<int>& frames, double frame_rate,
                                                  const std::string& track);
  virtual ~FilmSounds() = default;
  virtual const capture::FilmSound& sound() const = 0;  ///< lives as long as this
  virtual std::string track() const = 0;
  virtual double seconds() const = 0;  ///< that are heard
};

}  // namespace floatstage::pipeline
