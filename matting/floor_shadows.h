#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

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

/// A plane of the world: up · x = height.
struct Floor {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< of unit length
  double height = 0;
};

/// Shadows that somebody casts on the floor, told by several cameras: a pixel is one where it is darker than
/// the empty stage, and more than half of the other cameras that see the same place of the floor show it
/// darker by as much, two at least. However dark a shadow is and whatever its tint, all cameras see it at one
/// place; what stands on the floor hides another place from each.
///
/// The floor is at z = 0, or where it was sought and found: on the plane below where the cameras look, up to
/// 17 degrees off z or what their pictures show as up, on which most of what is much darker is shadow, where
/// that is about a fifth of it at least and hardly any of it is at z = 0.
///
/// Keeps its memory: nothing is allocated for pictures of one size once as much was dark in them, but where
/// the floor is sought. Deterministic at any thread count; one caller at a time.
class FloorShadows {
 public:
  /// `lightest`: pixels that show more than this share of the stage in a channel are not asked about.
  explicit FloorShadows(Rig rig, float lightest = 0.97F) : rig_(std::move(rig)), lightest_(lightest) {}

  /// The next find() seeks the floor where shadows are not at z = 0, for about a second; until it is found.
  void seek_floor() { seeks_ = !found_; }
  const Floor& floor() const { return floor_; }
  /// Whether that one was found, not supposed.
  bool found_floor() const { return found_; }

  /// Of each camera, in rig order. Valid until the next call.
  const std::vector<FloorShade>& find(std::span<const BeforeStage> cameras, int threads);

 private:
  using Share = std::array<float, 3>;
  struct Rows {
    std::vector<int> columns, now, empty;
  };
  /// A pixel that is darker than the stage, and the way on which its camera sees it.
  struct Dark {
    std::size_t camera = 0, pixel = 0;
    Eigen::Vector3d from, along;
    double farthest = 0;  ///< of `along`
  };

  void look_at(const BeforeStage& camera, std::size_t number);
  void list_dark(std::size_t camera);
  bool agrees(std::size_t camera, int x, int y, int reach, const Share& left, float noise) const;
  bool is_shadow(const Dark& dark, const Floor& floor, int reach) const;
  void darken(std::size_t camera);
  double share_on(const Floor& floor, int reach, int threads);
  void seek(int threads);

  Rig rig_;
  float lightest_;
  Floor floor_;
  bool seeks_ = false, found_ = false;
  std::vector<Rows> rows_;  // a camera
  std::vector<FloorShade> shades_;
  std::vector<std::vector<float>> noise_;  // of a share, a camera and pixel
  std::vector<std::vector<Dark>> dark_;    // a camera
  std::vector<Dark> asked_;                // some of them, where the floor is sought
  std::vector<char> yes_;
};

}  // namespace floatstage::matting
