#pragma once

#include <filesystem>
#include <memory>

#include "core/image.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Where a film's pictures go: a video file, or a folder of PNGs. Nothing stands under the final name before
/// finish().
class PictureSink {
 public:
  virtual ~PictureSink() = default;
  virtual Result<void> write(const Image& rgb) = 0;
  virtual Result<void> finish() = 0;
};

/// "*.mp4", "*.mkv", "*.mov": H.264; a name without extension: a new folder of 000000.png, 000001.png, …
/// AlreadyExists when something is there already.
Result<std::unique_ptr<PictureSink>> open_picture_sink(const std::filesystem::path& out, int width,
                                                       int height, double frame_rate);

}  // namespace floatstage::pipeline
