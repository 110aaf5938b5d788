#include <cmath>
#include <numbers>

#include "calib/color.h"

namespace floatstage::calib {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

double linear(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }

double lab_curve(double t) {
  constexpr double kCut = 216.0 / 24389, kSlope = 24389.0 / 27;
  return t > kCut ? std::cbrt(t) : (kSlope * t + 16) / 116;
}

// In degrees, 0 … 360; 0 for grey.
double hue(double a, double b) {
  if (a == 0 && b == 0) return 0;
  const double h = std::atan2(b, a) / kDegree;
  return h < 0 ? h + 360 : h;
}

}  // namespace

Eigen::Vector3d lab_from_srgb(const Eigen::Vector3d& rgb) {
  Eigen::Matrix3d xyz_from_rgb;
  xyz_from_rgb << 0.4124564, 0.3575761, 0.1804375, 0.2126729, 0.7151522, 0.0721750, 0.0193339, 0.1191920,
      0.9503041;
  const Eigen::Vector3d xyz =
      xyz_from_rgb * Eigen::Vector3d(linear(rgb.x()), linear(rgb.y()), linear(rgb.z()));
  const double x = lab_curve(xyz.x() / 0.95047), y = lab_curve(xyz.y()), z = lab_curve(xyz.z() / 1.08883);
  return {116 * y - 16, 500 * (x - y), 200 * (y - z)};
}

double delta_e_2000(const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
  const double mean_chroma = 0.5 * (std::hypot(p.y(), p.z()) + std::hypot(q.y(), q.z()));
  auto seventh = [](double c) { return std::sqrt(std::pow(c, 7) / (std::pow(c, 7) + std::pow(25.0, 7))); };
  const double stretch = 1 + 0.5 * (1 - seventh(mean_chroma));
  const double a1 = stretch * p.y(), a2 = stretch * q.y();
  const double c1 = std::hypot(a1, p.z()), c2 = std::hypot(a2, q.z());
  const double h1 = hue(a1, p.z()), h2 = hue(a2, q.z());
  const bool grey = c1 * c2 == 0;

  double dh = grey ? 0 : h2 - h1;
  if (dh > 180) dh -= 360;
  if (dh < -180) dh += 360;
  const double dl = q.x() - p.x(), dc = c2 - c1, d_hue = 2 * std::sqrt(c1 * c2) * std::sin(dh / 2 * kDegree);

  double mean_hue = h1 + h2;  // of a grey and a colour: the colour's
  if (!grey) {
    if (std::abs(h1 - h2) > 180) mean_hue += mean_hue < 360 ? 360 : -360;
    mean_hue /= 2;
  }
  const double l = 0.5 * (p.x() + q.x()), c = 0.5 * (c1 + c2);
  const double t = 1 - 0.17 * std::cos((mean_hue - 30) * kDegree) + 0.24 * std::cos(2 * mean_hue * kDegree) +
                   0.32 * std::cos((3 * mean_hue + 6) * kDegree) -
                   0.20 * std::cos((4 * mean_hue - 63) * kDegree);
  const double turn = 30 * std::exp(-std::pow((mean_hue - 275) / 25, 2));
  const double sl = 1 + 0.015 * (l - 50) * (l - 50) / std::sqrt(20 + (l - 50) * (l - 50));
  const double sc = 1 + 0.045 * c, sh = 1 + 0.015 * c * t;
  const double rotation = -std::sin(2 * turn * kDegree) * 2 * seventh(c);
  const double x = dl / sl, y = dc / sc, z = d_hue / sh;
  return std::sqrt(x * x + y * y + z * z + rotation * y * z);
}

}  // namespace floatstage::calib
