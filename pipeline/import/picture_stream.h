#pragma once

#include <memory>
#include <optional>
#include <string_view>

#include "capture/media_file.h"
#include "core/image.h"
#include "core/result.h"
#include "pipeline/import/media_files.h"

namespace floatstage::pipeline {

/// Frames [first, end) of a video or a folder, every step-th of them.
struct FrameRange {
  int first = 0;
  std::optional<int> end;
  int step = 1;
};

/// "5", "A:B" (B not included), "A:", ":B", or with a step behind a second colon: "A:B:2".
Result<FrameRange> parse_frame_range(std::string_view text);

/// One camera's pictures, one after the other, whether they lie in a video or in single files.
class PictureStream {
 public:
  /// NotFound when the range holds no picture; errors of the media name their file. The first picture is
  /// decoded here.
  static Result<PictureStream> open(const CameraMedia& media, const FrameRange& range);

  const std::filesystem::path& video() const { return media_.video; }  ///< empty for stills
  int width() const { return width_; }
  int height() const { return height_; }
  double frame_rate() const { return frame_rate_; }  ///< the video's by the step; 0 for single files
  /// When a video shows its first picture here, and the one that next() returned last, in its own time;
  /// nothing where it does not say, and for stills.
  std::optional<Nanoseconds> first_time() const { return first_time_; }
  std::optional<Nanoseconds> last_time() const { return last_time_; }
  /// The next picture, 3 channels, always of the first one's size (BadData otherwise); nothing after the
  /// last.
  Result<std::optional<Image>> next();

 private:
  Result<std::optional<Image>> decode();
  Result<void> skip(int pictures);

  CameraMedia media_;
  std::size_t next_still_ = 0;
  int position_ = 0;  // of the next picture, in the video or folder
  std::optional<int> end_;
  int step_ = 1;
  std::unique_ptr<capture::MediaReader> video_;
  std::optional<Image> first_;
  std::optional<Nanoseconds> first_time_, last_time_;
  int width_ = 0, height_ = 0;
  double frame_rate_ = 0;
};

/// One picture of its own, 3 channels. Errors name the file.
Result<Image> load_still(const std::filesystem::path& file);

}  // namespace floatstage::pipeline
