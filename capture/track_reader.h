#pragma once

#include <filesystem>
#include <memory>
#include <span>

#include "capture/take.h"

namespace floatstage::capture {

/// The media file of one camera of a take, opened for random access. Thread safe: one picture is decoded at a
/// time.
class TrackReader {
 public:
  /// Errors name the file: NotFound, Io, BadData (no Matroska header, or another codec, size or camera than
  /// `camera` says). A file whose end is missing opens with the pictures it has.
  static Result<std::unique_ptr<TrackReader>> open(const std::filesystem::path& file,
                                                   const TakeManifest::Camera& camera);
  virtual ~TrackReader() = default;

  virtual std::int64_t pictures() const = 0;
  /// The file ends in the middle of a picture or of an index.
  virtual bool cut() const = 0;
  virtual const ImageLayout& layout() const = 0;
  /// Picture `index` of [0, pictures()), in the recorded format: layout().size_bytes bytes. The next picture,
  /// and the last one again, are fast; any other costs decoding from its key picture (FFV1 and raw: itself).
  /// BadData when the bytes are damaged, whatever was decoded before.
  virtual Result<std::shared_ptr<const std::byte[]>> picture(std::int64_t index) = 0;
  /// The part of it within `boxes`, which are whole_pixels() (core/frame.h), packed tightly in what is
  /// around() them with zeros beside them, where less is to be decoded for it than the whole picture; else
  /// null. What is damaged elsewhere is not noticed.
  virtual Result<std::shared_ptr<const std::byte[]>> part(std::int64_t index,
                                                          std::span<const PixelBox> boxes) = 0;
};

}  // namespace floatstage::capture
