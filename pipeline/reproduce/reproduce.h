#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/result.h"
#include "pipeline/progress.h"
#include "render/back_end.h"

namespace floatstage::pipeline {

struct ReproduceOptions {
  std::filesystem::path out;
  std::filesystem::path data;     ///< folder of the real sets; empty: what needs them is left out
  std::vector<std::string> only;  ///< "fig61", "fig61/hull"; empty: all
  bool small = false;             ///< half of the pictures' size, few views
  bool redo = false;              ///< what is done already is made again
  render::BackEnd back_end = render::BackEnd::Auto;
  Progress* progress = nullptr;  ///< null: unwatched
};

struct ReproduceReport {
  struct LeftOut {
    std::string name, why;
  };
  std::vector<std::string> made, kept;  ///< names of experiments
  std::vector<LeftOut> left_out;
};

/// Makes the thesis' experiments of chapters 10 and 11 (docs/reproduce.md): out/<name>/ gets table.json, .csv
/// and .md, sheet.png, chart.svg; each appears whole or not at all. What is there already is kept. After each
/// out/report.json {fig52, fig53, fig58, fig61, sweeps, left_out} and report.md hold all that is there.
/// InvalidArgument for a name that there is not, NotFound where `only` asks for what has no data,
/// AlreadyExists where an experiment lies there that was made otherwise or something that none made; errors
/// of the experiments; Cancelled: what was done is kept.
Result<ReproduceReport> reproduce(const ReproduceOptions& options);

/// What `only` may name.
std::vector<std::string> experiment_names();

}  // namespace floatstage::pipeline
