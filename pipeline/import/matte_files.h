#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/rig.h"
#include "pipeline/import/media_files.h"
#include "pipeline/import/picture_stream.h"

namespace floatstage::pipeline {

/// Others' mattes: PNG files named as the pictures are, in one folder or in a folder a camera.
class MatteFiles {
 public:
  /// NotFound when no camera has any. `range` is that of the pictures.
  static Result<MatteFiles> find(const std::filesystem::path& folder, const calib::ForeignRig& foreign,
                                 const FrameRange& range);

  /// Serials of cameras that have none: nothing is known of their silhouettes.
  const std::vector<std::string>& without() const { return without_; }

  /// Writes mattes/<serial>/<frame>.png of the take for the first `count` frames of a camera. BadData for a
  /// matte of another size than the picture, NotFound when there are fewer than `count`. Nothing for a camera
  /// that has none. Different cameras at once are fine.
  Result<void> save(std::size_t camera, const RigCamera& rig_camera, int count,
                    const std::filesystem::path& take) const;

 private:
  std::vector<CameraMedia> cameras_;
  std::vector<std::string> without_;
  FrameRange range_;
};

/// Opacity from a PNG: its alpha, or its grey where there is none. BadData for colours without alpha. Where
/// the largest value is 1 it is a mask of 0 and 1 and becomes one of 0 and 255.
Result<Image> matte_from_picture(const Image& picture);

}  // namespace floatstage::pipeline
