#include "render/flow/variational_preset.h"

#include <algorithm>

#include "core/text.h"

namespace floatstage::render {
namespace {

constexpr int kLeastSide = 20;  // px of the coarsest level: large displacements, and still something to see
constexpr int kMostFinest = 3;  // levels a field may be enlarged by: beyond it nothing of a picture is left

// What `floating` asks for six times a picture. Fields between projections of photographs have less structure
// than those between a film's pictures: smoother, and smooth by squares up to a fifth of a pixel
// (docs/adr/0163).
VariationalPreset fast() {
  VariationalPreset preset;
  preset.solver.finest_warps = 2;
  preset.solver.most_warps = 8;
  preset.solver.energy.smooth_epsilon2 = 0.05F;
  preset.pyramid.stiffness = 18;
  return preset;
}

VariationalPreset quality() {
  VariationalPreset preset;
  preset.solver.finest_warps = 8;
  preset.solver.most_warps = 8;
  preset.solver.cubic = true;
  return preset;
}

}  // namespace

Result<VariationalPreset> variational_preset(const FlowOptions& options) {
  VariationalPreset preset = fast();
  if (options.preset == "quality")
    preset = quality();
  else if (!options.preset.empty() && options.preset != "fast")
    return fail(ErrorCode::InvalidArgument, text("unknown preset '", options.preset,
                                                 "' of the variational flow; there are: quality, fast"));
  if (options.finest_scale < 0 || options.finest_scale > kMostFinest)
    return fail(ErrorCode::InvalidArgument,
                text("the variational flow cannot stop at its finest scale ", options.finest_scale, "; 0 to ",
                     kMostFinest, " are possible"));
  preset.solver.finest = options.finest_scale;
  if (options.iterations < 0 || options.iterations > preset.solver.most_warps)
    return fail(ErrorCode::InvalidArgument, text(options.iterations, " warps of the variational flow; 0 to ",
                                                 preset.solver.most_warps, " are possible"));
  if (options.iterations > 0) preset.solver.finest_warps = options.iterations;
  return preset;
}

int variational_levels(int width, int height, int finest) {
  return std::max(pyramid_levels(width, height, kLeastSide), finest + 1);
}

}  // namespace floatstage::render
