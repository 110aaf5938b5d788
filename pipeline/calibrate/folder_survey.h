#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "calib/rig_formats.h"
#include "core/result.h"

namespace floatstage::pipeline {

/// Files of one camera that lie together.
struct SurveyedMedia {
  std::string
      name;  ///< what tells it from the others: its folder, its video, the beginning of its pictures' names
  std::filesystem::path video;
  std::vector<std::filesystem::path> stills;  ///< natural order
};

/// Media of the same kind that lie beside one another: likely one camera each.
struct MediaSet {
  enum class Kind {
    Videos,   ///< of one folder
    Folders,  ///< of pictures, side by side
    Names,    ///< pictures in one folder, told apart by how their names begin
    Pictures  ///< pictures in one folder whose names differ by one number: of one camera, or one a camera
  };
  Kind kind = Kind::Pictures;
  std::filesystem::path folder;
  std::vector<SurveyedMedia> media;
};

/// What lies in a folder and below it.
struct FolderSurvey {
  std::vector<MediaSet> sets;  ///< most media first
  /// The calibration of another program (or of ours) with most cameras.
  std::optional<calib::RigFile> calibration;
  std::string calibration_format;
  calib::ForeignRig rig;
  std::filesystem::path board;        ///< a file that describes a target: a print of ours, or a charuco.toml
  std::filesystem::path time_stamps;  ///< a timestamps.csv beside videos
  std::vector<std::string> left_out;  ///< sentences: folders of mattes
};

/// Lists a folder (four levels, hidden names and mattes left out); opens calibrations, no picture. NotFound
/// when the folder is not there or holds neither pictures nor videos; Io.
Result<FolderSurvey> survey_folder(const std::filesystem::path& folder);

/// Beginnings of pictures' names that end with a number, without the number and what leads to it: "left" of
/// left07.jpg, "cam_0" of cam_0_frame_0350.jpg.
std::string name_before_number(const std::string& stem);

}  // namespace floatstage::pipeline
