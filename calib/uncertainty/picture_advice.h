#pragma once

#include <string>
#include <vector>

#include "calib/uncertainty/working_volume.h"

namespace floatstage::calib {

/// One picture of a board that is worth taking.
struct PictureToTake {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();  ///< of the board's middle, shares of the picture, 0 to 1
  double distance = 0;                              ///< metres before the camera
  double turned = 0, leaned = 0;                    ///< degrees about the picture's upright and level axis
};

/// What would bring a camera's projection sigma below the bar.
struct PictureAdvice {
  std::string camera;
  double now_px = 0, then_px = 0;  ///< before, and with all of `pictures`
  std::vector<PictureToTake> pictures;
  std::string sentence;
};

/// For each camera above the bar (the worst three), the pictures of the first board that lower its sigma
/// most, one after the other until it passes or ten are found. Empty when all pass or no board was shown.
std::vector<PictureAdvice> pictures_to_add(const Calibration& calibration, const Observations& observations,
                                           const WorkingVolume& volume, double bar_px);

}  // namespace floatstage::calib
