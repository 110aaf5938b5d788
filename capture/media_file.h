#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "capture/sound/film_sound.h"
#include "core/image.h"
#include "core/result.h"
#include "core/time.h"

namespace floatstage::capture {

/// Decodes any picture or video file that libav knows, one RGB picture after the other: what `import` reads.
/// Pictures come as they are to be looked at: turned by the file's rotation metadata (video display matrix,
/// EXIF), full and limited range and the colour matrix honoured, 16-bit samples reduced, transparency
/// dropped. One thread at a time.
class MediaReader {
 public:
  /// NotFound and Io as the operating system says, BadData when no picture can be found; each names the file.
  static Result<std::unique_ptr<MediaReader>> open(const std::filesystem::path& file);
  virtual ~MediaReader() = default;
  virtual double frame_rate() const = 0;  ///< nominal; 0 for a still
  /// When the picture that next() returned last is shown, in the file's own time (that of its sound); nothing
  /// before the first, and where the file does not say.
  virtual std::optional<Nanoseconds> time() const = 0;
  /// The next picture, 3 channels; EndOfStream after the last; BadData names the file and the picture's
  /// number.
  virtual Result<Image> next() = 0;
};

/// Writes RGB pictures of one size as H.264 (yuv420p, BT.709, crf 18): Matroska where the name ends in .mkv,
/// MOV in .mov, else an MP4 (faststart) that browsers play. 4:2:0 needs even sizes: an odd width or height
/// grows by one, repeating the last column or row. Temporary name until finish(); a writer destroyed without
/// it leaves nothing. One thread at a time; the bytes do not depend on the machine's cores.
class VideoWriter {
 public:
  /// InvalidArgument for a size or rate that is not positive; Io names the file.
  static Result<std::unique_ptr<VideoWriter>> create(const std::filesystem::path& file, int width, int height,
                                                     double frame_rate);
  virtual ~VideoWriter() = default;
  /// InvalidArgument when the picture has not that size and 3 channels, or after finish(); Io names the file.
  virtual Result<void> write(const Image& rgb) = 0;
  /// Replaces `file`. InvalidArgument when no picture was written: such a file would not play.
  virtual Result<void> finish() = 0;
};

/// Puts films that a VideoWriter wrote, of one size and `frame_rate`, one behind the other into a new film,
/// in the container that its name says, without coding a picture again: every film begins with a picture that
/// needs no other, so what is decoded is what is decoded of the parts, and the same parts give the same
/// bytes. BadData names a part that is no such film or is coded otherwise than the first, or says that there
/// are not so many `pictures`; AlreadyExists when `file` is there or is being written; Io. Temporary name
/// until it is whole. `sound`, where there is some, begins with the first picture and has the same bytes each
/// time too: AAC in MP4, PCM of 24 bits in MOV, FLAC in Matroska.
Result<void> join_videos(const std::vector<std::filesystem::path>& parts, double frame_rate,
                         std::int64_t pictures, const std::filesystem::path& file,
                         const FilmSound* sound = nullptr);

}  // namespace floatstage::capture
