#include "render/camera_block.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace floatstage::render {
namespace {

constexpr double kUnlimited = 1e20;
constexpr double kWidestTangent = 8;  // beyond 83 degrees from the axis a pinhole depth map has no use

template <class... F>
struct Overloaded : F... {
  using F::operator()...;
};

/// Bounds of the picture's border in pinhole coordinates; absent parts of the border (a lens that cannot be
/// inverted there) are left out, so a fisheye's bounds are capped.
Eigen::AlignedBox2d picture_bounds(const CameraModel& m) {
  constexpr int kSteps = 32;
  Eigen::AlignedBox2d bounds;
  for (int i = 0; i <= kSteps; ++i) {
    const double s = static_cast<double>(i) / kSteps;
    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(s * m.width, 0), Eigen::Vector2d(s * m.width, m.height),
          Eigen::Vector2d(0, s * m.height), Eigen::Vector2d(m.width, s * m.height)}) {
      if (const auto ray = unproject(m, pixel))
        bounds.extend(Eigen::Vector2d(ray->head<2>()));
      else
        bounds.extend(Eigen::Vector2d((pixel.array() - Eigen::Array2d(m.cx, m.cy)).sign() * kWidestTangent));
    }
  }
  const Eigen::Vector2d widest(kWidestTangent, kWidestTangent);
  return bounds.intersection(Eigen::AlignedBox2d(-widest, widest));
}

}  // namespace

double largest_radius2(const Lens& lens) {
  const auto* brown = std::get_if<BrownConrady>(&lens);
  if (brown == nullptr) return kUnlimited;
  // The radial curve must rise: scan it, fine steps where pictures lie.
  constexpr double kStep = 1.0 / 256, kEnd = kWidestTangent * kWidestTangent;
  for (double q = kStep; q < kEnd; q += kStep)
    if (!radial_rises(*brown, q)) return q - kStep;
  return kUnlimited;
}

Eigen::AlignedBox2d pinhole_bounds(const RigCamera& camera, const Eigen::AlignedBox3f& box, double guard_px) {
  const Eigen::Vector2d guard(guard_px / camera.model.fx, guard_px / camera.model.fy);
  Eigen::AlignedBox2d picture = picture_bounds(camera.model);
  picture.min() -= guard;
  picture.max() += guard;
  Eigen::AlignedBox2d subject;
  for (int corner = 0; corner < 8; ++corner) {
    const auto type = static_cast<Eigen::AlignedBox3f::CornerType>(corner);
    const Eigen::Vector3d p = camera.cam_from_world * Eigen::Vector3d(box.corner(type).cast<double>());
    if (p.z() <= 1e-6) return picture;  // the camera stands in the box: the box may cover all of its picture
    subject.extend(Eigen::Vector2d(p.head<2>() / p.z()));
  }
  subject.min() -= guard;
  subject.max() += guard;
  const Eigen::AlignedBox2d both = picture.intersection(subject);
  return both.isEmpty() ? Eigen::AlignedBox2d(-guard, guard) : both;
}

CameraBlock camera_block(const RigCamera& camera, int layer) {
  CameraBlock block{};
  const Eigen::Matrix4f transform = camera.cam_from_world.matrix().cast<float>();
  std::copy(transform.data(), transform.data() + 16, block.cam_from_world.begin());
  const Eigen::Vector3f center = camera.cam_from_world.center().cast<float>();
  block.center = {center.x(), center.y(), center.z(), 1};
  const CameraModel& m = camera.model;
  auto f = [](double v) { return static_cast<float>(v); };
  block.intrinsics = {f(m.fx), f(m.fy), f(m.cx), f(m.cy)};
  float k3 = 0;
  block.lens_below = {};
  std::visit(Overloaded{[](std::monostate) {},
                        [&](const BrownConrady& l) {
                          block.lens = {f(l.k1), f(l.k2), f(l.p1), f(l.p2)};
                          k3 = f(l.k3);
                          block.lens_below = {f(l.k4), f(l.k5), f(l.k6), 0};
                        },
                        [&](const KannalaBrandt& l) {
                          block.lens = {f(l.k1), f(l.k2), f(l.k3), f(l.k4)};
                        }},
             m.lens);
  block.lens_more = {k3, f(m.skew), f(largest_radius2(m.lens)), f(static_cast<double>(m.lens.index()))};
  block.image = {f(m.width), f(m.height), f(layer), 0};
  block.tile = {0, 0, f(m.width), f(m.height)};
  return block;
}

}  // namespace floatstage::render
