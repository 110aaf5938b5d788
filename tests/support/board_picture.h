#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "calib/board.h"
#include "core/camera.h"
#include "core/image.h"

namespace floatstage::test {

/// What a picture of a target suffers from, and its grey levels (0…255).
struct BoardPictureOptions {
  int samples = 4;   ///< rays a pixel = samples² wherever ink and paper meet
  double blur = 0;   ///< px: standard deviation of a Gaussian
  double noise = 0;  ///< grey levels: standard deviation
  double paper = 215, ink = 30, background = 100;
  double ball_glow = 240, ball_dark = 20;  ///< a wand of balls: spheres before a dark room
  std::uint64_t seed = 1;
};

/// A picture of a target through the camera's lens, 1 channel: every ray meets the sheets of target_sheets()
/// (balls of a wand: spheres), so that edges are where the geometry says, to the sampling.
Image board_picture(const calib::TargetDesign& target, const CameraModel& model,
                    const Rigid3& cam_from_target, const BoardPictureOptions& options = {});

/// Where the target's points are in that picture; absent behind the camera. The number is the point's.
std::vector<std::optional<Eigen::Vector2d>> true_pixels(const calib::TargetDesign& target,
                                                        const CameraModel& model,
                                                        const Rigid3& cam_from_target);

/// A camera with this field of view (degrees across), square pixels and its axis in the picture's middle.
CameraModel simple_camera(int width, int height, double field_of_view, Lens lens = {});

/// A target whose middle is `distance` metres before the camera and which is turned by these degrees about
/// the camera's x, y and z axis; upright and facing the camera at 0, 0, 0. `shift` moves it in the camera's
/// frame.
Rigid3 before_camera(const calib::TargetDesign& target, double distance,
                     const Eigen::Vector3d& degrees = Eigen::Vector3d::Zero(),
                     const Eigen::Vector3d& shift = Eigen::Vector3d::Zero());

}  // namespace floatstage::test
