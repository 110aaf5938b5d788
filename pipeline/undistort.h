#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/image.h"

namespace floatstage::pipeline {

/// The picture that pinhole(model) would have taken: each pixel is looked up through the lens by bicubic
/// interpolation (Catmull-Rom; rings are clamped to 0…255). A picture of a camera without a lens comes back
/// as it is. Pixels that the photograph does not show are 0.
Image undistorted(const Image& photograph, const CameraModel& model);

/// A camera of the same size without lens and skew, which other programs' pinholes are.
CameraModel straight(CameraModel model);

/// Where one camera sees what another at the same place sees: looked up once for many pictures. `to` has no
/// lens. 16 bytes a pixel of `to`.
class Retaking {
 public:
  Retaking(const CameraModel& from, const CameraModel& to);

  /// The place in the picture of `from`, px; absent where that shows nothing of it.
  std::optional<Eigen::Vector2d> source(int x, int y) const {
    const Eigen::Vector2d& p = sources_[index(x, y)];
    return p.x() < 0 ? std::nullopt : std::optional(p);
  }
  /// A picture of `from`, as undistorted() looks it up.
  Image operator()(const Image& photograph) const;
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  std::size_t index(int x, int y) const { return static_cast<std::size_t>(y) * width_ + x; }

  int width_, height_;
  std::vector<Eigen::Vector2d> sources_;  // negative: none
};

/// The picture of one camera as another at the same place would have taken it, by one Retaking. Where both
/// are one camera the picture comes back as it is.
Image retaken(const Image& photograph, const CameraModel& from, const CameraModel& to);

}  // namespace floatstage::pipeline
