#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/import/contours.h"
#include "pipeline/import/matte_files.h"
#include "pipeline/import/media_files.h"
#include "pipeline/import/picture_stream.h"

namespace floatstage::pipeline {

/// Others' contours of a take's pictures, which become its mattes: a folder of labelme's files, or COCO's one
/// file. They belong to pictures by their names without extension: a picture's own name and folder, a folder
/// named after its camera, or SERIAL_NAME and SERIAL-NAME; the name alone where the camera has one picture.
/// Of a video they are counted in natural order.
class ContourFiles final : public GivenMattes {
 public:
  /// Everything is read here. `media`: a camera's pictures each. NotFound when no camera has any; errors of
  /// parse_labelme() and parse_coco().
  static Result<ContourFiles> find(const std::filesystem::path& given, const calib::ForeignRig& foreign,
                                   const std::vector<CameraMedia>& media, const FrameRange& range,
                                   const ContourOptions& options);

  const std::vector<std::string>& without() const override { return without_; }
  std::vector<std::string> notes() const override { return notes_; }
  /// As GivenMattes::save(); NotFound also where a video has another number of pictures than of contours.
  Result<void> save(std::size_t camera, const RigCamera& rig_camera, int count,
                    const std::filesystem::path& take) const override;

 private:
  struct Camera {
    std::map<int, PictureContours> pictures;  ///< by number in the video or folder
    int of_video = 0;                         ///< contours of a video that there are
  };

  std::filesystem::path given_;
  FrameRange range_;
  std::vector<Camera> cameras_;
  std::vector<bool> one_picture_;
  std::vector<std::string> without_, notes_;
};

}  // namespace floatstage::pipeline
