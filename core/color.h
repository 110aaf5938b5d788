#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace floatstage {

/// Makes a camera's colours agree with the rig's. Channels of the picture, 0..1 in its own (gamma) space, are
/// raised to `decode` (light), mixed by `matrix` (white balance, exposure, crosstalk) and raised to 1 /
/// `encode`: rgb' = (matrix * rgb^decode)^(1/encode), clamped to 0..1. With exponents of 1 it is a matrix in
/// the picture's space.
struct ColorTransform {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Identity();
  Eigen::Vector3d decode = Eigen::Vector3d::Ones();
  double encode = 1;

  bool has_curve() const { return encode != 1 || decode != Eigen::Vector3d::Ones(); }
  bool is_identity() const { return !has_curve() && matrix == Eigen::Matrix3d::Identity(); }
};

Eigen::Vector3d apply(const ColorTransform& transform, const Eigen::Vector3d& rgb);

/// A transform prepared for pictures of 8 bits: tables for the curves, right to half a level.
class ColorTable {
 public:
  explicit ColorTable(const ColorTransform& transform);
  /// `from` and `to` are three bytes and may be the same.
  void apply(const std::uint8_t* from, std::uint8_t* to) const;

 private:
  static constexpr int kLight = 1 << 14;  // steps of light: fine enough for the dark end of an encoding curve
  Eigen::Matrix3d matrix_;
  std::array<std::array<double, 256>, 3> light_;
  std::vector<std::uint8_t> byte_;  // empty: no encoding curve
};

}  // namespace floatstage
