#pragma once

#include <optional>
#include <string>

#include "calib/board.h"
#include "core/result.h"
#include "pipeline/calibrate/folder_survey.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

/// Which of the media show a board, and which board that is.
struct FoundBoard {
  std::size_t set = 0;  ///< of the survey's
  calib::TargetDesign design;
  bool square_is_known = false;  ///< false: it is of one metre
  int pictures = 0, looked_at = 0;
  std::string how;  ///< where the description is from
};

/// Looks at some pictures of every set (24 stills, ten of each video). A board that is described (`given`, or
/// the survey's file) is looked for; else it is told from the pictures. Absent when no set shows a board.
/// Errors name the file that cannot be read.
Result<std::optional<FoundBoard>> find_board(const FolderSurvey& survey,
                                             const std::optional<calib::TargetDesign>& given, int threads,
                                             Progress* watch);

/// A board of a charuco.toml (Caliscope: columns, rows, dictionary, aruco_scale, square_size_override_cm,
/// inverted), or the line in a print or text file of ours. BadData, NotFound.
Result<calib::TargetDesign> read_board_file(const std::filesystem::path& file);

}  // namespace floatstage::pipeline
