// Variational optical flow on the GPU: thesis 2.10; Brox, Bruhn, Papenberg and Weickert 2004, with what
// render/flow/ changes of it. Equations are for the increment of each warp, so that half floats hold them;
// sweeps are fused in shared memory (docs/adr/0167).
#include "render/gl/flow_compute.h"

#include <algorithm>

#include "core/check.h"
#include "render/stage_times.h"

namespace floatstage::render {

Result<FlowCompute> FlowCompute::create(FlowPrecision precision) {
  Result<FlowLevels> levels = FlowLevels::create(precision);
  if (!levels) return forward(levels);
  FlowCompute made(std::move(*levels), precision);
  struct Wanted {
    gl::Kernel* kernel;
    const char* shader;
    std::initializer_list<std::string_view> shared;
  };
  for (const Wanted& w : {Wanted{&made.enlarge_, "flow_enlarge.comp", {"flow.glsl", "flow_place.glsl"}},
                          Wanted{&made.guided_, "flow_guided.comp", {"flow.glsl", "flow_place.glsl"}},
                          Wanted{&made.equations_,
                                 "flow_equations.comp",
                                 {"synchronize.glsl", "flow.glsl", "flow_place.glsl", "flow_sample.glsl"}},
                          Wanted{&made.relax_, "flow_relax.comp", {"synchronize.glsl", "flow.glsl"}}}) {
    Result<gl::Kernel> kernel = gl::Kernel::create(w.shader, w.shared);
    if (!kernel) return forward(kernel);
    *w.kernel = std::move(*kernel);
  }
  return made;
}

void FlowCompute::reserve(const FlowTables& tables) {
  const bool half = precision_ == FlowPrecision::Half;
  const GLenum two = half ? GL_RG16F : GL_RG32F, four = half ? GL_RGBA16F : GL_RGBA32F;
  fields_.resize(std::max(fields_.size(), static_cast<std::size_t>(levels_.count())));
  for (int l = 0; l < levels_.count(); ++l)
    for (gl::Texture& field : fields_[static_cast<std::size_t>(l)])
      reserve_cleared(field, two, levels_[l].width, levels_[l].height, tables.fields());
  for (gl::Texture* texture : {&tensor_and_right_, &sides_and_down_})
    reserve_cleared(*texture, four, levels_[0].width, levels_[0].height, tables.fields());
  for (gl::Texture& increment : increments_)
    reserve_cleared(increment, two, levels_[0].width, levels_[0].height, tables.fields());
}

void FlowCompute::enlarge(const VariationalPreset& preset, const FlowTables& tables, int l) {
  const FlowLevel &fine = levels_[l], &coarse = levels_[l + 1];
  const auto n = static_cast<std::size_t>(l);
  const gl::Texture &from = fields_[n + 1][static_cast<std::size_t>(current_)], &to = fields_[n][0];
  const std::size_t pixels = fine.pixels() * static_cast<std::size_t>(tables.asked());
  current_ = 0;
  gl::Kernel& kernel = l >= preset.solver.finest ? enlarge_ : guided_;
  kernel.set(0, fine.width, fine.height).set(1, coarse.width, coarse.height);
  if (&kernel == &enlarge_) return kernel.run({&from, &fine.spans}, {&to}, fine.tiles, pixels);
  kernel.set(2, 1.F / (preset.solver.guide_edge * preset.solver.guide_edge));
  kernel.run({&from, &fine.spans, &coarse.value, &coarse.zone_and_own, &fine.samples}, {&to}, fine.tiles,
             pixels);
}

void FlowCompute::warp(const SolverOptions& options, const FlowTables& tables, int l) {
  const FlowLevel& level = levels_[l];
  const FlowEnergy& e = options.energy;
  std::array<gl::Texture, 2>& fields = fields_[static_cast<std::size_t>(l)];
  const gl::Texture &from = fields[static_cast<std::size_t>(current_)],
                    &to = fields[static_cast<std::size_t>(1 - current_)];
  const std::size_t pixels = level.pixels() * static_cast<std::size_t>(tables.asked());
  StageTimes::enter("equations");
  equations_.set(0, level.width, level.height)
      .set(1, e.gradient_weight, e.noise2, e.data_epsilon2, e.smooth_epsilon2)
      .set(2, options.cubic ? 1 : 0);
  equations_.run({&from, &level.samples, &level.weights}, {&tensor_and_right_, &sides_and_down_}, level.tiles,
                 pixels);
  StageTimes::enter("sweeps");
  relax_.set(0, level.width, level.height).set(1, level.sweep_side).set(2, level.sweep_halo).set(4, e.omega);
  const int sweeps = options.sweeps_at(l);
  for (int done = 0, turn = 0; done < sweeps; turn = 1 - turn) {
    const int now = std::min(level.fused, sweeps - done);
    const bool first = done == 0, last = done + now == sweeps;
    done += now;
    const gl::Texture &before = increments_[static_cast<std::size_t>(turn)],
                      &after = increments_[static_cast<std::size_t>(1 - turn)];
    relax_.set(3, now).set(5, first ? 1 : 0).set(6, last ? 1 : 0);
    relax_.run({&tensor_and_right_, &sides_and_down_, first ? nullptr : &before, last ? &from : nullptr},
               {last ? &to : &after}, level.sweep_tiles, pixels);
  }
  current_ = 1 - current_;
}

void FlowCompute::solve(const VariationalPreset& preset, const FlowTables& tables,
                        const gl::Texture& gray_and_state, int width, int height, int fused) {
  FLOATSTAGE_CHECK(fused >= 1 && fused <= kMostFused, "sweeps that one work group holds");
  StageTimes::enter("pyramids");
  levels_.build(preset, tables, gray_and_state, width, height, fused);
  reserve(tables);
  const int start = levels_.count() - 1;
  current_ = 0;
  glClearTexImage(fields_[static_cast<std::size_t>(start)][0].id(), 0, GL_RG, GL_FLOAT, nullptr);
  for (int l = start; l >= 0; --l) {
    if (l < start) {
      StageTimes::enter("enlargements");
      enlarge(preset, tables, l);
    }
    if (l < preset.solver.finest) continue;
    for (int k = 0; k < preset.solver.warps_at(l); ++k) warp(preset.solver, tables, l);
  }
}

}  // namespace floatstage::render
