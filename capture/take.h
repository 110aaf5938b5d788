#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/frame.h"
#include "core/result.h"
#include "core/rig.h"
#include "core/take_layout.h"

namespace floatstage {

enum class TakeCodec {
  Ffv1,  ///< lossless, the default
  Raw,   ///< uncompressed, for disks faster than processors
  H264,  ///< lossy, small (x264, crf 16)
};

struct TakeWriterOptions {
  TakeCodec codec = TakeCodec::Ffv1;
  double frame_rate = 25;  ///< nominal, for the container's time base only: frames.csv holds the true times
  std::string label;
  std::string created;     ///< UTC, ISO 8601; empty: now
};

/// Records a take: a new folder that must not exist yet (or be empty), one media file and one side file a camera.
/// write() calls for different cameras may come from different threads; those of one camera must not.
/// Killed at any moment, what was written opens and plays up to the cut.
class TakeWriter {
 public:
  static Result<std::unique_ptr<TakeWriter>> create(const std::filesystem::path& folder, const Rig& rig,
                                                    const TakeWriterOptions& options);
  virtual ~TakeWriter() = default;
  /// frame.info.camera says which camera. A frame without pixels becomes a gap row. All frames of a camera must
  /// have one layout, that of its first picture. Errors: Io (disk full) names the file; what was written stays valid.
  virtual Result<void> write(const Frame& frame) = 0;
  /// Flushes everything and marks the manifest complete. A writer destroyed without finish() leaves an incomplete take.
  virtual Result<void> finish() = 0;
};

/// A recording opened for random access. Thread safe: readers on several threads share one TakeReader.
class TakeReader {
 public:
  /// NotFound when there is no take; BadData when the manifest, rig or side files do not make sense or the rig's
  /// SHA-256 does not match; media missing or truncated is reported by name. An incomplete take opens with a warning.
  static Result<std::unique_ptr<TakeReader>> open(const std::filesystem::path& folder);
  virtual ~TakeReader() = default;

  virtual const TakeLayout& layout() const = 0;
  virtual const TakeManifest& manifest() const = 0;
  virtual const Rig& rig() const = 0;
  /// Expected instants: the longest side file. Row k of every camera belongs to instant k.
  virtual int frame_count() const = 0;
  virtual const std::vector<FrameRow>& rows(int camera) const = 0;
  /// One camera's frame; an empty frame with status Lost for a gap. Sequential access is fast, seeking works.
  virtual Result<Frame> frame(int camera, int index) = 0;
  /// All cameras at one instant; time is the earliest exposure of the frames present.
  virtual Result<FrameSet> frame_set(int index) = 0;
};

}  // namespace floatstage
