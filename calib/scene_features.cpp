#include "calib/scene_features.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <Eigen/Dense>

#include "calib/scene_rays.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Cameras that both rigs have: indices.
std::vector<std::pair<std::size_t, std::size_t>> common(const Rig& rig, const Rig& known) {
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    if (const int k = camera_index(known, rig.cameras[i].serial); k >= 0) pairs.emplace_back(i, at(k));
  return pairs;
}

Vector3d center(const Rig& rig, std::size_t i) { return rig.cameras[i].cam_from_world.center(); }

}  // namespace

void add_features(Observations& o, std::span<const SceneFeature> features,
                  std::span<const int> camera_of_picture, std::size_t most, double sigma) {
  std::vector<const SceneFeature*> chosen;
  for (const SceneFeature& f : features)
    if (f.seen.size() >= 2) chosen.push_back(&f);
  std::stable_sort(chosen.begin(), chosen.end(),
                   [](const auto* a, const auto* b) { return a->seen.size() > b->seen.size(); });
  // Eighty cameras see a point sixty times: more of these make a rig no surer, and the solution slow.
  constexpr std::size_t kSights = 60'000, kEach = 200;
  const std::size_t share = std::max(kEach, kSights / std::max<std::size_t>(camera_of_picture.size(), 1));
  std::vector<std::size_t> sights(camera_of_picture.size());
  std::erase_if(chosen, [&](const SceneFeature* f) {
    const bool wanted = std::any_of(f->seen.begin(), f->seen.end(),
                                    [&](const auto& s) { return sights[at(s.first)] < share; });
    for (const auto& [picture, pixel] : f->seen) sights[at(picture)] += wanted;
    return !wanted;
  });
  if (chosen.size() > most) chosen.resize(most);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    Target target;
    target.name = text("feature ", i);
    target.kind = TargetKind::Markers;
    target.points = {{0, Vector3d::Zero(), Vector3d::Zero()}};
    const int index = static_cast<int>(o.targets.size());
    o.targets.push_back(std::move(target));
    for (const auto& [picture, pixel] : chosen[i]->seen)
      o.views.push_back({.camera = camera_of_picture[at(picture)],
                         .target = index,
                         .frame = 0,
                         .time = {},
                         .points = {{0, pixel, sigma}}});
  }
}

std::optional<double> metres_per_unit(const Observations& o, const Rig& rig) {
  std::map<std::pair<int, int>, std::map<int, std::vector<std::pair<int, Eigen::Vector2d>>>>
      frames;  // target and frame → id → rays
  for (const TargetView& v : o.views)
    if (o.targets[at(v.target)].kind != TargetKind::Markers || !o.targets[at(v.target)].lengths.empty())
      for (const SeenPoint& p : v.points) frames[{v.target, v.frame}][p.id].emplace_back(v.camera, p.pixel);
  std::vector<double> ratios;
  for (const auto& [key, points] : frames) {
    const Target& target = o.targets[at(key.first)];
    std::map<int, Vector3d> places;
    for (const auto& [id, seen] : points)
      if (seen.size() >= 2)
        if (const std::optional<Vector3d> x = meeting_point(rig, seen)) places[id] = *x;
    const auto add = [&](int a, int b, double metres) {
      const auto from = places.find(a), to = places.find(b);
      if (from == places.end() || to == places.end() || !(metres > 0)) return;
      if (const double length = (from->second - to->second).norm(); length > 0)
        ratios.push_back(metres / length);
    };
    for (const TargetLength& l : target.lengths) add(l.a, l.b, l.metres);
    if (target.kind != TargetKind::Board || places.size() < 2) continue;
    // Of a board the points farthest apart: what rays are off counts least there.
    const int first = places.begin()->first, last = places.rbegin()->first;
    add(first, last,
        (target.points[at(point_index(target, first))].position -
         target.points[at(point_index(target, last))].position)
            .norm());
  }
  if (ratios.size() < 3) return std::nullopt;
  return median(std::move(ratios));
}

namespace {

enum class Spread { Point, Line, Wide };

// How far centres reach, against where the numbers of a file end: rigs are written with six digits and more,
// and a pile of equal centres differs by rounding only.
Spread spread_of(const Eigen::Matrix3Xd& centers) {
  const Eigen::Matrix3Xd off = centers.colwise() - Vector3d(centers.rowwise().mean());
  const Vector3d s = Eigen::JacobiSVD<Eigen::Matrix3Xd>(off).singularValues();
  constexpr double kRounding = 1e-6;
  if (s[0] <= kRounding * std::max(1e-3, centers.colwise().norm().maxCoeff())) return Spread::Point;
  return s[1] <= 1e-3 * s[0] ? Spread::Line : Spread::Wide;
}

}  // namespace

