#include "recon/mesh/reprojection_bound.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace floatstage::recon {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0 ? std::clamp((p - a).dot(along) / length2, 0.0, 1.0) : 0;
  return (p - a - t * along).norm();
}

}  // namespace

ReprojectionBound::ReprojectionBound(const Rig& rig, std::span<const Matte> mattes,
                                     std::span<const Vector3d> positions, double limit)
    : merged_(positions.size()), limit_(limit) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c)
    if (!mattes[c].empty()) eyes_.push_back({&rig.cameras[c], c});
  seen_.reserve(positions.size() * eyes_.size());
  const double nowhere = std::numeric_limits<double>::quiet_NaN();
  for (const Vector3d& p : positions) {
    for (const Eye& eye : eyes_) {
      const auto pixel = project(eye.camera->model, eye.camera->cam_from_world * p);
      seen_.push_back(pixel ? *pixel : Vector2d(nowhere, nowhere));
    }
  }
}

// Calls visit(camera, px moved) for all that v stands for, until it says false. A point that a camera saw and
// does not see any more has moved infinitely far.
template <class Visit>
bool ReprojectionBound::visit(std::size_t v, const Vector3d& position, Visit visit) const {
  for (std::size_t e = 0; e < eyes_.size(); ++e) {
    const RigCamera& camera = *eyes_[e].camera;
    const auto pixel = project(camera.model, camera.cam_from_world * position);
    const auto each = [&](std::size_t member) {
      const Vector2d& was = seen_[member * eyes_.size() + e];
      if (std::isnan(was.x())) return true;
      return visit(eyes_[e].index, pixel ? (*pixel - was).norm() : std::numeric_limits<double>::infinity());
    };
    if (!each(v)) return false;
    for (const std::size_t member : merged_[v])
      if (!each(member)) return false;
  }
  return true;
}

bool ReprojectionBound::allows(std::size_t v, const Vector3d& position) const {
  return visit(v, position, [&](std::size_t, double moved) { return moved <= limit_; });
}

Vector3d ReprojectionBound::nearest_allowed(std::size_t v, const Vector3d& start,
                                            const Vector3d& wish) const {
  if (allows(v, wish)) return wish;
  double possible = 0, impossible = 1;
  for (int round = 0; round < 6; ++round) {
    const double middle = (possible + impossible) / 2;
    (allows(v, start + middle * (wish - start)) ? possible : impossible) = middle;
  }
  return start + possible * (wish - start);
}

void ReprojectionBound::merge(std::size_t gone, std::size_t stays) {
  merged_[stays].push_back(gone);
  merged_[stays].insert(merged_[stays].end(), merged_[gone].begin(), merged_[gone].end());
  merged_[gone] = {};
}

double ReprojectionBound::distance(const Vector3d& point, const Vector3d& a, const Vector3d& b) const {
  double largest = 0;
  for (const Eye& eye : eyes_) {
    const auto see = [&](const Vector3d& x) {
      return project(eye.camera->model, eye.camera->cam_from_world * x);
    };
    const auto p = see(point), s = see(a), t = see(b);
    if (!p && !s && !t) continue;
    if (!p || !s || !t) return std::numeric_limits<double>::infinity();
    largest = std::max(largest, distance_to_segment(*p, *s, *t));
  }
  return largest;
}

void ReprojectionBound::measure(std::size_t v, const Vector3d& position, std::vector<double>& moves) const {
  visit(v, position, [&](std::size_t camera, double moved) {
    moves[camera] = std::max(moves[camera], moved);
    return true;
  });
}

}  // namespace floatstage::recon
