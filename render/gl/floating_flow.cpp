#include "render/gl/floating_flow.h"

#include <algorithm>

#include "render/pairwise_flows.h"
#include "render/stage_times.h"

namespace floatstage::render {
namespace {

constexpr int kGroup = 16;  // px: local size of the kernels

std::size_t pixels_of(int width, int height, int layers) {
  return static_cast<std::size_t>(width) * static_cast<std::size_t>(height) *
         static_cast<std::size_t>(layers);
}

}  // namespace

Result<FloatingFlow> FloatingFlow::create(FlowPrecision precision) {
  Result<FlowCompute> solver = FlowCompute::create(precision);
  if (!solver) return forward(solver);
  FloatingFlow made(std::move(*solver), precision);
  struct Wanted {
    gl::Kernel* kernel;
    const char* shader;
    std::initializer_list<std::string_view> shared;
  };
  for (const Wanted& w : {Wanted{&made.gray_, "flow_gray.comp", {}},
                          Wanted{&made.trust_, "flow_trust.comp", {"synchronize.glsl", "flow.glsl"}},
                          Wanted{&made.settle_, "flow_settle.comp", {"fill.glsl"}}}) {
    Result<gl::Kernel> kernel = gl::Kernel::create(w.shader, w.shared);
    if (!kernel) return forward(kernel);
    *w.kernel = std::move(*kernel);
  }
  Result<gl::PullPush> fill = gl::PullPush::create();
  if (!fill) return forward(fill);
  made.fill_ = std::move(*fill);
  return made;
}

Result<void> FloatingFlow::run(const gl::Texture& images, int width, int height,
                               const std::vector<bool>& wanted, const FlowOptions& options,
                               gl::Texture& flows) {
  const Result<VariationalPreset> preset = variational_preset(options);
  if (!preset) return forward(preset);
  const std::size_t count = wanted.size();
  std::vector<WantedField> fields;
  for (std::size_t i = 0; i < count * (count - 1); ++i) {
    const FlowPair pair = flow_pair_at(i, count);
    const int back = static_cast<int>(flow_index_of({pair.second, pair.first}, count));
    fields.push_back({pair, wanted[pair.first] ? back : -1, wanted[pair.second]});
  }
  tables_.write(fields);
  StageTimes::enter("grey");
  const int shrink = options.shrink, small_width = gl::groups_over(width, shrink),
            small_height = gl::groups_over(height, shrink), layers = static_cast<int>(count);
  gray_and_state_.reserve(GL_RG8UI, GL_NEAREST, small_width, small_height, layers);
  gray_.set(0, small_width, small_height).set(1, width, height).set(2, shrink);
  gray_.run({&images}, {&gray_and_state_}, gl::groups_over(small_width, kGroup),
            gl::groups_over(small_height, kGroup), layers, pixels_of(width, height, layers));
  solver_.solve(*preset, tables_, gray_and_state_, small_width, small_height);
  make_dependable(solver_, tables_, gray_and_state_, small_width, small_height, flows);
  return {};
}

void FloatingFlow::make_dependable(const FlowCompute& solver, const FlowTables& tables,
                                   const gl::Texture& gray_and_state, int width, int height,
                                   gl::Texture& flows) {
  const bool half = precision_ == FlowPrecision::Half;
  const int layers = tables.fields();
  flows.reserve(half ? GL_RG16F : GL_RG32F, GL_LINEAR, width, height, layers);
  const auto over = [&](gl::Kernel& kernel, gl::Kernel::Textures read, const gl::Texture& written) {
    kernel.set(0, width, height);
    kernel.run(read, {&written}, gl::groups_over(width, kGroup), gl::groups_over(height, kGroup), layers,
               pixels_of(width, height, layers));
  };
  StageTimes::enter("trust");
  const gl::Texture& known = fill_->begin(width, height, layers, half);
  over(trust_, {&solver.fields(), &gray_and_state, &solver.levels()[0].zone_and_own}, known);
  StageTimes::enter("filling");
  const gl::PullPush::Surroundings around = fill_->surroundings();
  settle_.set(1, around.width, around.height);
  over(settle_, {&known, around.texture}, flows);
}

}  // namespace floatstage::render
