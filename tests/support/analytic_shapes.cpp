#include "tests/support/analytic_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/text.h"

namespace floatstage::shapes {
namespace {

using Eigen::Vector3d;

RigCamera camera_at(const Vector3d& eye, const RigShape& shape, int index) {
  RigCamera c;
  c.serial = text("c", index);
  c.model = {.width = shape.width,
             .height = shape.height,
             .fx = shape.focal,
             .fy = shape.focal,
             .cx = shape.width / 2.0,
             .cy = shape.height / 2.0,
             .skew = 0,
             .lens = shape.lens};
  const Vector3d along = (shape.target - eye).normalized();
  c.cam_from_world =
      look_at(eye, shape.target, std::abs(along.z()) > 0.99 ? Vector3d::UnitY() : Vector3d::UnitZ());
  return c;
}

}  // namespace

Shape sphere(const Vector3d& center, double radius) {
  return [=](const Vector3d& origin, const Vector3d& direction) {
    const Vector3d to = center - origin, d = direction.normalized();
    const double along = to.dot(d);
    return along > 0 && (to - along * d).norm() <= radius;
  };
}

Shape box(const Vector3d& center, const Vector3d& sizes) {
  return [=](const Vector3d& origin, const Vector3d& direction) {
    double enter = 0, leave = 1e30;
    for (int axis = 0; axis < 3; ++axis) {
      const double lo = center[axis] - sizes[axis] / 2 - origin[axis],
                   hi = center[axis] + sizes[axis] / 2 - origin[axis];
      if (direction[axis] == 0) {
        if (lo > 0 || hi < 0) return false;
        continue;
      }
      const auto [first, second] = std::minmax({lo / direction[axis], hi / direction[axis]});
      enter = std::max(enter, first);
      leave = std::min(leave, second);
    }
    return enter <= leave;
  };
}

Shape torus(const Vector3d& center, double ring, double tube) {
  return [=](const Vector3d& origin, const Vector3d& direction) {
    const Vector3d d = direction.normalized();
    const double end = (origin - center).norm() + ring + tube;
    for (double t = 0; t < end;) {  // sphere tracing
      const Vector3d p = origin + t * d - center;
      const double distance = std::hypot(std::hypot(p.x(), p.y()) - ring, p.z()) - tube;
      if (distance < 1e-6) return true;
      t += std::max(distance, 1e-5);
    }
    return false;
  };
}

Shape both(Shape a, Shape b) {
  return [a = std::move(a), b = std::move(b)](const Vector3d& o, const Vector3d& d) {
    return a(o, d) || b(o, d);
  };
}

Matte render_matte(const RigCamera& camera, const Shape& shape) {
  const Rigid3 world_from_cam = camera.cam_from_world.inverse();
  auto hit = [&](double u, double v) {
    const auto ray = unproject(camera.model, {u, v});
    return ray && shape(world_from_cam.translation, world_from_cam.rotation * *ray);
  };
  const int w = camera.model.width, h = camera.model.height;
  // Corners first: only pixels whose surroundings disagree are sampled finely.
  Image corners(w + 1, h + 1, 1), alpha(w, h, 1);
  for (int y = 0; y <= h; ++y)
    for (int x = 0; x <= w; ++x) *corners.at(x, y) = hit(x, y);
  constexpr int kFine = 8;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      int around = 0, samples = 0;
      for (int dy = -1; dy <= 2; ++dy)
        for (int dx = -1; dx <= 2; ++dx, ++samples)
          around += *corners.at(std::clamp(x + dx, 0, w), std::clamp(y + dy, 0, h));
      if (around == 0 || around == samples) {
        *alpha.at(x, y) = around ? 255 : 0;
        continue;
      }
      int covered = 0;
      for (int sy = 0; sy < kFine; ++sy)
        for (int sx = 0; sx < kFine; ++sx) covered += hit(x + (sx + 0.5) / kFine, y + (sy + 0.5) / kFine);
      *alpha.at(x, y) = static_cast<std::uint8_t>(std::lround(255.0 * covered / (kFine * kFine)));
    }
  }
  return make_matte({}, alpha);
}

std::vector<Matte> render_mattes(const Rig& rig, const Shape& shape) {
  std::vector<Matte> mattes;
  for (const RigCamera& camera : rig.cameras) mattes.push_back(render_matte(camera, shape));
  return mattes;
}

Matte uniform_matte(const RigCamera& camera, std::uint8_t alpha) {
  return make_matte({}, Image(camera.model.width, camera.model.height, 1, alpha));
}

Rig ring_rig(const RigShape& shape, double height) {
  Rig rig;
  for (int i = 0; i < shape.cameras; ++i) {
    const double angle = 2 * std::numbers::pi * i / shape.cameras;
    const Vector3d offset(std::cos(angle), std::sin(angle), height / shape.distance);
    rig.cameras.push_back(camera_at(shape.target + shape.distance * offset, shape, i));
  }
  return rig;
}

Rig sphere_rig(const RigShape& shape) {
  Rig rig;
  for (int i = 0; i < shape.cameras; ++i) {
    const double z = 1 - (2 * i + 1.0) / shape.cameras, r = std::sqrt(1 - z * z);
    const double angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    const Vector3d offset(r * std::cos(angle), r * std::sin(angle), z);
    rig.cameras.push_back(camera_at(shape.target + shape.distance * offset, shape, i));
  }
  return rig;
}

}  // namespace floatstage::shapes
