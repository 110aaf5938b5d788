#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/progress.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

struct ProcessOptions {
  std::filesystem::path take;
  std::optional<std::string> key;          ///< keyer spec; absent: as before, else "chroma"
  std::optional<recon::HullOptions> hull;  ///< absent: as before, else exact with automatic voting
  int threads = 0;                         ///< 0: one per core
  bool redo = false;                       ///< remake what was made with other options
  Progress* progress = nullptr;            ///< null: unwatched
};

/// What one stage did. made + kept + gaps + failures = items.
struct StageReport {
  int made = 0;                       ///< in this run
  int kept = 0;                       ///< there already
  int gaps = 0;                       ///< nothing to make: the camera has no photograph of that instant
  std::vector<std::string> failures;  ///< one sentence each
};

struct ProcessReport {
  int frames = 0, cameras = 0, empty_frames = 0;  ///< empty: nobody on stage
  StageReport mattes, meshes;
  double seconds = 0;
};

/// Every offline stage on a take: mattes, then meshes. Does only what is missing; a file exists only when it
/// is whole. Frames are independent and run in parallel. One bad frame does not stop the others: it is
/// reported, and the result is an error only when nothing can go on (unwritable, disk full, other options
/// than before, no subject anywhere).
Result<ProcessReport> process_take(const ProcessOptions& options);

}  // namespace floatstage::pipeline
