#pragma once

#include <array>

#include "render/cpu/photo_kernels.h"
#include "render/photo_pyramid.h"

namespace floatstage::render::cpu {

class RowMemory;

/// A photograph that is read for pixels of any footprint: itself, and its pyramid where there is one.
class PhotoLevels {
 public:
  /// `pyramid`: with this camera's levels; null: every footprint reads the photograph alone.
  void set(const PhotoCamera& photograph, const PhotoPyramid* pyramid, std::size_t camera);
  const PhotoCamera& photograph() const { return levels_[0]; }
  bool has_levels() const { return has_levels_; }

  /// Colours as read_colors() reads them, of the levels that `area` asks for (footprints(); null: the
  /// photograph alone). u, v are pixels of the photograph.
  void read(bool sharp, const float* u, const float* v, const float* area, const std::int32_t* wanted,
            int count, float* rgba, RowMemory& memory) const;

 private:
  std::array<PhotoCamera, kLastLevel + 1> levels_{};
  bool has_levels_ = false;
};

}  // namespace floatstage::render::cpu
