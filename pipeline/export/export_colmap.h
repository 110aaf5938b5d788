#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/chosen_take.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

struct ExportColmapOptions {
  std::filesystem::path take;
  LabelChoice labels = {};    ///< who of it: masks and points are theirs
  std::filesystem::path out;  ///< a folder that is not there yet, or empty
  std::vector<int> frames;    ///< at least one; of several each gets a folder, named by its number
  std::vector<std::string> cameras = {};  ///< serials; empty: all
  bool alpha = false;                     ///< pictures carry their mattes in an alpha channel too
  Progress* progress = nullptr;           ///< null: unwatched
};

struct ExportColmapReport {
  int frames = 0, pictures = 0, masks = 0;
  std::size_t points = 0;  ///< of all frames
};

/// Instants as projects of COLMAP, in the layout that its image_undistorter makes and trainers of Gaussian
/// splats read (docs/adr/0243):
///
///   images/<serial>.png            without lens and skew
///   masks/<serial>.png.png         as COLMAP names masks; none for a camera without mattes
///   sparse/0/{cameras,images,points3D}.{txt,bin}
///   points.ply                     the same points, with colours
///   transforms.json                the same cameras for nerfstudio and instant-ngp
///
/// The points are the hull's vertices that at least two cameras see. Errors: of opening and of
/// load_straight_instant(); whole or not at all.
Result<ExportColmapReport> export_colmap(const ExportColmapOptions& options);

}  // namespace floatstage::pipeline
