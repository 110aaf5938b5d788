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
  virtual Result<void> write(const Image& picture) = 0;
  virtual Result<void> finish() = 0;
};

/// The name without a slash at its end, which shells add to folders' names.
std::filesystem::path film_name(const std::filesystem::path& out);

/// Whether a film can be put there: AlreadyExists, or InvalidArgument for a name that says no kind of film,
/// or one that holds no opacity (`with_opacity`).
Result<void> check_film_name(const std::filesystem::path& out, bool with_opacity);

/// "*.mp4", "*.mkv", "*.mov": H.264 in that container; a name without extension: a new folder of 000000.png,
/// 000001.png, … They hold RGB pictures, or `with_opacity` RGBA ones with straight alpha: then PNGs do, and a
/// "*.mov" in ProRes 4444. AlreadyExists when something is there already; InvalidArgument for a file that
/// holds no such pictures.
Result<std::unique_ptr<PictureSink>> open_picture_sink(const std::filesystem::path& out, int width,
                                                       int height, double frame_rate,
                                                       bool with_opacity = false);

}  // namespace floatstage::pipeline
