#pragma once

#include <algorithm>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "pipeline/progress.h"
#include "pipeline/reproduce/comparison.h"
#include "pipeline/reproduce/table.h"
#include "render/back_end.h"

namespace floatstage::pipeline {

/// What experiments are made with.
struct Lab {
  std::filesystem::path data;                       ///< folder of the real sets; empty: there are none
  render::BackEnd back_end = render::BackEnd::Cpu;  ///< Cpu or Gl; it is open
  bool small = false;  ///< half of the pictures' size and few views: a look, whose figures are others
  Progress* progress = nullptr;
  int most_views = 1000;  ///< of each kind

  int size(int px) const { return small ? px / 2 : px; }
  int views(int count) const { return std::min({count, most_views, small ? 2 : count}); }
};

/// What an experiment gives.
struct Outcome {
  Table table;
  Image sheet = {};        ///< RGB; empty: none
  std::string chart = {};  ///< SVG; empty: none
};

/// One of the thesis' experiments.
struct Experiment {
  const char* figure;  ///< "fig52"; --only names it
  const char* part;    ///< "hull" where a figure has several, else empty
  const char* help;    ///< for lists
  const char* data;    ///< the set that it needs, a folder of Lab::data; empty: none
  Result<Outcome> (*run)(const Lab& lab);

  std::string name() const { return *part == 0 ? figure : std::string(figure) + "/" + part; }
};

/// All of them, in the thesis' order.
std::span<const Experiment> experiments();

/// The methods that figures compare, in the thesis' order, of those that there are: band-limited, filtered,
/// linear, floating-static, floating. `light_field`: light-field in the place of linear.
std::vector<std::string> compared_methods(bool light_field);

Result<Outcome> run_fig52(const Lab& lab);
Result<Outcome> run_fig53(const Lab& lab);
Result<Outcome> run_fig58(const Lab& lab);
Result<Outcome> run_fig61_bunny(const Lab& lab);
Result<Outcome> run_fig61_hull(const Lab& lab);
Result<Outcome> run_fig61_light_field(const Lab& lab);
Result<Outcome> sweep_triangles(const Lab& lab);
Result<Outcome> sweep_spacing(const Lab& lab);
Result<Outcome> sweep_calibration(const Lab& lab);
Result<Outcome> sweep_gains(const Lab& lab);
Result<Outcome> sweep_blend(const Lab& lab);
Result<Outcome> sweep_flow(const Lab& lab);

}  // namespace floatstage::pipeline
