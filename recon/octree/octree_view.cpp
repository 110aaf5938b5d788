#include "recon/octree/octree_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace floatstage::recon {
namespace {

struct Interval {
  double lo, hi;
};

Interval operator+(Interval a, Interval b) { return {a.lo + b.lo, a.hi + b.hi}; }
Interval operator+(double a, Interval b) { return {a + b.lo, a + b.hi}; }
Interval operator*(Interval a, Interval b) {
  const auto [lo, hi] = std::minmax({a.lo * b.lo, a.lo * b.hi, a.hi * b.lo, a.hi * b.hi});
  return {lo, hi};
}
Interval operator*(double a, Interval b) {
  return a >= 0 ? Interval{a * b.lo, a * b.hi} : Interval{a * b.hi, a * b.lo};
}

// Denominators of lenses are positive within their largest radius; what interval arithmetic adds below zero
// is not: then the quotient may be anything.
Interval quotient(Interval a, Interval below) {
  constexpr double kAnything = 1e30;
  if (below.lo <= 0) return {-kAnything, kAnything};
  return a * Interval{1 / below.hi, 1 / below.lo};
}

Interval squared(Interval a) {
  if (a.lo > 0) return {a.lo * a.lo, a.hi * a.hi};
  if (a.hi < 0) return {a.hi * a.hi, a.lo * a.lo};
  return {0, std::max(a.lo * a.lo, a.hi * a.hi)};
}

// θ(r)/r: 1 on the axis and falling, so an interval maps end to end.
double angle_per_radius(double r) { return r < 1e-9 ? 1.0 : std::atan(r) / r; }

// The r² at which the radial curve stops rising; beyond it the lens model folds over.
double largest_monotonic_r2(const BrownConrady& l) {
  constexpr double kFar = 36.0;  // 80° off the axis: more than this model is ever used for
  constexpr int kSteps = 720;
  for (int i = 1; i <= kSteps; ++i)
    if (!radial_rises(l, kFar * i / kSteps)) return kFar * (i - 1) / kSteps;
  return kFar;
}

double largest_monotonic_r2(const KannalaBrandt& l) {
  constexpr double kSteepest = 1.55;  // radians; the image plane's tangent explodes at π/2
  constexpr int kSteps = 310;
  double theta = 0;
  for (int i = 1; i <= kSteps; ++i) {
    const double next = kSteepest * i / kSteps, q = next * next;
    if (1 + q * (3 * l.k1 + q * (5 * l.k2 + q * (7 * l.k3 + q * 9 * l.k4))) <= 0) break;
    theta = next;
  }
  return std::tan(theta) * std::tan(theta);
}

constexpr double kPixelSlack = 1e-6;  // rounding of the projection itself

}  // namespace

OctreeView::OctreeView(const RigCamera& camera, const Matte& matte) : matte_(matte), model_(camera.model) {
  rotation_ = camera.cam_from_world.rotation.toRotationMatrix();
  translation_ = camera.cam_from_world.translation;
  pixel_rotation_ = model_.k() * rotation_;
  pixel_translation_ = model_.k() * translation_;
  largest_r2_ = std::numeric_limits<double>::infinity();
  if (const auto* brown = std::get_if<BrownConrady>(&model_.lens)) {
    pinhole_ = *brown == BrownConrady{};
    if (!pinhole_) largest_r2_ = largest_monotonic_r2(*brown);
  } else if (const auto* fisheye = std::get_if<KannalaBrandt>(&model_.lens)) {
    pinhole_ = false;
    largest_r2_ = largest_monotonic_r2(*fisheye);
  }
  const std::size_t stride = static_cast<std::size_t>(matte.width) + 1;
  integral_.assign(stride * (static_cast<std::size_t>(matte.height) + 1), 0);
  for (int y = 0; y < matte.height; ++y) {
    const std::uint8_t* row = matte.row(y);
    const std::uint32_t* above = integral_.data() + static_cast<std::size_t>(y) * stride;
    std::uint32_t* here = integral_.data() + (static_cast<std::size_t>(y) + 1) * stride;
    std::uint32_t sum = 0;
    for (int x = 0; x < matte.width; ++x) {
      sum += row[x] >= 128;
      here[x + 1] = above[x + 1] + sum;
    }
  }
}

