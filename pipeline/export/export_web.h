#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/camera_path.h"
#include "pipeline/chosen_take.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

struct ExportWebOptions {
  std::filesystem::path take;
  LabelChoice labels = {};                      ///< who of it
  std::filesystem::path out;                    ///< a folder that is not there yet, or empty
  std::vector<int> frames;                      ///< at least one
  int quality = 90;                             ///< of the photographs' JPEG, 1 … 100
  int blend = 3;                                ///< photographs blended in a view, 1 … 3
  std::optional<CameraPath> path = {};          ///< played by a button of the page
  std::array<float, 3> background = {0, 0, 0};  ///< sRGB
  bool sound = true;                            ///< the take's, where its frames play as they were recorded
  std::string sound_track = {};                 ///< its name; empty: the first
  Progress* progress = nullptr;                 ///< null: unwatched
};

struct ExportWebReport {
  int frames = 0;
  std::uintmax_t bytes = 0;  ///< of all files
  double sound = 0;          ///< seconds that are heard
};

/// A take as a page that any browser with WebGL 2 plays, from a disk or any server: meshes in 16 bits,
/// photographs cut to the subject on a sheet a frame, drawn as `linear` does (docs/adr/0245), with its sound
/// (docs/adr/0289). Frames at even distances play at the take's own speed. The folder holds all that it
/// needs and asks for nothing else. Errors: of opening, of load_straight_instant() and of FilmSounds::open();
/// InvalidArgument. Whole or not at all.
Result<ExportWebReport> export_web(const ExportWebOptions& options);

}  // namespace floatstage::pipeline
