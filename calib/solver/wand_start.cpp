// Method:  two cameras' relative pose from wand markers, its scale from the wand's lengths
// Paper:   H. C. Longuet-Higgins, "A computer algorithm for reconstructing a scene from two projections",
//          1981
// Differs: all points at once, on undistorted rays, weighted again by Sampson's distance
// ADR:     none; docs/algorithms/calibration.md

#include "calib/solver/wand_start.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include "core/statistics.h"

namespace floatstage::calib::solver {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Marker = std::pair<int, int>;  // SceneMarkers, index in it

std::map<Marker, Vector2d> pixels_of(const Scene& scene, int camera) {
  std::map<Marker, Vector2d> out;
  for (const SceneView& v : scene.views) {
    if (v.camera != camera || v.markers < 0) continue;
    if (scene.targets[static_cast<std::size_t>(scene.markers[static_cast<std::size_t>(v.markers)].target)]
            .kind != TargetKind::Wand)
      continue;
    for (const ScenePoint& p : v.points) out[{v.markers, p.index}] = p.pixel;
  }
  return out;
}

struct Pair {
  Marker marker;
  Vector3d a, b;  // rays, z = 1
};

std::vector<Pair> pairs_of(const Scene& scene, int a, int b) {
  const SceneCamera &ca = scene.cameras[static_cast<std::size_t>(a)],
                    &cb = scene.cameras[static_cast<std::size_t>(b)];
  const CameraModel ma = unpack(ca.intrinsics, ca.lens, ca.width, ca.height),
                    mb = unpack(cb.intrinsics, cb.lens, cb.width, cb.height);
  const std::map<Marker, Vector2d> in_b = pixels_of(scene, b);
  std::vector<Pair> out;
  for (const auto& [marker, pixel] : pixels_of(scene, a)) {
    const auto other = in_b.find(marker);
    if (other == in_b.end()) continue;
    const std::optional<Vector3d> ra = unproject(ma, pixel), rb = unproject(mb, other->second);
    if (ra && rb) out.push_back({marker, *ra, *rb});
  }
  return out;
}

// b' E a = 0.
Matrix3d essential(const std::vector<Pair>& pairs) {
  std::vector<double> weights(pairs.size(), 1), errors(pairs.size());
  Matrix3d e;
  for (int round = 0; round < 15; ++round) {
    Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      Eigen::Matrix<double, 9, 1> row;
      row << pairs[i].b.x() * pairs[i].a, pairs[i].b.y() * pairs[i].a, pairs[i].b.z() * pairs[i].a;
      normal += weights[i] * row * row.transpose();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> eigen(normal);
    const Eigen::Matrix<double, 9, 1> v = eigen.eigenvectors().col(0);
    e << v.head<3>().transpose(), v.segment<3>(3).transpose(), v.tail<3>().transpose();
    const Eigen::JacobiSVD<Matrix3d> svd(e, Eigen::ComputeFullU | Eigen::ComputeFullV);
    e = svd.matrixU() * Vector3d(1, 1, 0).asDiagonal() * svd.matrixV().transpose();
    for (std::size_t i = 0; i < pairs.size(); ++i) {  // Sampson's distance
      const Vector3d ea = e * pairs[i].a, eb = e.transpose() * pairs[i].b;
      errors[i] = std::abs(pairs[i].b.dot(ea)) /
                  std::max(1e-12, std::sqrt(ea.head<2>().squaredNorm() + eb.head<2>().squaredNorm()));
    }
    const double scale = std::max(1e-9, 3 * median(errors));
    for (std::size_t i = 0; i < pairs.size(); ++i)
      weights[i] = 1 / std::pow(1 + std::pow(errors[i] / scale, 2), 2);
  }
  return e;
}

// The point nearest to both rays, in a's frame, and whether it lies in front of both cameras.
std::optional<Vector3d> intersect(const Pair& p, const Rigid3& b_from_a) {
  const Vector3d from = b_from_a.center(), da = p.a.normalized(),
                 db = (b_from_a.rotation.conjugate() * p.b).normalized();
  const Matrix3d across_a = Matrix3d::Identity() - da * da.transpose(),
                 across_b = Matrix3d::Identity() - db * db.transpose();
  const Vector3d x = (across_a + across_b).ldlt().solve(across_b * from);
  if (!x.allFinite() || x.z() <= 0 || (b_from_a * x).z() <= 0) return std::nullopt;
  return x;
}

}  // namespace

WandOverlap wand_overlap(const Scene& scene, int a, int b) {
  const std::map<Marker, Vector2d> in_a = pixels_of(scene, a), in_b = pixels_of(scene, b);
  WandOverlap overlap;
  int last = -1;
  for (const auto& [marker, pixel] : in_a) {
    if (!in_b.contains(marker)) continue;
    ++overlap.points;
    overlap.frames += marker.first != last;
    last = marker.first;
  }
  return overlap;
}

std::optional<Rigid3> pose_from_wand(const Scene& scene, int a, int b) {
  const std::vector<Pair> pairs = pairs_of(scene, a, b);
  if (static_cast<int>(pairs.size()) < kFewestWandPoints) return std::nullopt;
  const Matrix3d e = essential(pairs);
  const Eigen::JacobiSVD<Matrix3d> svd(e, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d w;
  w << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  Rigid3 best;
  std::size_t most = 0;
  for (int k = 0; k < 4; ++k) {
    Matrix3d r = svd.matrixU() * (k < 2 ? w : Matrix3d(w.transpose())) * svd.matrixV().transpose();
    if (r.determinant() < 0) r = -r;
    const Rigid3 candidate{Eigen::Quaterniond(r).normalized(), (k % 2 ? 1.0 : -1.0) * svd.matrixU().col(2)};
    const auto front = static_cast<std::size_t>(std::count_if(
        pairs.begin(), pairs.end(), [&](const Pair& p) { return intersect(p, candidate).has_value(); }));
    if (front > most) {
      most = front;
      best = candidate;
    }
  }
  std::map<Marker, Vector3d> places;
  for (const Pair& p : pairs)
    if (const std::optional<Vector3d> x = intersect(p, best)) places[p.marker] = *x;
  std::vector<double> scales;
  for (std::size_t m = 0; m < scene.markers.size(); ++m) {
    const SceneMarkers& markers = scene.markers[m];
    const Target& target = scene.targets[static_cast<std::size_t>(markers.target)];
    for (const TargetLength& l : target.lengths) {
      const auto place = [&](int id) {
        const auto found = std::find(markers.indices.begin(), markers.indices.end(), point_index(target, id));
        return places.find({static_cast<int>(m), static_cast<int>(found - markers.indices.begin())});
      };
      const auto from = place(l.a), to = place(l.b);
      if (from != places.end() && to != places.end())
        scales.push_back(l.metres / (from->second - to->second).norm());
    }
  }
  if (scales.empty()) return std::nullopt;
  best.translation *= median(std::move(scales));
  return best.inverse();
}

}  // namespace floatstage::calib::solver
