// Method:  known lengths as the cameras alone measure them, points from their rays
// Paper:   R. I. Hartley, P. Sturm, "Triangulation", 1997: the point nearest to rays, then least squares in
//          pixels
// Differs: without the board's shape, so that a wrong print shows
// ADR:     none; docs/algorithms/calibration.md

#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <Eigen/Dense>

#include "calib/solver/quality.h"

namespace floatstage::calib::solver {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Sight {
  const SceneCamera* camera;
  Rigid3 cam_from_world;  ///< as it would be had the board not moved since its frame's time
  Vector2d pixel;
  double sigma;
};

// Where the rays of one point meet: first the point nearest to them, then least squares in pixels. Absent
// when they are nearly parallel.
std::optional<Vector3d> meet(const std::vector<Sight>& sights) {
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const Sight& s : sights) {
    const SceneCamera& c = *s.camera;
    const std::optional<Vector3d> ray = unproject(unpack(c.intrinsics, c.lens, c.width, c.height), s.pixel);
    if (!ray) continue;
    const Vector3d d = (s.cam_from_world.rotation.conjugate() * *ray).normalized();
    const Matrix3d across = Matrix3d::Identity() - d * d.transpose();
    normal += across;
    right += across * s.cam_from_world.center();
  }
  constexpr double kLeastParallax = 0.03;  // about 20° between two rays: below it, depth is mostly noise
  if (!(Eigen::SelfAdjointEigenSolver<Matrix3d>(normal).eigenvalues()[0] > kLeastParallax))
    return std::nullopt;
  Vector3d x = normal.ldlt().solve(right);
  for (int i = 0; i < 4; ++i) {
    normal.setZero();
    right.setZero();
    Projected projected;
    for (const Sight& s : sights) {
      const Rigid3& pose = s.cam_from_world;
      if (!project<Slopes::ByPoint>(s.camera->intrinsics, s.camera->lens, pose * x, projected))
        return std::nullopt;
      const double weight = 1 / (s.sigma * s.camera->noise);
      const Eigen::Matrix<double, 2, 3> j = weight * projected.by_point * pose.rotation.toRotationMatrix();
      normal += j.transpose() * j;
      right -= j.transpose() * (weight * (projected.pixel - s.pixel));
    }
    x += normal.ldlt().solve(right);
  }
  if (!x.allFinite()) return std::nullopt;
  return x;
}

// Which distances of a target are known.
std::vector<TargetLength> known_lengths(const Target& t) {
  if (t.kind != TargetKind::Board) return t.lengths;
  std::vector<TargetLength> out;
  const auto add = [&](int a, int b) {
    const int ia = point_index(t, a), ib = point_index(t, b);
    if (ia >= 0 && ib >= 0)
      out.push_back({a, b, (t.points[at(ia)].position - t.points[at(ib)].position).norm(), 1e-4});
  };
  if (t.grid) {
    for (int r = 0; r < t.grid->rows; ++r)
      for (int c = 0; c < t.grid->columns; ++c) {
        const int id = r * t.grid->columns + c;
        if (c + 1 < t.grid->columns) add(id, id + 1);
        if (r + 1 < t.grid->rows) add(id, id + t.grid->columns);
      }
  } else {
    for (std::size_t i = 0; i + 1 < t.points.size(); ++i) add(t.points[i].id, t.points[i + 1].id);
  }
  return out;
}

struct Sums {
  int count = 0;
  double square = 0, bias = 0, measured = 0, known = 0;
  std::vector<double> ratios;  // one a frame
};

}  // namespace

std::vector<LengthQuality> measure_lengths(const Scene& scene) {
  // target → frame → point id → its rays
  std::map<int, std::map<std::pair<int, int>, std::map<int, std::vector<Sight>>>> seen;
  for (const SceneView& v : scene.views) {
    if (!usable(scene, v)) continue;
    const SceneMarkers* markers = v.board >= 0 ? nullptr : &scene.markers[at(v.markers)];
    const SceneCamera& camera = scene.cameras[at(v.camera)];
    Rigid3 pose = camera.cam_from_world;
    if (!markers) pose = camera_from_target(scene, v) * scene.boards[at(v.board)].world_from_target.inverse();
    const int target = markers ? markers->target : scene.boards[at(v.board)].target;
    for (const ScenePoint& p : v.points) {
      if (!p.kept) continue;
      const int index = markers ? markers->indices[at(p.index)] : p.index;
      seen[target][{markers ? 1 : 0, markers ? v.markers : v.board}]
          [scene.targets[at(target)].points[at(index)].id]
              .push_back({&camera, pose, p.pixel, p.sigma});
    }
  }
  std::vector<LengthQuality> out;
  for (const auto& [target, frames] : seen) {
    const std::vector<TargetLength> lengths = known_lengths(scene.targets[at(target)]);
    Sums s;
    for (const auto& [frame, points] : frames) {
      std::map<int, Vector3d> places;
      for (const auto& [id, sights] : points)
        if (sights.size() >= 2)
          if (const std::optional<Vector3d> x = meet(sights)) places[id] = *x;
      double measured = 0, known = 0;
      for (const TargetLength& l : lengths) {
        const auto a = places.find(l.a), b = places.find(l.b);
        if (a == places.end() || b == places.end()) continue;
        const double length = (a->second - b->second).norm(), error = length - l.metres;
        ++s.count;
        s.square += error * error;
        s.bias += error;
        measured += length;
        known += l.metres;
      }
      if (known <= 0) continue;
      s.measured += measured;
      s.known += known;
      s.ratios.push_back(measured / known);
    }
    if (s.count == 0) continue;
    LengthQuality q;
    q.target = scene.targets[at(target)].name;
    q.count = s.count;
    q.rms_mm = 1e3 * std::sqrt(s.square / s.count);
    q.bias_mm = 1e3 * s.bias / s.count;
    q.ratio = s.measured / s.known;
    double spread = 0;
    for (const double r : s.ratios) spread += (r - q.ratio) * (r - q.ratio);
    const auto n = static_cast<double>(s.ratios.size());
    q.ratio_sigma = n > 1 ? std::sqrt(spread / (n * (n - 1))) : std::abs(q.ratio - 1);
    out.push_back(q);
  }
  return out;
}

LengthQuality merged(const std::vector<LengthQuality>& lengths) {
  LengthQuality all;
  double square = 0, bias = 0, ratio = 0, variance = 0;
  for (const LengthQuality& q : lengths) {
    all.count += q.count;
    square += q.count * q.rms_mm * q.rms_mm;
    bias += q.count * q.bias_mm;
    ratio += q.count * q.ratio;
    variance += q.count * q.ratio_sigma * q.ratio_sigma;
  }
  if (all.count == 0) return all;
  all.rms_mm = std::sqrt(square / all.count);
  all.bias_mm = bias / all.count;
  all.ratio = ratio / all.count;
  all.ratio_sigma = std::sqrt(variance / all.count);
  return all;
}

}  // namespace floatstage::calib::solver
