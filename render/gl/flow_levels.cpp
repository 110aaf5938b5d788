#include "render/gl/flow_levels.h"

#include <algorithm>

namespace floatstage::render {
namespace {

constexpr int kGroup = 16;  // px: local size of the kernels that go over whole pictures

GLenum base_format(GLenum format) {
  switch (format) {
    case GL_R16UI:
      return GL_RED_INTEGER;
    case GL_RG8UI:
    case GL_RG16UI:
      return GL_RG_INTEGER;
    default:
      return GL_RGBA;
  }
}

}  // namespace

void reserve_cleared(gl::Texture& texture, GLenum format, int width, int height, int layers, GLenum filter) {
  if (!texture.reserve(format, filter, width, height, layers)) return;
  const GLenum base = base_format(format);
  glClearTexImage(texture.id(), 0, base, base == GL_RGBA ? GL_FLOAT : GL_UNSIGNED_INT, nullptr);
}

Result<FlowLevels> FlowLevels::create(FlowPrecision precision) {
  FlowLevels made;
  made.precision_ = precision;
  struct Wanted {
    gl::Kernel* kernel;
    const char* shader;
  };
  for (const Wanted& w : {Wanted{&made.smooth_, "flow_smooth.comp"}, Wanted{&made.halve_, "flow_halve.comp"},
                          Wanted{&made.prepare_, "flow_prepare.comp"},
                          Wanted{&made.spans_, "flow_spans.comp"}, Wanted{&made.tiles_, "flow_tiles.comp"}}) {
    Result<gl::Kernel> kernel = gl::Kernel::create(w.shader, {"synchronize.glsl", "flow.glsl"});
    if (!kernel) return forward(kernel);
    *w.kernel = std::move(*kernel);
  }
  return made;
}

void FlowLevels::reserve(FlowLevel& level, int width, int height, int pictures) {
  level.width = width;
  level.height = height;
  const GLenum pair = precision_ == FlowPrecision::Half ? GL_RG16F : GL_RG32F;
  level.value.reserve(GL_R32F, GL_NEAREST, width, height, pictures);
  level.zone_and_own.reserve(GL_RG8UI, GL_NEAREST, width, height, pictures);
  level.samples.reserve(GL_R16UI, GL_NEAREST, width, height, pictures);
  level.weights.reserve(pair, GL_NEAREST, width, height, pictures);
  level.spans.reserve(GL_RG16UI, GL_NEAREST, height, pictures);
}

void FlowLevels::list_tiles(FlowLevel& level, const FlowTables& tables, gl::TileList& list, int side) {
  const int across = gl::groups_over(level.width, side), down = gl::groups_over(level.height, side);
  list.begin(static_cast<std::size_t>(across * down * tables.pictures()), tables.from_one());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 2, list.id());
  tiles_.set(0, level.width, level.height).set(1, side);
  tiles_.run({&level.weights}, {}, across, down, tables.pictures(),
             level.pixels() * static_cast<std::size_t>(tables.pictures()));
}

void FlowLevels::build(const VariationalPreset& preset, const FlowTables& tables,
                       const gl::Texture& gray_and_state, int width, int height, int fused) {
  count_ = variational_levels(width, height, preset.solver.finest);
  levels_.resize(std::max(levels_.size(), static_cast<std::size_t>(count_)));
  const int pictures = tables.pictures();
  for (int l = 0; l < count_; ++l, width = (width + 1) / 2, height = (height + 1) / 2) {
    FlowLevel& level = levels_[static_cast<std::size_t>(l)];
    reserve(level, width, height, pictures);
    const int across = gl::groups_over(width, kGroup), down = gl::groups_over(height, kGroup);
    const std::size_t pixels = level.pixels() * static_cast<std::size_t>(pictures);
    if (l == 0) {
      smooth_.set(0, width, height);
      smooth_.run({&gray_and_state}, {&level.value, &level.zone_and_own}, across, down, pictures, pixels);
    } else {
      const FlowLevel& fine = levels_[static_cast<std::size_t>(l) - 1];
      halve_.set(0, width, height).set(1, fine.width, fine.height);
      halve_.run({&fine.value, &fine.zone_and_own}, {&level.value, &level.zone_and_own}, across, down,
                 pictures, pixels);
    }
    prepare_.set(0, width, height).set(1, preset.pyramid.stiffness, preset.pyramid.edge);
    prepare_.run({&level.value, &level.zone_and_own}, {&level.samples, &level.weights}, across, down,
                 pictures, pixels);
    spans_.set(0, width);
    spans_.run({&level.weights}, {&level.spans}, height, pictures, 1, pixels);
    const bool whole = width <= kSweepSide && height <= kSweepSide;
    level.fused = whole ? preset.solver.sweeps_at(std::max(l, preset.solver.finest)) : fused;
    level.sweep_halo = whole ? 0 : 2 * fused;
    level.sweep_side = kSweepSide - 2 * level.sweep_halo;
    list_tiles(level, tables, level.tiles, kFlowTile);
    if (l >= preset.solver.finest) list_tiles(level, tables, level.sweep_tiles, level.sweep_side);
  }
}

}  // namespace floatstage::render
