#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "calib/board.h"
#include "calib/detect.h"
#include "tests/support/board_picture.h"

namespace floatstage::calib {

inline TargetDesign target(const std::string& line) {
  const Result<TargetDesign> read = parse_target(line);
  EXPECT_TRUE(read) << line << ": " << (read ? "" : read.error().message);
  return *read;
}

/// How far detected points lie from the truth, px.
struct Errors {
  std::size_t count = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0, largest = 0;
  Eigen::Vector2d mean() const { return sum / std::max<double>(1, static_cast<double>(count)); }
  double rms() const { return std::sqrt(squares / std::max<double>(1, static_cast<double>(count))); }
};

inline void add_errors(Errors& errors, const Detection& found,
                       const std::vector<std::optional<Eigen::Vector2d>>& truth) {
  for (const SeenPoint& p : found.points) {
    const auto& at = truth.at(static_cast<std::size_t>(p.id));
    ASSERT_TRUE(at) << "point " << p.id << " is behind the camera";
    const Eigen::Vector2d off = p.pixel - *at;
    ++errors.count;
    errors.sum += off;
    errors.squares += off.squaredNorm();
    errors.largest = std::max(errors.largest, off.norm());
  }
}

/// Points that face the camera and lie at least `rim` px inside the picture.
inline std::size_t points_in_view(const TargetDesign& design, const CameraModel& model,
                                  const Rigid3& cam_from_target, double rim) {
  std::size_t count = 0;
  for (const TargetPoint& p : make_target(design, "").points) {
    const Eigen::Vector3d at = cam_from_target * p.position;
    if (p.normal != Eigen::Vector3d::Zero() && (cam_from_target.rotation * p.normal).dot(at) >= 0) continue;
    const auto pixel = project(model, at);
    if (pixel && pixel->x() >= rim && pixel->y() >= rim && pixel->x() <= model.width - rim &&
        pixel->y() <= model.height - rim)
      ++count;
  }
  return count;
}

}  // namespace floatstage::calib
