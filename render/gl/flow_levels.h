#pragma once

#include <cstddef>
#include <vector>

#include "render/flow/variational_preset.h"
#include "render/gl/flow_tables.h"
#include "render/gl/kernel.h"

namespace floatstage::render {

/// How fields and equations are stored on the GPU. Pictures are always exact, arithmetic always 32-bit.
enum class FlowPrecision { Half, Float };

/// One level of all pictures, one layer a picture (PictureLevel on the GPU).
struct FlowLevel {
  int width = 0, height = 0;
  gl::Texture value;         ///< R32F: smoothed brightness
  gl::Texture zone_and_own;  ///< RG8UI: domain or not, share of evidence
  gl::Texture samples;       ///< R16UI: brightness with band, in 1/128, and one bit of evidence
  gl::Texture weights;       ///< stiffness, weight of the data
  gl::Texture spans;         ///< RG16UI, row by picture
  gl::TileList tiles;        ///< of kFlowTile px
  gl::TileList sweep_tiles;  ///< of sweep_side px
  int sweep_side = 0;        ///< px that one work group relaxes …
  int sweep_halo = 0;        ///< … with so many around
  int fused = 0;             ///< … so many sweeps at a time

  std::size_t pixels() const { return static_cast<std::size_t>(width) * static_cast<std::size_t>(height); }
};

constexpr int kFlowTile = 32;   // px; shaders/flow_place.glsl has the same
constexpr int kSweepSide = 64;  // px with the halo; shaders/flow_relax.comp has the same

/// The pyramids of several pictures on the GPU (PicturePyramid), and which tiles of them hold something.
class FlowLevels {
 public:
  static Result<FlowLevels> create(FlowPrecision precision);

  /// `gray_and_state` (RG8UI, a layer a picture) holds `width` * `height` pixels. `fused`: sweeps in one go
  /// where a level is larger than one work group.
  void build(const VariationalPreset& preset, const FlowTables& tables, const gl::Texture& gray_and_state,
             int width, int height, int fused);
  int count() const { return count_; }
  const FlowLevel& operator[](int l) const { return levels_[static_cast<std::size_t>(l)]; }

 private:
  FlowLevels() = default;
  void reserve(FlowLevel& level, int width, int height, int pictures);
  void list_tiles(FlowLevel& level, const FlowTables& tables, gl::TileList& list, int side);

  FlowPrecision precision_ = FlowPrecision::Half;
  gl::Kernel smooth_, halve_, prepare_, spans_, tiles_;
  std::vector<FlowLevel> levels_;
  int count_ = 0;
};

/// Storage of at least this size that holds zeros, not chance, when it is new.
void reserve_cleared(gl::Texture& texture, GLenum format, int width, int height, int layers,
                     GLenum filter = GL_NEAREST);

}  // namespace floatstage::render
