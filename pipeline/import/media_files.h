#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calib/rig_formats.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Where one camera's pictures are: one video, or one or more still pictures in their order. Nothing when it
/// has none.
struct CameraMedia {
  std::filesystem::path video;
  std::vector<std::filesystem::path> stills;
  bool empty() const { return video.empty() && stills.empty(); }
};

/// A video, a folder of pictures in natural order, or one picture; empty for anything else.
CameraMedia media_of(const std::filesystem::path& entry);

struct MediaSearch {
  std::vector<CameraMedia> cameras;  ///< one for each camera of the rig
  std::vector<std::string>
      unused;  ///< pictures, videos and folders of pictures that belong to no camera, sorted
};

/// Looks in `folder` for the media of each camera, in this order: the file that the calibration names (when
/// that lies in a folder of its own, all pictures of that folder); a folder, picture or video named after the
/// image or the serial; a video whose name ends in _<serial> or -<serial>. InvalidArgument when two files fit
/// one camera equally well.
Result<MediaSearch> find_media(const std::filesystem::path& folder, const calib::ForeignRig& foreign);

/// a2 before a10: runs of digits compare as numbers.
bool natural_less(const std::string& a, const std::string& b);

}  // namespace floatstage::pipeline
