#pragma once

#include <cstdint>
#include <vector>

#include "render/cpu/projection.h"

namespace floatstage::render::cpu {

/// How opaque a picture is at the proxy's outline: as much of a pixel as the proxy covers (anti-aliased),
/// times what the photographs' mattes say there; far from the outline it is opaque.
/// The passes of render/gl/outline.h; docs/adr/0261-opacity-at-the-outline.md.
class Outline {
 public:
  /// After the picture of the projection's view is drawn, opaque where the proxy covers a pixel's centre:
  /// gives it its opacity, and beside the outline colours of what is next. `show`: the opacity as grey
  /// instead of the picture.
  void run(Projection& projection, bool show, Image& picture);

 private:
  template <class Body>  // (first row, the one after the last)
  void for_bands(const Projection& projection, const Body& body) const;
  void reserve(const Projection& projection);
  std::uint8_t* scratch_of(int first);
  void find_outside(const Projection& projection, int first, int last);
  void find_rim(const Projection& projection, int first, int last);
  void cover_rim(const Projection& projection);
  void weigh_row(const Projection& projection, int y, Image& picture);
  void blend_rim(const Projection& projection, int y, bool show, Image& picture) const;

  int left_ = 0, right_ = 0, top_ = 0, bottom_ = 0;  // the part of the window that the view shows
  int reach_ = 0;                                    // px
  std::vector<std::uint8_t> outside_;                // plane: 1 where the proxy is not
  std::vector<std::uint8_t> rim_;                    // plane: 1 where it ends within a pixel
  std::vector<std::uint8_t> covered_;                // plane: of the rim, a bit a sample
  std::vector<std::uint8_t> solid_;                  // plane: opacity but for the coverage
  std::vector<std::int16_t> distances_;              // plane: along the row to what is outside, squared
  std::vector<std::uint8_t> near_;                   // a row each: whether any distance is
  std::vector<std::uint8_t> memory_;                 // scratch_ bytes for each band of rows
  std::size_t scratch_ = 0;
};

}  // namespace floatstage::render::cpu
