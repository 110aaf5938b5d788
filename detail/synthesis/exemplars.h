#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "detail/synthesis/color_grid.h"
#include "detail/synthesis/nearest_points.h"
#include "detail/synthesis/neighbourhoods.h"

namespace floatstage::detail {

/// A close photograph as it lies in the finest level: RGBA with straight opacity, its top left pixel at
/// (x, y).
struct DetailLayer {
  Image picture;
  int x = 0, y = 0;
  int level = 0;       ///< the finest level that it has details for (Eq. 4.8)
  bool moved = false;  ///< its edges were moved to fit (thesis 4.3.2)
};

/// A layer at every level, by means that weigh colours as much as they are opaque.
class LayerPyramid {
 public:
  /// Takes the layer's colours; it is padded to whole pixels of level 0.
  LayerPyramid(const DetailLayer& layer, int levels);

  const ColorGrid& colors(int level) const { return levels_[static_cast<std::size_t>(level)].colors; }
  /// Whether a pixel shows the layer alone.
  bool covers(int level, int x, int y) const {
    const Grid<std::uint8_t>& w = levels_[static_cast<std::size_t>(level)].whole;
    return w.region.contains(x, y) && w.at(x, y) != 0;
  }
  /// 0 to 1; 0 beyond the layer. Less than 1 near its border.
  float opacity(int level, int x, int y) const {
    const Grid<float>& o = levels_[static_cast<std::size_t>(level)].opacity;
    return o.region.contains(x, y) ? o.at(x, y) : 0.0F;
  }
  int finest() const { return finest_; }
  bool moved() const { return moved_; }

 private:
  struct Level {
    ColorGrid colors;
    Grid<float> opacity;
    Grid<std::uint8_t> whole;
  };
  std::vector<Level> levels_;  ///< 0 the coarsest
  int finest_;
  bool moved_;
};

/// The extended dependency graph (thesis 4.4.1): all close photographs, one below the other, at every level,
/// with what each level adds to the next coarser one and with their neighbourhoods.
class Exemplars {
 public:
  using Place = std::uint32_t;  ///< of a pixel of a level: y * width + x
  static constexpr Place kNowhere = 0xFFFFFFFF;

  struct Level {
    int width = 0, height = 0;
    ColorGrid detail;           ///< what the level adds to the refined coarser one; means over 2 x 2 are 0
    Grid<std::uint8_t> usable;  ///< 1: the neighbourhood and the detail are whole
    Neighbourhoods basis;
    std::vector<float> features;  ///< basis.dimensions() a pixel
    NearestPoints tree;           ///< of usable pixels; not of the finest level
    std::vector<Place> tree_places;
    const float* feature(Place p) const {
      return &features[static_cast<std::size_t>(p) * static_cast<std::size_t>(basis.dimensions())];
    }
  };

  /// Of `layers`, whose opaque parts are used: at most `most` pixels of the finest level, the middle of each.
  Exemplars(const std::vector<LayerPyramid>& layers, int levels, std::size_t most, int threads);

  const Level& level(int t) const { return levels_[static_cast<std::size_t>(t)]; }
  /// Where a pixel of a layer is; kNowhere when it is not among the exemplars or not usable.
  Place place_of(std::size_t layer, int level, int x, int y) const;
  Place shifted(int level, Place place, int dx, int dy) const;

 private:
  struct Part {
    Region from;       ///< of a layer, finest level
    int x = 0, y = 0;  ///< where it is here
  };
  std::vector<Part> parts_;
  std::vector<Level> levels_;
};

}  // namespace floatstage::detail
