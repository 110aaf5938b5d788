#pragma once

#include <array>
#include <cstdint>
#include <optional>
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
struct CastShade {
  int width = 0, height = 0;               ///< 0 without a picture
  std::vector<std::uint8_t> mask;          ///< a byte a pixel, 255 in shadows
  std::vector<std::array<float, 3>> left;  ///< of each pixel the share of the stage's colour that is seen

  bool any() const { return shadows > 0; }
  std::size_t shadows = 0;  ///< pixels
};

/// A plane of the world that shadows fall on: normal · x = offset. Cameras are where the normal points to.
struct ShadedPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< of unit length
  double offset = 0;
  double farthest = 2;  ///< so far off its places are at most, of how far cameras look
};

/// Shadows that somebody casts on the floor and on walls, told by several cameras: a pixel is one where it is
/// darker than the empty stage, and more than half of the other cameras that see the same place of the plane
/// show it darker by as much, two at least. However dark a shadow is and whatever its tint, all cameras see
/// it at one place; what stands before the plane hides another place from each.
///
/// The floor is at z = 0 (no farther off than twice where the cameras look: beyond stand walls, whose floor
/// nobody sees), or where it was sought and found: on the plane below where the cameras look, up to 17
/// degrees off z or what their pictures show as up, on which most of what is much darker is shadow, a fifth
/// of it about at least, and hardly any a body's thickness above or below.
///
/// Walls are only where they were sought and found: planes behind which no camera stands, farther off than
/// where the cameras look, on which a fifth at least of what is much darker and not on the floor agrees
/// within a pixel, hardly more with wider windows, and less a body's thickness nearer or farther. Somebody in
/// dark clothes agrees on a plane through himself too, but he is round, and nobody stands before him who is
/// large enough to cast him.
///
/// Keeps its memory: nothing is allocated for pictures of one size once as much was dark in them, but where
/// planes are sought. Deterministic at any thread count; one caller at a time.
class CastShadows {
 public:
  /// `lightest`: pixels that show more than this share of the stage in a channel are not asked about.
  explicit CastShadows(Rig rig, float lightest = 0.97F) : rig_(std::move(rig)), lightest_(lightest) {}

  /// The next find() seeks the floor, until it is found, and walls where much is dark that is on no plane
  /// yet: up to a second or two.
  void seek_planes() { seeks_ = true; }
  const ShadedPlane& floor() const { return floor_; }
  /// Whether shadows that were sought lie on that one; else it is supposed.
  bool found_floor() const { return found_floor_; }
  const std::vector<ShadedPlane>& walls() const { return walls_; }

  /// Of each camera, in rig order. Valid until the next call.
  const std::vector<CastShade>& find(std::span<const BeforeStage> cameras, int threads);

 private:
  static constexpr float kUnsure = 0.3F;  // of a share, what noise does to it where nothing can be told
  using Share = std::array<float, 3>;
  struct Rows {
    std::vector<int> columns, now, empty;
  };
  /// A pixel that is darker than the stage, and the way on which its camera sees it.
  struct Dark {
    std::size_t camera = 0, pixel = 0;
    Eigen::Vector3d from, along;
    double looks_at = 0;  ///< so many times `along` is where cameras look
  };

  void look_at(const BeforeStage& camera, std::size_t number);
  void list_dark(std::size_t camera);
  bool agrees(std::size_t camera, int x, int y, int reach, const Share& left, float noise) const;
  bool is_shadow(const Dark& dark, const ShadedPlane& plane, int reach) const;
  bool is_shadow(const Dark& dark) const;
  void darken(std::size_t camera);

  /// Pixels that are much darker, without the shadows on these planes.
  std::vector<Dark> deep(std::span<const ShadedPlane> but_on) const;
  double share_on(std::span<const Dark> asked, const ShadedPlane& plane, int reach, int threads) const;
  std::size_t much_changed() const;
  void seek(int threads);
  void seek_floor(int threads);
  std::optional<ShadedPlane> another_wall(int threads) const;

  Rig rig_;
  float lightest_;
  ShadedPlane floor_;
  std::vector<ShadedPlane> walls_;
  bool seeks_ = false, found_floor_ = false;
  std::vector<Rows> rows_;  // a camera
  std::vector<CastShade> shades_;
  std::vector<std::vector<float>> noise_;  // of a share, a camera and pixel
  std::vector<std::vector<Dark>> dark_;    // a camera
};

}  // namespace floatstage::matting
