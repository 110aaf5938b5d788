#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/result.h"
#include "core/rig.h"
#include "core/take_layout.h"

namespace floatstage::capture {

enum class TakeCodec {
  Ffv1,  ///< lossless, the default
  Raw,   ///< uncompressed, for disks faster than processors
  H264,  ///< lossy, small (x264, crf 16)
};

struct TakeWriterOptions {
  TakeCodec codec = TakeCodec::Ffv1;
  double frame_rate = 25;  ///< nominal, for the container's time base only: frames.csv holds the true times
  std::string label;
  std::string created;      ///< UTC, ISO 8601; empty: now
  bool is_claimed = false;  ///< the caller has claimed the folder, which is empty (core/claim.h)
};

/// Records a take: a new folder that must not exist yet (or be empty), one media file and one side file a
/// camera. write() calls for different cameras may come from different threads; those of one camera must not.
/// Killed at any moment, what was written opens and plays up to the cut.
class TakeWriter {
 public:
  /// AlreadyExists when there is anything in the folder or another run is writing it, InvalidArgument for a
  /// rig that does not pass check(), Io. After an error the folder is as it was.
  static Result<std::unique_ptr<TakeWriter>> create(const std::filesystem::path& folder, const Rig& rig,
                                                    const TakeWriterOptions& options);
  virtual ~TakeWriter() = default;
  /// frame.info.camera says which camera. A frame without pixels becomes a gap row; so does every number that
  /// the sequence skips (its time is interpolated). All pictures of a camera must have the rig's size and the
  /// format of its first one; rows may have any stride. Errors: InvalidArgument, with nothing written, for a
  /// frame that does not fit or a sequence that does not grow; Unsupported (an Mjpeg frame); Io (disk full)
  /// names the file, and that camera takes no more frames; what was written stays valid.
  virtual Result<void> write(const Frame& frame) = 0;
  /// Flushes everything and marks the manifest complete. A writer destroyed without finish() leaves an
  /// incomplete take.
  virtual Result<void> finish() = 0;
};

/// A recording opened for random access. Thread safe: readers on several threads share one TakeReader.
class TakeReader {
 public:
  /// NotFound when there is no take; BadData when the manifest, rig or side files do not make sense or the
  /// rig's SHA-256 does not match; NotFound or BadData when a media file is missing or is not what the
  /// manifest says. What can still be played is: an incomplete take, or media that end before their side
  /// file, open with warnings().
  static Result<std::unique_ptr<TakeReader>> open(const std::filesystem::path& folder);
  virtual ~TakeReader() = default;

  virtual const TakeLayout& layout() const = 0;
  virtual const TakeManifest& manifest() const = 0;
  virtual const Rig& rig() const = 0;
  /// Sentences, each naming its file, about what is missing at the end of this take; also logged when it was
  /// opened.
  virtual const std::vector<std::string>& warnings() const = 0;
  /// Expected instants: the longest side file. Row k of every camera belongs to instant k.
  virtual int frame_count() const = 0;
  /// Up to the cut: rows whose pictures are not in the media file any more are not here.
  virtual const std::vector<FrameRow>& rows(int camera) const = 0;
  /// One camera's frame in the recorded format; no pixels and status Lost for a gap and beyond rows(camera),
  /// no pixels and status Corrupt where the media file is damaged, and where a picture is one colour all over
  /// though the camera's others are not (logged once): it shows nothing, not nobody. Sequential access is
  /// fast, seeking works. InvalidArgument for a camera or index that is not there; Io.
  virtual Result<Frame> frame(int camera, int index) = 0;
  /// The part of one camera's frame that holds `boxes`: crop() of frame() to `box`, which becomes what is
  /// around them. Of FFV1 the slices that meet one of them alone are decoded, and only their damage is
  /// noticed; beside the boxes there may be zeros then. InvalidArgument for boxes that miss the picture, too.
  virtual Result<Frame> part(int camera, int index, std::span<const PixelBox> boxes, PixelBox& box) = 0;
  /// All cameras at one instant; time is the earliest exposure of the frames present.
  virtual Result<FrameSet> frame_set(int index) = 0;
};

}  // namespace floatstage::capture
