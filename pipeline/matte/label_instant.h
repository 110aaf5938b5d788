#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "pipeline/matte/label_hull.h"

namespace floatstage::pipeline {

/// The labels of one instant: what is carried to the next.
struct LabelInstant {
  int frame = -1;
  std::vector<Image> pictures, mattes;  ///< by camera: RGB and the sum; empty where there is none
  std::vector<Image> sure;              ///< labels of the pixels whose rays meet voxels of no other, else 0
  std::vector<Image> labels;            ///< by camera, of its pixels: 0 nobody; empty where there is no sum
  std::vector<std::size_t> voxels;      ///< by label - 1: how many; empty: space says nothing
  double edge = 0;                      ///< of voxels, metres
  LabelPlaces places;                   ///< by label - 1: its voxels
  std::vector<Eigen::Vector3d> motion;  ///< by label - 1: voxels a frame
  Disbelieved disbelieved;              ///< cameras whose mattes lack somebody
  double merged = 0;                    ///< the largest share of a label that lies at another one
};

}  // namespace floatstage::pipeline
