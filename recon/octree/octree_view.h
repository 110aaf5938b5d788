#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "core/matte.h"
#include "core/rig.h"

namespace floatstage::recon {

/// What one camera says of one point of space.
enum class PointVerdict : std::uint8_t {
  Unseen,      ///< behind the camera, outside its image, or beyond its lens: the camera does not know
  Background,  ///< carved
  Subject,
};

/// What one camera says of a whole box. Every verdict but Mixed holds for each of its points.
enum class BoxVerdict : std::uint8_t {
  Unseen,
  Background,
  Subject,
  NotBackground,  ///< subject or unseen, point by point: never carved
  Mixed,          ///< anything; ask smaller boxes
};

/// One camera with its matte, prepared for carving: a fast projection through the lens, the matte as a
/// continuous function (bilinear between pixel centres, subject from half opacity), and an integral image of
/// its subject, so that a box of space is judged by four look-ups. Immutable; safe from any thread.
class OctreeView {
 public:
  /// The matte must not be empty and must have the camera's size; both are only read.
  OctreeView(const RigCamera& camera, const Matte& matte);

  /// `world` in metres.
  PointVerdict at(const Eigen::Vector3d& world) const;
  /// Conservative: never wrong, but Mixed may be returned for a box that a finer look would decide.
  BoxVerdict over(const Eigen::AlignedBox3d& world) const;

 private:
  struct PixelRange {
    double u0, u1, v0, v1;
    bool partly_unseen;
  };
  Eigen::Vector2d project_normalized(double x, double y) const;
  std::optional<PixelRange> pixel_range(double x0, double x1, double y0, double y1) const;
  std::uint32_t subjects(int x0, int y0, int x1, int y1) const;

  Matte matte_;
  CameraModel model_;
  bool pinhole_ = true;
  double largest_r2_ = 0;  // of normalised points the lens model is good for
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d translation_;
  Eigen::Matrix3d pixel_rotation_;  // K R and K t: for pinholes, straight to homogeneous pixels
  Eigen::Vector3d pixel_translation_;
  std::vector<std::uint32_t> integral_;  // (width + 1) × (height + 1) counts of pixels with alpha >= 128
};

}  // namespace floatstage::recon
