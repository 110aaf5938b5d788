#pragma once

#include <vector>

#include "core/image.h"
#include "matting/video/video_matting.h"
#include "tests/matting/clip_scores.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"
#include "tests/support/temp_folder.h"

namespace floatstage::matting {

/// The mattes of a clip by spectral video matting when only the first frame's matte is known. `fitting`
/// counts the frames that components made, the others were carried by closed form.
struct SpectralResult {
  std::vector<Image> mattes;
  int fitting = 0;
};

inline SpectralResult spectral_mattes(const MatteClip& clip, const VideoMattingOptions& options = {}) {
  TempFolder cache;
  SpectralResult result;
  auto video = VideoMatting::create(
      {static_cast<int>(clip.frames.size()),
       [&](int frame) -> Result<Image> { return clip.frames[static_cast<std::size_t>(frame)]; }},
      cache.path(), options);
  EXPECT_THAT(video, IsOk());
  EXPECT_THAT(video->prepare(), IsOk());
  EXPECT_THAT(video->set_keyframe(0, {clip.truth[0], {}}), IsOk());
  EXPECT_THAT(video->propagate(), IsOk());
  for (int frame = 0; frame < video->frames(); ++frame) {
    auto matte = video->working_matte(frame);
    EXPECT_THAT(matte, IsOk());
    result.mattes.push_back(std::move(*matte));
    result.fitting += video->report(frame).fits;
  }
  return result;
}

}  // namespace floatstage::matting
