#include "tests/recon/cone_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

namespace floatstage::recon {
namespace cones {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;

struct Axes {
  Vector3d right, up, forward;
};

Axes axes_at(const Vector3d& center) {
  const Vector3d forward = -center.normalized();
  const Vector3d hint = std::abs(forward.z()) < 0.9 ? Vector3d::UnitZ() : Vector3d::UnitX();
  const Vector3d right = forward.cross(hint).normalized();
  return {right, right.cross(forward), forward};
}

// Interior lies on the side of ray(k) x ray(k+1): for the viewer, that is clockwise.
void add_seen_counter_clockwise(ConeView& view, std::vector<Vector3d> rays) {
  std::reverse(rays.begin(), rays.end());
  view.add_loop(rays);
}

}  // namespace

ConeView at(const Vector3d& center) {
  ConeView view;
  view.center = center;
  return view;
}

void add_polygon(ConeView& view, const std::vector<Vector2d>& polygon) {
  const Axes axes = axes_at(view.center);
  std::vector<Vector3d> rays;
  for (const Vector2d& p : polygon) {
    rays.push_back((p.x() * axes.right + p.y() * axes.up - view.center) / view.center.norm());
  }
  add_seen_counter_clockwise(view, rays);
}

ConeView of_convex(const Vector3d& center, const std::vector<Vector3d>& points) {
  const Axes axes = axes_at(center);
  std::vector<std::pair<Vector2d, Vector3d>> seen;
  for (const Vector3d& point : points) {
    const Vector3d d = point - center;
    const double depth = d.dot(axes.forward);
    seen.push_back({{d.dot(axes.right) / depth, d.dot(axes.up) / depth}, d / depth});
  }
  std::sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) {
    return a.first.x() != b.first.x() ? a.first.x() < b.first.x() : a.first.y() < b.first.y();
  });
  // Andrew's monotone chain; points on an edge (within rounding) are left out.
  const auto turn = [](const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  std::vector<std::size_t> chain;
  const auto add = [&](std::size_t k, std::size_t least) {
    while (chain.size() >= least + 2 &&
           turn(seen[chain[chain.size() - 2]].first, seen[chain.back()].first, seen[k].first) <= 1e-12) {
      chain.pop_back();
    }
    chain.push_back(k);
  };
  for (std::size_t k = 0; k < seen.size(); ++k) add(k, 0);
  const std::size_t lower = chain.size() - 1;
  for (std::size_t k = seen.size() - 1; k-- > 0;) add(k, lower);
  chain.pop_back();
  ConeView view = at(center);
  std::vector<Vector3d> rays;
  for (const std::size_t k : chain) rays.push_back(seen[k].second);
  add_seen_counter_clockwise(view, rays);
  return view;
}

ConeView of_sphere(const Vector3d& center, double radius, int sides, double turn) {
  const Axes axes = axes_at(center);
  const double tangent = radius / std::sqrt(center.squaredNorm() - radius * radius);
  ConeView view = at(center);
  std::vector<Vector3d> rays;
  for (int k = 0; k < sides; ++k) {
    const double a = turn + 2 * kPi * k / sides;
    rays.push_back(axes.forward + tangent * (std::cos(a) * axes.right + std::sin(a) * axes.up));
  }
  add_seen_counter_clockwise(view, rays);
  return view;
}

std::vector<Vector3d> cube_corners(double half) {
  std::vector<Vector3d> corners;
  for (int c = 0; c < 8; ++c)
    corners.push_back(half * Vector3d(c & 1 ? 1 : -1, c & 2 ? 1 : -1, c & 4 ? 1 : -1));
  return corners;
}

std::vector<Vector3d> octahedron_corners(double radius) {
  std::vector<Vector3d> corners;
  for (int axis = 0; axis < 3; ++axis) {
    corners.push_back(radius * Vector3d::Unit(axis));
    corners.push_back(-radius * Vector3d::Unit(axis));
  }
  return corners;
}

std::vector<Vector3d> ring(int count, double distance, double z, double phase) {
  std::vector<Vector3d> centers;
  for (int k = 0; k < count; ++k) {
    const double a = phase + 2 * kPi * k / count;
    centers.push_back({distance * std::cos(a), distance * std::sin(a), z});
  }
  return centers;
}

std::vector<Vector3d> around(int count, double distance) {
  std::vector<Vector3d> centers;
  for (int k = 0; k < count; ++k) {
    const double z = 1 - (2 * k + 1.0) / count, r = std::sqrt(1 - z * z), a = k * kPi * (3 - std::sqrt(5.0));
    centers.push_back(distance * Vector3d(r * std::cos(a), r * std::sin(a), z));
  }
  return centers;
}

std::vector<ConeView> random_stars(Random& random, const std::vector<Vector3d>& centers, int spikes,
                                   bool holes) {
  std::vector<ConeView> views;
  for (const Vector3d& center : centers) {
    ConeView view = at(center);
    std::vector<Vector2d> outline, hole;
    for (int k = 0; k < 2 * spikes; ++k) {
      const double a = kPi * (k + random.uniform(-0.3, 0.3)) / spikes;
      const double r = k % 2 ? random.uniform(0.35, 0.6) : random.uniform(0.7, 1.0);
      outline.push_back(r * Vector2d(std::cos(a), std::sin(a)));
    }
    add_polygon(view, outline);
    if (holes) {
      for (int k = 0; k < 5; ++k) {
        const double a = -2 * kPi * (k + random.uniform(-0.2, 0.2)) / 5, r = random.uniform(0.1, 0.25);
        hole.push_back(r * Vector2d(std::cos(a), std::sin(a)));
      }
      add_polygon(view, hole);
    }
    views.push_back(view);
  }
  return views;
}

}  // namespace cones

Mesh to_mesh(const HullPolygons& polygons) {
  Mesh mesh;
  for (const Eigen::Vector3d& p : polygons.positions) mesh.positions.push_back(p.cast<float>());
  mesh.triangles = polygons.triangles;
  return mesh;
}

}  // namespace floatstage::recon
