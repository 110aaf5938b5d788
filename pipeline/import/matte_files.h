#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/rig.h"
#include "core/take_layout.h"
#include "pipeline/import/media_files.h"
#include "pipeline/import/picture_stream.h"

namespace floatstage::pipeline {

/// What others know of the subject in the pictures, as mattes.
class GivenMattes {
 public:
  virtual ~GivenMattes() = default;

  /// Serials of cameras that have none: nothing is known of their silhouettes.
  virtual const std::vector<std::string>& without() const = 0;

  /// Sentences about what was left out or looks odd.
  virtual std::vector<std::string> notes() const { return {}; }

  /// Writes mattes/<serial>/<frame>.png of the take for the first `count` frames of a camera. BadData for a
  /// matte of another size than the picture, NotFound when there are fewer than `count`. Nothing for a camera
  /// that has none. Different cameras at once are fine.
  virtual Result<void> save(std::size_t camera, const RigCamera& rig_camera, int count,
                            const std::filesystem::path& take) const = 0;
};

/// Others' mattes: PNG files named as the pictures are, in one folder or in a folder a camera.
class MatteFiles final : public GivenMattes {
 public:
  /// NotFound when no camera has any. `range` is that of the pictures.
  static Result<MatteFiles> find(const std::filesystem::path& folder, const calib::ForeignRig& foreign,
                                 const FrameRange& range);

  const std::vector<std::string>& without() const override { return without_; }
  Result<void> save(std::size_t camera, const RigCamera& rig_camera, int count,
                    const std::filesystem::path& take) const override;

 private:
  std::vector<CameraMedia> cameras_;
  std::vector<std::string> without_;
  FrameRange range_;
};

/// Makes mattes/<serial>/ in the take.
Result<void> make_matte_folder(const TakeLayout& take, const std::string& serial);

/// Opacity from a PNG: its alpha, or its grey where there is none. BadData for colours without alpha. Where
/// the largest value is 1 it is a mask of 0 and 1 and becomes one of 0 and 255.
Result<Image> matte_from_picture(const Image& picture);

}  // namespace floatstage::pipeline
