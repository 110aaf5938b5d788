#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"

namespace floatstage::pipeline {

/// All files that one camera of a session is said to have taken.
struct CameraFiles {
  std::string serial;
  std::vector<std::filesystem::path> files;
};

/// Two cameras cannot have taken one picture. InvalidArgument names two cameras that were given one file or
/// one folder, or whose pictures are the same byte for byte in half of the cases or more. Below that (black
/// frames, say) a sentence each, and one for a camera that was given a picture twice, which would count
/// double. Only files of one size are read.
Result<std::vector<std::string>> notice_same_pictures(const std::vector<CameraFiles>& cameras);

}  // namespace floatstage::pipeline
