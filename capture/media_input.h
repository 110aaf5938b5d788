#pragma once

// Private to capture/: a file opened for libav's demuxers.

#include "capture/libav.h"
#include "core/file_descriptor.h"

namespace floatstage::capture::libav {

/// A local file behind libav's own input routine. Unlike a URL, it cannot be taken for a numbered pattern of
/// pictures, a device or a network address, and a play list inside it cannot open other files.
class Input {
 public:
  static Result<std::unique_ptr<Input>> open(const std::filesystem::path& file);
  /// A picture's file, by what its bytes say, and no film's.
  bool is_still() const;
  /// The most pixels that one of its pictures can have: 2^28, and in a still no more than its bytes can stand
  /// for, as libav makes up what a cut picture lacks.
  std::int64_t most_pixels() const { return most_pixels_; }
  Input() = default;
  Input(const Input&) = delete;
  Input& operator=(const Input&) = delete;
  ~Input();
  AVFormatContext& format() { return *format_; }

 private:
  int look_into_streams();

  AVFormatContext* format_ = nullptr;
  AVIOContext* io_ = nullptr;
  FileDescriptor file_;
  std::int64_t most_pixels_ = std::int64_t{1} << 28;  // 16384 x 16384
};

}  // namespace floatstage::capture::libav
