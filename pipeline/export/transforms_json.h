#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/rig.h"

namespace floatstage::pipeline {

/// The pictures of a rig's cameras as paths within the exported folder.
struct PicturePaths {
  std::vector<std::string> pictures, mattes;  ///< one a camera; an empty matte is none
  std::string points;                         ///< a PLY of points to begin with
};

/// transforms.json as nerfstudio and instant-ngp read it: a camera's intrinsics with its picture, and its
/// camera-to-world matrix with x right, y up, z backward. Cameras are straight().
std::string transforms_json(const Rig& rig, const PicturePaths& paths);

}  // namespace floatstage::pipeline
