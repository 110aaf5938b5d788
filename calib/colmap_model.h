#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/result.h"

namespace floatstage {

/// A point of a COLMAP text model and where it was seen: image id and the keypoint's index there, once an image.
struct ColmapPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::vector<std::pair<int, int>> track;
};

/// What points3D.txt says: points, mean track length, mean error, and how many points each image has.
struct ColmapPoints {
  std::vector<ColmapPoint> points;
  double mean_track = 0, mean_error = 0;
  std::vector<std::pair<int, int>> of_image;  ///< image id, points
};
Result<ColmapPoints> parse_colmap_points(std::string_view text, std::string_view name_for_errors);

/// What images.txt says of keypoints (px, corner origin as ours).
struct ColmapImage {
  int id = 0;
  std::string name;
  std::vector<Eigen::Vector2d> keypoints;
};
Result<std::vector<ColmapImage>> parse_colmap_keypoints(std::string_view text, std::string_view name_for_errors);

}  // namespace floatstage
