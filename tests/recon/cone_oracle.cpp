#include "tests/recon/cone_oracle.h"

#include <cmath>
#include <vector>

#include <Eigen/Geometry>

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

/// A convex body as its faces, each a ring of points, counter-clockwise from outside.
struct Body {
  std::vector<std::vector<Vector3d>> faces;

  double volume() const {
    if (faces.empty()) return 0;
    const Vector3d origin = faces[0][0];
    double six = 0;
    for (const auto& face : faces) {
      for (std::size_t k = 1; k + 1 < face.size(); ++k) {
        six += (face[0] - origin).dot((face[k] - origin).cross(face[k + 1] - origin));
      }
    }
    return six / 6;
  }
};

Body box(double half) {
  Body body;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      const Vector3d n = side * Vector3d::Unit(axis), u = Vector3d::Unit((axis + 1) % 3), v = n.cross(u);
      body.faces.push_back({half * (n - u - v), half * (n + u - v), half * (n + u + v), half * (n - u + v)});
    }
  }
  return body;
}

/// Keeps the side where normal . (x - point) >= 0.
Body clipped(const Body& body, const Vector3d& normal, const Vector3d& point) {
  Body out;
  std::vector<std::pair<Vector3d, Vector3d>> cut;  // edges of the new face
  for (const auto& face : body.faces) {
    std::vector<Vector3d> kept;
    Vector3d leaves, enters;
    int crossings = 0;
    for (std::size_t k = 0; k < face.size(); ++k) {
      const Vector3d &p = face[k], &q = face[(k + 1) % face.size()];
      const double dp = normal.dot(p - point), dq = normal.dot(q - point);
      if (dp >= 0) kept.push_back(p);
      if ((dp >= 0) == (dq >= 0)) continue;
      const Vector3d x = p + (q - p) * (dp / (dp - dq));
      kept.push_back(x);
      (dp >= 0 ? leaves : enters) = x;
      ++crossings;
    }
    if (kept.size() >= 3) out.faces.push_back(kept);
    if (crossings == 2) cut.push_back({enters, leaves});
  }
  if (cut.size() >= 3) {
    // The new face, as a fan around the middle of its edges: it need not be sorted for its volume.
    Vector3d middle = Vector3d::Zero();
    for (const auto& [a, b] : cut) middle += (a + b) / (2.0 * static_cast<double>(cut.size()));
    for (const auto& [a, b] : cut) out.faces.push_back({middle, a, b});
  }
  return out.faces.size() >= 4 ? out : Body{};
}

/// Vol of the intersection of the given views' silhouettes with `body`, views taken one after the other.
double intersection(const Body& body, std::span<const ConeView* const> views) {
  if (body.faces.empty()) return 0;
  if (views.empty()) return body.volume();
  const ConeView& view = *views.front();
  const Vector3d hub = view.rays[0];
  double sum = 0;
  for (std::size_t e = 0; e < view.rays.size(); ++e) {
    Vector3d p = view.rays[e], q = view.rays[static_cast<std::size_t>(view.next[e])];
    const double turn = hub.dot(p.cross(q));
    if (std::abs(turn) < 1e-15) continue;
    if (turn < 0) std::swap(p, q);
    Body part = clipped(body, p.cross(q), view.center);
    part = clipped(part, hub.cross(p), view.center);
    part = clipped(part, q.cross(hub), view.center);
    sum += (turn > 0 ? 1 : -1) * intersection(part, views.subspan(1));
  }
  return sum;
}

double choose(int n, int k) {
  double out = 1;
  for (int i = 1; i <= k; ++i) out = out * (n - k + i) / i;
  return out;
}

}  // namespace

double volume_by_clipping(std::span<const ConeView> views, int votes) {
  const int count = static_cast<int>(views.size());
  double volume = 0;
  for (unsigned set = 0; set < (1U << count); ++set) {
    const int size = __builtin_popcount(set);
    if (size < votes) continue;
    std::vector<const ConeView*> chosen;
    for (int v = 0; v < count; ++v) {
      if (set >> v & 1U) chosen.push_back(&views[v]);
    }
    // "At least m of n" by inclusion and exclusion.
    const double weight = ((size - votes) % 2 ? -1 : 1) * choose(size - 1, votes - 1);
    volume += weight * intersection(box(100), chosen);
  }
  return volume;
}

}  // namespace floatstage::recon
