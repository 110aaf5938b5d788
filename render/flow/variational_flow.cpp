#include "render/flow/variational_flow.h"

#include <algorithm>
#include <atomic>

#include "core/parallel.h"
#include "core/text.h"
#include "render/flow/field_solver.h"

namespace floatstage::render {
namespace {

constexpr int kLeastSide = 20;  // px of the coarsest level: large displacements, and still something to see
constexpr int kMostFinest = 3;  // levels a field may be enlarged by: beyond it nothing of a picture is left

/// How a preset solves, and what its pictures are prepared for.
struct Preset {
  SolverOptions solver;
  PyramidOptions pyramid;
};

// What `floating` asks for six times a picture. Fields between projections of photographs have less structure
// than those between a film's pictures: smoother, and smooth by squares up to a fifth of a pixel
// (docs/adr/0163).
Preset fast() {
  Preset preset;
  preset.solver.finest_warps = 2;
  preset.solver.most_warps = 8;
  preset.solver.energy.smooth_epsilon2 = 0.05F;
  preset.pyramid.stiffness = 18;
  return preset;
}

Preset quality() {
  Preset preset;
  preset.solver.finest_warps = 8;
  preset.solver.most_warps = 8;
  preset.solver.cubic = true;
  return preset;
}

class VariationalFlow : public FlowEstimator {
 public:
  explicit VariationalFlow(const Preset& preset) : options_(preset.solver), pyramid_(preset.pyramid) {}

  Result<void> estimate(std::span<const FlowImage> images, std::span<const FlowPair> pairs,
                        std::span<const FlowField> initial, int threads,
                        std::span<FlowField> result) override {
    if (Result<void> ok = check_flow_input(images, pairs, initial, result); !ok) return ok;
    if (pairs.empty()) return {};
    const int levels =
        std::max(pyramid_levels(images[0].width, images[0].height, kLeastSide), options_.finest + 1);
    pyramids_.resize(std::max(pyramids_.size(), images.size()));
    parallel_for(images.size(), threads,
                 [&](std::size_t i) { pyramids_[i].build(images[i], levels, pyramid_); });
    const std::size_t workers =
        std::min(pairs.size(), static_cast<std::size_t>(threads > 0 ? threads : default_threads()));
    solvers_.resize(std::max(solvers_.size(), workers));
    std::atomic<std::size_t> next = 0;
    parallel_for(workers, threads, [&](std::size_t worker) {
      for (std::size_t i; (i = next.fetch_add(1)) < pairs.size();) {
        const FlowPair pair = pairs[i];
        const FlowField* from = initial.empty() || initial[i].uv.empty() ? nullptr : &initial[i];
        solvers_[worker].solve(native_flow_kernels(), options_, pyramids_[pair.first], pyramids_[pair.second],
                               levels, from, result[i]);
      }
    });
    return {};
  }

 private:
  SolverOptions options_;
  PyramidOptions pyramid_;
  std::vector<PicturePyramid> pyramids_;
  std::vector<FieldSolver> solvers_;  // one a thread: its memory stays in that thread's cache
};

}  // namespace

Result<std::unique_ptr<FlowEstimator>> make_variational_flow(const FlowOptions& options) {
  Preset preset = fast();
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
  return std::unique_ptr<FlowEstimator>(std::make_unique<VariationalFlow>(preset));
}

}  // namespace floatstage::render
