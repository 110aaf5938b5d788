#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/metrics/metrics.h"
#include "pipeline/synthesize.h"

namespace floatstage::pipeline {

struct DemoOptions {
  std::filesystem::path out = "demo";
  SynthesizeOptions studio;      ///< its `out` is ignored: the take goes to out/take
  double film_rate = 24;         ///< pictures a second of the two videos
  int blend = 3;                 ///< photographs blended in a view
  Progress* progress = nullptr;  ///< null: unwatched
  int score_every = 6;  ///< every how many pictures of the film one is compared with what the studio really
                        ///< looks like from there
};

/// The demo's studio: eight cameras, 640×480, and the faults of a real one (noise, lens, calibration, spill).
DemoOptions default_demo();

struct DemoReport {
  double seconds = 0;
  std::map<std::string, double> stage_seconds;        ///< synthesize, process, render
  std::map<std::string, std::vector<Scores>> scores;  ///< per method, one a scored picture
};

/// The main job on the embedded studio: out/take (recording, mattes, meshes), out/freeview.mp4 (floating),
/// out/compare.mp4 (linear left, floating right), out/report.json. A folder that an earlier demo made is made
/// again; any other existing folder is refused. Needs no camera, GPU or display.
Result<DemoReport> run_demo(const DemoOptions& options);

}  // namespace floatstage::pipeline
