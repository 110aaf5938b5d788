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
  for (const Wanted& w :
       {Wanted{&made.gray_, "flow_gray.comp", {}},
        Wanted{&made.trust_, "flow_trust.comp", {"synchronize.glsl", "flow.glsl"}},
        Wanted{&made.pull_, "fill_pull.comp", {}}, Wanted{&made.push_, "fill_push.comp", {"fill.glsl"}},
        Wanted{&made.settle_, "flow_settle.comp", {"fill.glsl"}}}) {
    Result<gl::Kernel> kernel = gl::Kernel::create(w.shader, w.shared);
    if (!kernel) return forward(kernel);
    *w.kernel = std::move(*kernel);
  }
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
  const int shrink = options.shrink, small_width = groups_over(width, shrink),
            small_height = groups_over(height, shrink), layers = static_cast<int>(count);
  gray_and_state_.reserve(GL_RG8UI, GL_NEAREST, small_width, small_height, layers);
  gray_.set(0, small_width, small_height).set(1, width, height).set(2, shrink);
  gray_.run({&images}, {&gray_and_state_}, groups_over(small_width, kGroup),
            groups_over(small_height, kGroup), layers, pixels_of(width, height, layers));
  solver_.solve(*preset, tables_, gray_and_state_, small_width, small_height);
  make_dependable(solver_, tables_, gray_and_state_, small_width, small_height, flows);
  return {};
}

void FloatingFlow::make_dependable(const FlowCompute& solver, const FlowTables& tables,
                                   const gl::Texture& gray_and_state, int width, int height,
                                   gl::Texture& flows) {
  const bool half = precision_ == FlowPrecision::Half;
  const GLenum two = half ? GL_RG16F : GL_RG32F, four = half ? GL_RGBA16F : GL_RGBA32F;
  flows.reserve(two, GL_LINEAR, width, height, tables.fields());
  for (fill_levels_ = 0;; width = (width + 1) / 2, height = (height + 1) / 2) {
    if (levels_.size() <= fill_levels_) levels_.emplace_back();
    FillLevel& level = levels_[fill_levels_];
    level.width = width;
    level.height = height;
    level.known.reserve(four, GL_NEAREST, width, height, tables.fields());
    if (fill_levels_++ > 0) level.whole.reserve(two, GL_NEAREST, width, height, tables.fields());
    if (width == 1 && height == 1) break;
  }
  StageTimes::enter("trust");
  const FillLevel& finest = levels_.front();
  trust_.set(0, finest.width, finest.height);
  trust_.run({&solver.fields(), &gray_and_state, &solver.levels()[0].zone_and_own}, {&finest.known},
             groups_over(finest.width, kGroup), groups_over(finest.height, kGroup), tables.fields(),
             pixels_of(finest.width, finest.height, tables.fields()));
  StageTimes::enter("filling");
  fill(tables, flows);
}

void FloatingFlow::fill(const FlowTables& tables, gl::Texture& flows) {
  const int layers = tables.fields();
  auto groups = [&](const gl::Kernel& kernel, const FillLevel& level, gl::Kernel::Textures read,
                    const gl::Texture& written) {
    kernel.run(read, {&written}, groups_over(level.width, kGroup), groups_over(level.height, kGroup), layers,
               pixels_of(level.width, level.height, layers));
  };
  for (std::size_t l = 1; l < fill_levels_; ++l) {
    const FillLevel &fine = levels_[l - 1], &coarse = levels_[l];
    pull_.set(0, coarse.width, coarse.height).set(1, fine.width, fine.height);
    groups(pull_, coarse, {&fine.known}, coarse.known);
  }
  // The coarsest pixel is all there is: it is its own surroundings.
  const gl::Texture* surroundings = &levels_[fill_levels_ - 1].known;
  for (std::size_t l = fill_levels_; l-- > 0;) {
    const FillLevel& coarse = levels_[std::min(l + 1, fill_levels_ - 1)];
    FillLevel& level = levels_[l];
    if (l > 0 && l + 1 == fill_levels_) continue;
    gl::Kernel& kernel = l == 0 ? settle_ : push_;
    const gl::Texture& written = l == 0 ? flows : level.whole;
    kernel.set(0, level.width, level.height).set(1, coarse.width, coarse.height);
    groups(kernel, level, {&level.known, surroundings}, written);
    surroundings = &level.whole;
  }
}

}  // namespace floatstage::render
