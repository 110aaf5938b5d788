#pragma once

#include <cstdint>
#include <vector>

#include "capture/sound/sound_reader.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// A clap in a track: the sample at which its wave begins, and how loud it is.
struct SoundClap {
  std::int64_t sample = 0;
  double strength = 0;
};

/// The claps of a track, in their order, the 200 loudest: short sounds that begin at once out of a quarter of
/// a second of quiet (20 dB below), stand out from all of the recording by 20 dB and are over soon after (10
/// dB after a quarter of a second). What a recording begins with is none, however loud, since nobody heard
/// what was before; nor is noise that goes on. All channels are heard as one; what needs memory is a number
/// a millisecond. Io; Cancelled.
Result<std::vector<SoundClap>> claps_in(capture::SoundReader& sound, Progress* progress);

}  // namespace floatstage::pipeline
