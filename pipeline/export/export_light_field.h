#pragma once

#include <filesystem>

#include "capture/take.h"
#include "core/result.h"
#include "pipeline/chosen_take.h"
#include "pipeline/film.h"

namespace floatstage::pipeline {

struct ExportLightFieldOptions {
  std::filesystem::path take, out;  ///< `out`: a folder that is not there yet, or empty
  LabelChoice labels = {};          ///< who of it
  int rows = 5, columns = 5;        ///< of views, 2 at least
  double baseline = 0.05;           ///< metres from each view to the next, along rows and columns
  PathKey middle;                   ///< where the grid's middle stands and looks, in the world
  FilmOptions film;                 ///< size, one frame, one method, and how it is drawn
};

struct ExportLightFieldReport {
  int pictures = 0;
  double seconds = 0;  ///< that it took
};

/// A plane of views of one instant, drawn with parallel cameras around the middle:
/// views/NAME_<row>_<column>_<y mm>_<x mm>_<focal mm>_<sensor mm>.png, as `import lightfield` reads them (row
/// 0 above, x to the right, y down, from the middle), sparse/0 for COLMAP and transforms.json for nerfstudio
/// and instant-ngp in the take's world. InvalidArgument for what is no grid, one picture or one method;
/// errors of render_film(). Whole or not at all.
Result<ExportLightFieldReport> export_light_field(const ExportLightFieldOptions& options);

}  // namespace floatstage::pipeline