std::optional<Rig> onto_known(const Rig& rig, const Rig& known) {
  const auto pairs = common(rig, known);
  if (pairs.size() < 3) return std::nullopt;
  std::vector<double> ratios;
  for (std::size_t a = 0; a < pairs.size(); ++a)
    for (std::size_t b = a + 1; b < pairs.size(); ++b)
      if (const double length = (center(rig, pairs[a].first) - center(rig, pairs[b].first)).norm();
          length > 0)
        ratios.push_back((center(known, pairs[a].second) - center(known, pairs[b].second)).norm() / length);
  if (ratios.empty()) return std::nullopt;
  const double scale = median(std::move(ratios));
  // The turn that most cameras agree on.
  std::vector<Eigen::Quaterniond> turns;
  for (const auto& [i, k] : pairs)
    turns.push_back(
        (known.cameras[k].cam_from_world.rotation.conjugate() * rig.cameras[i].cam_from_world.rotation)
            .normalized());
  double least = std::numeric_limits<double>::infinity();
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
  for (const Eigen::Quaterniond& candidate : turns) {
    std::vector<double> angles;
    for (const Eigen::Quaterniond& other : turns)
      if (&other != &candidate) angles.push_back(candidate.angularDistance(other));
    if (const double m = median(std::move(angles)); m < least) {
      least = m;
      turn = candidate;
    }
  }
  Vector3d shift;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const auto& [i, k] : pairs)
      values.push_back((center(known, k) - turn * (scale * center(rig, i)))[axis]);
    shift[axis] = median(std::move(values));
  }
  Rig out = rig;
  const Rigid3 old_from_new = Rigid3{turn, shift}.inverse();
  for (RigCamera& c : out.cameras) {
    c.cam_from_world.translation *= scale;
    c.cam_from_world = c.cam_from_world * old_from_new;
    c.cam_from_world.rotation.normalize();
  }
  return out;
}

Result<RigAgreement> agreement(const Rig& rig, const Rig& known) {
  const auto pairs = common(rig, known);
  if (pairs.size() < 3)
    return fail(ErrorCode::BadData, text("only ", pairs.size(),
                                         " cameras are in both rigs and a similarity fits any two centres "
                                         "exactly; three or more are needed"));
  const auto n = static_cast<Eigen::Index>(pairs.size());
  Eigen::Matrix3Xd from(3, n), to(3, n);
  Rig shared;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto& [a, b] = pairs[static_cast<std::size_t>(i)];
    from.col(i) = center(rig, a);
    to.col(i) = center(known, b);
    shared.cameras.push_back(known.cameras[b]);
  }
  const Spread solved_spread = spread_of(from), known_spread = spread_of(to);
  for (const auto& [spread, whose] : {std::pair{solved_spread, "solved"}, std::pair{known_spread, "known"}})
    if (spread == Spread::Point)
      return fail(ErrorCode::BadData, text("the ", whose,
                                           " cameras all stand in one point, which any rig fits "
                                           "when it is made small enough; there is no baseline to compare"));
  const Eigen::Matrix4d similarity = Eigen::umeyama(from, to);
  const Eigen::Matrix3Xd off =
      ((similarity.topLeftCorner<3, 3>() * from).colwise() + Vector3d(similarity.topRightCorner<3, 1>())) -
      to;
  const double radius = (to.colwise() - focus_point(shared)).colwise().norm().mean();
  RigAgreement out;
  out.cameras = static_cast<int>(n);
  out.scale = std::cbrt(std::abs(similarity.topLeftCorner<3, 3>().determinant()));
  const Eigen::Quaterniond turn(Matrix3d(similarity.topLeftCorner<3, 3>() / out.scale));
  out.rms_percent = 100 * std::sqrt(off.squaredNorm() / static_cast<double>(n)) / radius;
  Eigen::Index worst = 0;
  out.worst_percent = 100 * off.colwise().norm().maxCoeff(&worst) / radius;
  out.worst = rig.cameras[pairs[static_cast<std::size_t>(worst)].first].serial;
  double worst_turn = 0;
  for (const auto& [a, b] : pairs) {
    const Eigen::Quaterniond now = rig.cameras[a].cam_from_world.rotation * turn.conjugate();
    worst_turn = std::max(
        worst_turn, now.angularDistance(known.cameras[b].cam_from_world.rotation) * 180 / std::numbers::pi);
  }
  const bool line = solved_spread == Spread::Line || known_spread == Spread::Line;
  out.worst_turn_degrees =
      Measured::of(worst_turn, line ? 0 : out.cameras,
                   "the cameras stand in one line, about which their centres leave the rig free to turn");
  return out;
}

}  // namespace floatstage::calib
