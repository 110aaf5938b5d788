#pragma once

#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/color.h"

namespace floatstage {

struct RigCamera {
  std::string serial;  ///< unique in its rig; also its file name in a take: letters, digits, '.', '_' and '-'
  CameraModel model;
  Rigid3 cam_from_world;
  ColorTransform color;
};

/// The cameras around a stage. World: metres, right-handed, z up, floor at z = 0.
struct Rig {
  std::vector<RigCamera> cameras;
};

/// Letters, digits, '.', '_' and '-', not beginning with '.': fit to be a file name.
bool is_usable_serial(std::string_view serial);

/// Index of the camera with that serial, or -1.
int camera_index(const Rig& rig, std::string_view serial);

/// Every camera checked, serials unique and usable as file names, rotations of unit length, transforms
/// finite.
Result<void> check(const Rig& rig);

/// The point nearest to all optical axes in the least-squares sense: where the cameras look. Parallel axes
/// have no such point; then the centroid of the camera centres moved along the mean axis by the rig's spread
/// (at least 1 m), or the centroid itself when the cameras face each other along one line.
Eigen::Vector3d focus_point(const Rig& rig);

/// "Up" as the cameras see it: the mean of their image-up directions, of unit length. (For imported rigs
/// whose world is not z up.)
Eigen::Vector3d mean_up(const Rig& rig);

}  // namespace floatstage
