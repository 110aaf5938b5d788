#pragma once

#include <string>

#include "calib/calibrate.h"

namespace floatstage::pipeline {

// The report's pictures as SVG elements, 320 px wide and as high as the camera's picture is.

/// Where points were seen and which way they are off, enlarged; what was left out in red.
std::string error_picture(const calib::Calibration& calibration, int camera);
/// How many points were seen in each cell of the picture.
std::string coverage_picture(const calib::Calibration& calibration, int camera);
/// How far off the calibration itself lets a pixel be, over the picture, at the depth where the targets were.
std::string uncertainty_picture(const calib::Calibration& calibration,
                                const calib::ProjectionUncertainty& uncertainty, int camera);
/// Cameras from above, with the links between those that saw targets together.
std::string graph_picture(const calib::Calibration& calibration);

/// Text with <, > and & made harmless.
std::string escaped(const std::string& text);

}  // namespace floatstage::pipeline
