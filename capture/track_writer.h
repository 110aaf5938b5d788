#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "capture/take.h"

namespace floatstage::capture {

/// The media file of one camera while it is being recorded. Not thread safe.
class TrackWriter {
 public:
  /// Creates the file, which must not exist, and writes its header. `layout` is that of every picture to
  /// come.
  static Result<std::unique_ptr<TrackWriter>> create(const std::filesystem::path& file,
                                                     const std::string& serial, TakeCodec codec,
                                                     const ImageLayout& layout, double frame_rate);
  virtual ~TrackWriter() = default;
  /// Encodes one picture, whole and on its own. When this returns, the operating system has its bytes:
  /// killing the program loses none of them. Io names the file; the pictures before it stay readable.
  virtual Result<void> write(const Frame& frame) = 0;
  /// Writes the index that makes other players seek fast, and closes the file.
  virtual Result<void> finish() = 0;
};

}  // namespace floatstage::capture
