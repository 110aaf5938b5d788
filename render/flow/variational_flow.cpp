#include "render/flow/variational_flow.h"

#include <algorithm>
#include <atomic>

#include "core/parallel.h"
#include "render/flow/variational_preset.h"

namespace floatstage::render {
namespace {

class VariationalFlow : public FlowEstimator {
 public:
  explicit VariationalFlow(const VariationalPreset& preset)
      : options_(preset.solver), pyramid_(preset.pyramid) {}

  Result<void> estimate(std::span<const FlowImage> images, std::span<const FlowPair> pairs,
                        std::span<const FlowField> initial, int threads,
                        std::span<FlowField> result) override {
    if (Result<void> ok = check_flow_input(images, pairs, initial, result); !ok) return ok;
    if (pairs.empty()) return {};
    const int levels = variational_levels(images[0].width, images[0].height, options_.finest);
    pyramids_.resize(std::max(pyramids_.size(), images.size()));
    parallel_for(images.size(), threads,
                 [&](std::size_t i) { pyramids_[i].build(images[i], levels, pyramid_); });
    if (given_up()) return render::given_up();
    const std::size_t workers =
        std::min(pairs.size(), static_cast<std::size_t>(threads > 0 ? threads : default_threads()));
    solvers_.resize(std::max(solvers_.size(), workers));
    std::atomic<std::size_t> next = 0;
    parallel_for(workers, threads, [&](std::size_t worker) {
      for (std::size_t i; (i = next.fetch_add(1)) < pairs.size() && !given_up();) {
        const FlowPair pair = pairs[i];
        const FlowField* from = initial.empty() || initial[i].uv.empty() ? nullptr : &initial[i];
        solvers_[worker].solve(native_flow_kernels(), options_, pyramids_[pair.first], pyramids_[pair.second],
                               levels, from, result[i]);
      }
    });
    if (given_up()) return render::given_up();
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
  Result<VariationalPreset> preset = variational_preset(options);
  if (!preset) return forward(preset);
  return std::unique_ptr<FlowEstimator>(std::make_unique<VariationalFlow>(*preset));
}

}  // namespace floatstage::render
