#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/image.h"
#include "core/rig.h"

namespace floatstage::matting {

/// What a camera sees and what it sees of the empty stage: RGB, of one size, which may be smaller than the
/// camera's. Both or neither; not owned.
struct BeforeStage {
  const Image* picture = nullptr;
  const Image* stage = nullptr;
};

/// Where shadows fall in a camera's picture.
struct FloorShade {
  int width = 0, height = 0;               ///< 0 without a picture
  std::vector<std::uint8_t> mask;          ///< a byte a pixel, 255 in shadows
  std::vector<std::array<float, 3>> left;  ///< of each pixel the share of the stage's colour that is seen

  bool any() const { return shadows > 0; }
  std::size_t shadows = 0;  ///< pixels
};

/// Shadows that somebody casts on the floor (z = 0), told by several cameras: a pixel is one where it is
/// darker than the empty stage, and more than half of the other cameras that see the same place of the floor
/// show it darker by as much, two at least. However dark a shadow is and whatever its tint, all cameras see
/// it at one place; what stands on the floor hides another place from each. Of a floor that is not at z = 0
/// nothing is found.
///
/// Keeps its memory: nothing is allocated for pictures of one size. Deterministic at any thread count; one
/// caller at a time.
class FloorShadows {
 public:
  /// `lightest`: pixels that show more than this share of the stage in a channel are not asked about.
  explicit FloorShadows(Rig rig, float lightest = 0.97F) : rig_(std::move(rig)), lightest_(lightest) {}

  /// Of each camera, in rig order. Valid until the next call.
  const std::vector<FloorShade>& find(std::span<const BeforeStage> cameras, int threads);

 private:
  void look_at(const BeforeStage& camera, std::size_t number);
  void search(std::size_t camera);
  bool agrees(std::size_t camera, int x, int y, const std::array<float, 3>& left, float noise) const;

  struct Rows {
    std::vector<int> columns, now, empty;
  };

  Rig rig_;
  float lightest_;
  std::vector<Rows> rows_;  // a camera
  std::vector<FloorShade> shades_;
  std::vector<std::vector<float>> noise_;  // of a share, a camera and pixel
};

}  // namespace floatstage::matting
