#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/result.h"
#include "pipeline/calibrate/board_search.h"
#include "pipeline/calibrate/folder_survey.h"
#include "pipeline/calibrate/new_session.h"

namespace floatstage::pipeline {

/// The session as it grows: sentences and pieces of TOML.
struct SessionDraft {
  const FolderSurvey& survey;
  const NewSessionOptions& options;
  std::filesystem::path written_to;  ///< the folder that paths are relative to
  NewSession out;
  std::string head, tables, cameras;  ///< TOML, in this order

  static std::string quoted(const std::string& s);
  std::string path(const std::filesystem::path& p) const;  ///< quoted
  std::string paths(const std::vector<std::filesystem::path>& list) const;
  void found(std::string sentence) { out.found.push_back(std::move(sentence)); }
  void assume(std::string sentence) { out.assumed.push_back(std::move(sentence)); }
  void camera(const std::string& serial, const std::string& key, const std::string& value);
  /// The calibration that lies there, as [known].
  void known(const char* intrinsics, const char* poses);
};

/// What a name becomes as a serial.
std::string usable_serial(std::string name);

/// Pictures that show a board.
Result<void> draft_board(SessionDraft& draft, const FoundBoard& board);

/// Known cameras and a picture of each: are they still where they are said to be? False when there are none.
Result<bool> draft_known_scene(SessionDraft& draft);

/// Pictures of a scene and nothing else: every picture is a camera.
Result<void> draft_unknown_scene(SessionDraft& draft);

/// Pictures a second, by a table with columns cam_id and frame_time (seconds), as Caliscope writes it. Absent
/// when it is no such table.
std::optional<double> rate_of_time_stamps(const std::filesystem::path& table);

}  // namespace floatstage::pipeline