Eigen::Vector2d OctreeView::project_normalized(double x, double y) const {
  double xd = x, yd = y;
  if (const auto* l = std::get_if<BrownConrady>(&model_.lens)) {
    const double r2 = x * x + y * y;
    const double radial = radial_factor(*l, r2);
    xd = x * radial + 2 * l->p1 * x * y + l->p2 * (r2 + 2 * x * x);
    yd = y * radial + l->p1 * (r2 + 2 * y * y) + 2 * l->p2 * x * y;
  } else if (const auto* f = std::get_if<KannalaBrandt>(&model_.lens)) {
    const double r = std::sqrt(x * x + y * y), theta = std::atan(r), q = theta * theta;
    const double scale = angle_per_radius(r) * (1 + q * (f->k1 + q * (f->k2 + q * (f->k3 + q * f->k4))));
    xd = x * scale;
    yd = y * scale;
  }
  return {model_.fx * xd + model_.skew * yd + model_.cx, model_.fy * yd + model_.cy};
}

PointVerdict OctreeView::at(const Eigen::Vector3d& world) const {
  double u, v;
  if (pinhole_) {
    const Eigen::Vector3d p = pixel_rotation_ * world + pixel_translation_;
    if (!(p.z() > 0)) return PointVerdict::Unseen;
    u = p.x() / p.z();
    v = p.y() / p.z();
  } else {
    const Eigen::Vector3d p = rotation_ * world + translation_;
    if (!(p.z() > 0)) return PointVerdict::Unseen;
    const double x = p.x() / p.z(), y = p.y() / p.z();
    if (!(x * x + y * y <= largest_r2_)) return PointVerdict::Unseen;
    const Eigen::Vector2d pixel = project_normalized(x, y);
    u = pixel.x();
    v = pixel.y();
  }
  if (!(u >= 0 && v >= 0 && u < model_.width && v < model_.height)) return PointVerdict::Unseen;
  const double x = std::clamp(u - 0.5, 0.0, matte_.width - 1.0),
               y = std::clamp(v - 0.5, 0.0, matte_.height - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int x1 = std::min(x0 + 1, matte_.width - 1), y1 = std::min(y0 + 1, matte_.height - 1);
  const double fx = x - x0, fy = y - y0;
  const std::uint8_t *top = matte_.row(y0), *bottom = matte_.row(y1);
  const double alpha =
      (1 - fy) * ((1 - fx) * top[x0] + fx * top[x1]) + fy * ((1 - fx) * bottom[x0] + fx * bottom[x1]);
  return alpha >= 127.5 ? PointVerdict::Subject : PointVerdict::Background;
}

// Where the lens puts a box of normalised points: interval arithmetic on its formula. Absent when it sees
// none of it.
std::optional<OctreeView::PixelRange> OctreeView::pixel_range(double x0, double x1, double y0,
                                                              double y1) const {
  const Interval x{x0, x1}, y{y0, y1};
  Interval r2 = squared(x) + squared(y);
  if (r2.lo > largest_r2_) return std::nullopt;
  const bool partly_unseen = r2.hi > largest_r2_;
  r2.hi = std::min(r2.hi, largest_r2_);
  Interval xd = x, yd = y;
  if (const auto* l = std::get_if<BrownConrady>(&model_.lens)) {
    Interval radial = 1 + r2 * (l->k1 + r2 * (l->k2 + l->k3 * r2));
    if (l->rational()) radial = quotient(radial, 1 + r2 * (l->k4 + r2 * (l->k5 + l->k6 * r2)));
    xd = x * radial + 2 * l->p1 * (x * y) + l->p2 * (r2 + 2 * squared(x));
    yd = y * radial + l->p1 * (r2 + 2 * squared(y)) + 2 * l->p2 * (x * y);
  } else if (const auto* f = std::get_if<KannalaBrandt>(&model_.lens)) {
    const Interval r{std::sqrt(r2.lo), std::sqrt(r2.hi)};
    const Interval q = squared({std::atan(r.lo), std::atan(r.hi)});
    const Interval scale = Interval{angle_per_radius(r.hi), angle_per_radius(r.lo)} *
                           (1 + q * (f->k1 + q * (f->k2 + q * (f->k3 + f->k4 * q))));
    xd = x * scale;
    yd = y * scale;
  }
  const Interval u = model_.cx + (model_.fx * xd + model_.skew * yd), v = model_.cy + model_.fy * yd;
  return PixelRange{u.lo, u.hi, v.lo, v.hi, partly_unseen};
}

// Subject pixels in columns x0..x1 and rows y0..y1, both ends included.
std::uint32_t OctreeView::subjects(int x0, int y0, int x1, int y1) const {
  const std::size_t stride = static_cast<std::size_t>(matte_.width) + 1;
  auto sum = [&](int x, int y) {
    return integral_[static_cast<std::size_t>(y) * stride + static_cast<std::size_t>(x)];
  };
  return sum(x1 + 1, y1 + 1) - sum(x0, y1 + 1) - sum(x1 + 1, y0) + sum(x0, y0);
}

BoxVerdict OctreeView::over(const Eigen::AlignedBox3d& world) const {
  const Eigen::Matrix3d& m = pinhole_ ? pixel_rotation_ : rotation_;
  const Eigen::Vector3d origin = m * world.min() + (pinhole_ ? pixel_translation_ : translation_);
  const Eigen::Vector3d size = world.sizes();
  const Eigen::Vector3d dx = m.col(0) * size.x(), dy = m.col(1) * size.y(), dz = m.col(2) * size.z();
  const double infinity = std::numeric_limits<double>::infinity();
  double x0 = infinity, x1 = -infinity, y0 = infinity, y1 = -infinity, z0 = infinity, z1 = -infinity;
  for (int corner = 0; corner < 8; ++corner) {
    Eigen::Vector3d p = origin;
    if (corner & 1) p += dx;
    if (corner & 2) p += dy;
    if (corner & 4) p += dz;
    const double w = 1 / p.z(), x = p.x() * w, y = p.y() * w;
    z0 = std::min(z0, p.z());
    z1 = std::max(z1, p.z());
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
  }
  if (z1 <= 0) return BoxVerdict::Unseen;
  if (!(z0 > 1e-12 * z1)) return BoxVerdict::Mixed;  // reaches behind the camera: its projection is unbounded
  PixelRange r{x0, x1, y0, y1, false};
  if (!pinhole_) {
    const std::optional<PixelRange> through_lens = pixel_range(x0, x1, y0, y1);
    if (!through_lens) return BoxVerdict::Unseen;
    r = *through_lens;
  }
  r.u0 -= kPixelSlack;
  r.v0 -= kPixelSlack;
  r.u1 += kPixelSlack;
  r.v1 += kPixelSlack;
  const double width = model_.width, height = model_.height;
  if (r.u1 < 0 || r.v1 < 0 || r.u0 >= width || r.v0 >= height) return BoxVerdict::Unseen;
  const bool partly_unseen = r.partly_unseen || r.u0 < 0 || r.v0 < 0 || r.u1 >= width || r.v1 >= height;
  // Every pixel that bilinear interpolation may touch.
  auto column = [&](double u) { return static_cast<int>(std::clamp(std::floor(u - 0.5), 0.0, width - 1)); };
  auto line = [&](double v) { return static_cast<int>(std::clamp(std::floor(v - 0.5), 0.0, height - 1)); };
  const int px0 = column(r.u0), px1 = column(r.u1 + 1), py0 = line(r.v0), py1 = line(r.v1 + 1);
  const std::uint32_t count = subjects(px0, py0, px1, py1);
  if (count == 0) return partly_unseen ? BoxVerdict::Mixed : BoxVerdict::Background;
  const std::uint32_t area =
      static_cast<std::uint32_t>(px1 - px0 + 1) * static_cast<std::uint32_t>(py1 - py0 + 1);
  if (count == area) return partly_unseen ? BoxVerdict::NotBackground : BoxVerdict::Subject;
  return BoxVerdict::Mixed;
}

}  // namespace floatstage::recon
