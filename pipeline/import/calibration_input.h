#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "calib/rig_formats.h"

namespace floatstage::pipeline {

enum class CalibrationFormat { Middlebury, Colmap, OpenCv, Qualisys, Dome };

const char* name_of(pipeline::CalibrationFormat format);

struct CalibrationInput {
  CalibrationFormat format = CalibrationFormat::Middlebury;
  std::filesystem::path path;    ///< the calibration's file, or the folder that holds it
  double metres_per_unit = 0.1;  ///< used by formats that state no unit (Dome)
};

struct LoadedCalibration {
  calib::ForeignRig foreign;
  std::filesystem::path pictures;  ///< where this format keeps its pictures unless told otherwise
};

/// Finds the calibration's file or files at or below `path` and reads them. NotFound says what should lie
/// there.
Result<LoadedCalibration> load_calibration(const CalibrationInput& input);

}  // namespace floatstage::pipeline
