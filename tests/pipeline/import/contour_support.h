#pragma once

#include "core/camera.h"
#include "pipeline/import/contours.h"

namespace floatstage::pipeline {

/// A camera for pictures of that size; what it sees does not matter.
inline CameraModel camera_of(const PictureContours& contours) {
  CameraModel model;
  model.width = contours.width, model.height = contours.height;
  model.fx = model.fy = contours.width;
  model.cx = 0.5 * contours.width, model.cy = 0.5 * contours.height;
  return model;
}

}  // namespace floatstage::pipeline
