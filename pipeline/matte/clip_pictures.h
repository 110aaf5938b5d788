#pragma once

#include <filesystem>

#include "core/image.h"
#include "core/result.h"
#include "pipeline/import/media_files.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// The pictures of a video or a folder of pictures, in any order. A video is decoded once, into a folder of
/// its own.
class ClipPictures {
 public:
  /// `scratch` is made for a video, and stays. Errors: NotFound for media that are not there or hold no
  /// picture; those of PictureStream; Io; Cancelled.
  static Result<ClipPictures> open(const std::filesystem::path& media, const std::filesystem::path& scratch,
                                   Progress* progress);

  int frames() const { return static_cast<int>(stills_.stills.size()); }
  /// RGB. Errors name the file.
  Result<Image> picture(int frame) const;
  /// The frame whose file has this name without its ending; else the one whose number the name is; -1 where
  /// there is none.
  int frame_of(const std::string& stem) const;

 private:
  CameraMedia stills_;
  bool named_ = true;  // the files' names are somebody's
};

}  // namespace floatstage::pipeline
