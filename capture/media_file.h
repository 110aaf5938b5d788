#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "core/image.h"
#include "core/result.h"

namespace floatstage {

/// Decodes any picture or video file that libav knows, one RGB picture after the other: what `import` reads.
class MediaReader {
 public:
  static Result<std::unique_ptr<MediaReader>> open(const std::filesystem::path& file);
  virtual ~MediaReader() = default;
  virtual double frame_rate() const = 0;  ///< nominal; 0 for a still
  /// The next picture, 3 channels; EndOfStream after the last; BadData names the file and the picture's number.
  virtual Result<Image> next() = 0;
};

/// Writes RGB pictures of one size as an H.264 MP4 (yuv420p, crf 18, faststart) that browsers play. Temporary name until finish().
class VideoWriter {
 public:
  static Result<std::unique_ptr<VideoWriter>> create(const std::filesystem::path& file, int width, int height, double frame_rate);
  virtual ~VideoWriter() = default;
  virtual Result<void> write(const Image& rgb) = 0;
  virtual Result<void> finish() = 0;
};

}  // namespace floatstage
