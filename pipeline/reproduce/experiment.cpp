#include "pipeline/reproduce/experiment.h"

#include <algorithm>

namespace floatstage::pipeline {
namespace {

constexpr const char *kBunny = "stanford-bunny", *kShop = "lightfield-shop";

// The table of experiments: one line each.
constexpr Experiment kExperiments[] = {
    {"fig52", "", "Table 3: bunny on 948 triangles, 19 views, what methods make of it", kBunny, run_fig52},
    {"fig53", "", "a light field thinned to 25 and 9 pictures", kShop, run_fig53},
    {"fig58", "", "binary and soft visibility, occluded parts filled or not", "", run_fig58},
    {"fig61", "bunny", "49 views of the bunny, views farthest from them", kBunny, run_fig61_bunny},
    {"fig61", "hull", "a dancer on the hull of eight cameras, views between them", "", run_fig61_hull},
    {"fig61", "light_field", "a light field, views between its pictures", kShop, run_fig61_light_field},
    {"sweeps", "triangles", "the bunny's proxy from 69 thousand triangles to 948", kBunny, sweep_triangles},
    {"sweeps", "spacing", "the bunny's cameras from 5 to 30 degrees apart", kBunny, sweep_spacing},
    {"sweeps", "calibration", "the dancer's cameras off by 0 to 4 px", "", sweep_calibration},
    {"sweeps", "gains", "the dancer's cameras unequal by 0 to 20 %", "", sweep_gains},
    {"sweeps", "blend", "1 to 8 photographs in a view of the dancer", "", sweep_blend},
    {"sweeps", "flow", "flow of the dancer at full size down to an eighth", "", sweep_flow},
};

}  // namespace

std::span<const Experiment> experiments() { return kExperiments; }

std::vector<std::string> compared_methods(bool light_field) {
  const std::vector<render::RendererInfo> known = render::renderers();
  std::vector<std::string> methods;
  for (const char* name :
       {"band-limited", "filtered", light_field ? "light-field" : "linear", "floating-static", "floating"})
    if (std::any_of(known.begin(), known.end(),
                    [&](const render::RendererInfo& r) { return r.name == name; }))
      methods.emplace_back(name);
  return methods;
}

}  // namespace floatstage::pipeline
