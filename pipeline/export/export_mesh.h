#pragma once

#include <filesystem>
#include <vector>

#include "core/glb_scene.h"
#include "core/result.h"
#include "pipeline/chosen_take.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

struct ExportMeshOptions {
  std::filesystem::path take;
  LabelChoice labels = {};    ///< who of it
  std::filesystem::path out;  ///< "*.glb": one animated file; a name without extension: a new folder with a
                              ///< file for each frame, 000000.glb, …
  std::vector<int> frames;    ///< at least one
  double spacing = 2;         ///< px of the nearest photograph between neighbouring vertices, at most
  GlbUp up = GlbUp::Y;
  Progress* progress = nullptr;  ///< null: unwatched
};

struct ExportMeshReport {
  int frames = 0;
  std::size_t vertices = 0, triangles = 0;  ///< of all frames
  double spacing = 0;                       ///< metres, the finest
};

/// Hulls with colours of the photographs at their vertices, cut fine enough to show what the photographs do
/// (docs/adr/0244). Errors: of opening and of load_straight_instant(); InvalidArgument for another extension,
/// a spacing that is not above 0, or one that makes more than kMostTriangles of a frame; AlreadyExists. Whole
/// or not at all.
Result<ExportMeshReport> export_mesh(const ExportMeshOptions& options);

constexpr std::size_t kMostTriangles = 20'000'000;

}  // namespace floatstage::pipeline
