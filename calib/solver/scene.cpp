#include "calib/solver/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "core/statistics.h"

namespace floatstage::calib::solver {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr int kAlways = std::numeric_limits<int>::min();  // the frame of what does not move

// Terms of the lens that are not solved for.
void hold_terms(const CalibrationCamera& c, SceneCamera& s) {
  s.held[kSkewRow] = !c.terms.skew;
  if (c.lens == LensKind::BrownConrady) {
    constexpr int kAbove = 3;  // terms of the numerator
    const auto* known = s.has_intrinsics ? std::get_if<BrownConrady>(&c.model.lens) : nullptr;
    const bool begins_rational = known && known->rational();
    const int radial = c.terms.radial.value_or(begins_rational ? 2 * kAbove : kAbove);
    for (int i = 0; i < kAbove; ++i) s.held[kRadialRows[at(i)]] = i >= radial;
    s.held.segment<2>(kTangentialRow).setConstant(!c.terms.tangential);
    s.held.segment<kAbove>(kDenominatorRow).setConstant(true);
    s.third_if_shown = !c.terms.radial && !begins_rational;
    s.denominator_terms = std::max(0, radial - kAbove);
    // A numerator without its denominator is no lens: all begins from none.
    if (begins_rational && radial < 2 * kAbove && !s.intrinsics_fixed)
      s.start.segment<kLensRows>(kLensRow).setZero(), s.intrinsics.segment<kLensRows>(kLensRow).setZero();
  }
  if (c.lens == LensKind::KannalaBrandt)
    for (int i = 0; i < 4; ++i) s.held[kLensRow + i] = i >= c.terms.radial.value_or(4);
  if (s.intrinsics_fixed) return;
  // Yesterday's lens may have had more terms. A denominator that is solved for later stays.
  for (int i = 0; i < kIntrinsics; ++i)
    if (s.held[i] && !(i >= kDenominatorRow && i < kDenominatorRow + s.denominator_terms))
      s.start[i] = s.intrinsics[i] = 0;
}

SceneCamera make_camera(const CalibrationCamera& c) {
  SceneCamera s;
  s.serial = c.serial;
  s.width = c.width;
  s.height = c.height;
  s.lens = c.lens;
  s.intrinsics_fixed = c.intrinsics == Prior::Fixed;
  s.pose_fixed = c.pose == Prior::Fixed;
  s.has_intrinsics = c.intrinsics != Prior::Unknown;
  if (s.has_intrinsics) s.start = s.intrinsics = pack(c.model);
  hold_terms(c, s);
  s.placed = c.pose != Prior::Unknown || c.found;
  s.lens_of = c.same_lens_as.value_or(-1);
  s.plain_lens = c.plain_lens;
  if (s.placed) s.cam_from_world = c.found && c.pose != Prior::Fixed ? *c.found : c.cam_from_world;
  return s;
}

// Boards or markers of each target in the order of their frames.
template <class Object>
std::map<int, std::vector<Object*>> tracks(std::vector<Object>& objects) {
  std::map<int, std::vector<Object*>> by_target;
  for (Object& o : objects) {
    if constexpr (requires { o.free_motion; }) {
      o.has_motion = o.free_motion;
      o.has_neighbours = false;
    } else {
      o.has_motion = false;
    }
    if (o.placed && o.frame != kAlways) by_target[o.target].push_back(&o);
  }
  for (auto& [target, track] : by_target)
    std::sort(track.begin(), track.end(), [](const Object* a, const Object* b) { return a->time < b->time; });
  return by_target;
}

// Velocity and acceleration of a parabola through three instants, at the middle one.
std::pair<Eigen::Vector3d, Eigen::Vector3d> parabola(const Eigen::Vector3d& before,
                                                     const Eigen::Vector3d& here,
                                                     const Eigen::Vector3d& after, double back, double on) {
  const Eigen::Vector3d v0 = (here - before) / back, v1 = (after - here) / on;
  return {(v0 * on + v1 * back) / (back + on), 2 * (v1 - v0) / (back + on)};
}

// The views of a target in a frame, by target and frame; what never moves has one frame for all.
std::map<std::pair<int, int>, std::vector<int>> instants(const Observations& o) {
  std::map<std::pair<int, int>, std::vector<int>> groups;
  for (std::size_t i = 0; i < o.views.size(); ++i) {
    const TargetView& v = o.views[i];
    const Target& target = o.targets[static_cast<std::size_t>(v.target)];
    const bool still = target.kind == TargetKind::Markers || target.is_static;
    groups[{v.target, still ? kAlways : v.frame}].push_back(static_cast<int>(i));
  }
  return groups;
}

// A marker needs two rays.
SceneMarkers markers_seen_twice(const Observations& o, const std::vector<int>& views) {
  SceneMarkers markers;
  std::map<int, int> seen;
  for (const int i : views) {
    const TargetView& v = o.views[static_cast<std::size_t>(i)];
    for (const SeenPoint& p : v.points)
      ++seen[point_index(o.targets[static_cast<std::size_t>(v.target)], p.id)];
  }
  for (const auto& [index, count] : seen)
    if (count >= 2) markers.indices.push_back(index);
  markers.positions.resize(markers.indices.size(), Eigen::Vector3d::Zero());
  return markers;
}

// The view of a board or of markers that are in the scene; none when nothing of it is.
void add_view(const Observations& o, SceneView view, Scene& scene) {
  const TargetView& from = o.views[static_cast<std::size_t>(view.source)];
  const Target& target = o.targets[static_cast<std::size_t>(from.target)];
  view.camera = from.camera;
  for (const SeenPoint& p : from.points) {
    int index = point_index(target, p.id);
    if (view.board < 0) {
      const std::vector<int>& known = scene.markers[static_cast<std::size_t>(view.markers)].indices;
      const auto found = std::find(known.begin(), known.end(), index);
      if (found == known.end()) continue;
      index = static_cast<int>(found - known.begin());
    }
    view.points.push_back({index, p.pixel, p.sigma, true});
  }
  if (!view.points.empty()) scene.views.push_back(std::move(view));
}

// Seconds from one frame to the next; 0 for stills, which have no times.
double period_of(const std::map<int, double>& frame_times) {
  std::vector<double> steps;
  for (auto a = frame_times.begin(); a != frame_times.end(); ++a)
    if (const auto b = std::next(a); b != frame_times.end() && b->first > a->first)
      if (const double step = (b->second - a->second) / (b->first - a->first); step > 0)
        steps.push_back(step);
  return steps.empty() ? 0 : median(std::move(steps));
}

}  // namespace

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Quaterniond rotation_from_vector(const Eigen::Vector3d& v) {
  const double angle = v.norm();
  if (angle < 1e-12) return Eigen::Quaterniond(1, v.x() / 2, v.y() / 2, v.z() / 2).normalized();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, v / angle));
}

Eigen::Vector3d vector_from_rotation(const Eigen::Quaterniond& q) {
  const Eigen::Vector3d v = q.w() < 0 ? Eigen::Vector3d(-q.vec()) : Eigen::Vector3d(q.vec());
  const double sine = v.norm();
  if (sine < 1e-12) return 2 * v;
  return v * (2 * std::atan2(sine, std::abs(q.w())) / sine);
}

double angle_between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return vector_from_rotation(a.conjugate() * b).norm();
}

Rigid3 SceneBoard::at(double dt) const {
  if (!has_motion || dt == 0) return world_from_target;
  return {(rotation_from_vector(spin * dt) * world_from_target.rotation).normalized(),
          world_from_target.translation + velocity * dt + acceleration * (dt * dt / 2)};
}

Scene make_scene(const Observations& o) {
  Scene scene;
  scene.targets = o.targets;
  for (const CalibrationCamera& c : o.cameras) scene.cameras.push_back(make_camera(c));
  for (const CameraDistance& d : o.distances) scene.distances.push_back({d.a, d.b, d.metres, d.sigma});
  std::int64_t first = std::numeric_limits<std::int64_t>::max();
  for (const TargetView& v : o.views) first = std::min(first, v.time.ns);
  std::map<int, double> frame_times;
  for (const auto& [key, members] : instants(o)) {
    const auto [target, frame] = key;
    std::vector<double> times;
    for (const int i : members)
      times.push_back(1e-9 * static_cast<double>(o.views[static_cast<std::size_t>(i)].time.ns - first));
    const double time = median(std::move(times));
    if (frame != kAlways) frame_times.emplace(frame, time);
    SceneView like;  // what the instant's views have in common
    if (o.targets[static_cast<std::size_t>(target)].kind == TargetKind::Board) {
      like.board = static_cast<int>(scene.boards.size());
      SceneBoard& board = scene.boards.emplace_back();
      board.target = target;
      board.frame = frame;
      board.time = time;
    } else {
      like.markers = static_cast<int>(scene.markers.size());
      scene.markers.push_back(markers_seen_twice(o, members));
      scene.markers.back().target = target;
      scene.markers.back().frame = frame;
      scene.markers.back().time = time;
    }
    for (const int i : members) {
      like.source = i;
      like.lag =
          frame == kAlways
              ? 0
              : 1e-9 * static_cast<double>(o.views[static_cast<std::size_t>(i)].time.ns - first) - time;
      add_view(o, like, scene);
    }
  }
  scene.period = period_of(frame_times);
  return scene;
}

bool usable(const Scene& scene, const SceneView& v) {
  if (!scene.cameras[static_cast<std::size_t>(v.camera)].placed) return false;
  return v.board >= 0 ? scene.boards[static_cast<std::size_t>(v.board)].placed
                      : scene.markers[static_cast<std::size_t>(v.markers)].placed;
}

Rigid3 camera_from_target(const Scene& scene, const SceneView& v) {
  const SceneCamera& camera = scene.cameras[static_cast<std::size_t>(v.camera)];
  const SceneBoard& board = scene.boards[static_cast<std::size_t>(v.board)];
  return camera.cam_from_world * board.at(v.lag + v.jitter + camera.offset);
}

std::vector<Eigen::Vector2d> errors_of(const Scene& scene, const SceneView& v) {
  const SceneCamera& camera = scene.cameras[static_cast<std::size_t>(v.camera)];
  std::vector<Eigen::Vector2d> errors;
  errors.reserve(v.points.size());
  const Rigid3 from_target = v.board >= 0 ? camera_from_target(scene, v) : Rigid3{};
  for (const ScenePoint& p : v.points) {
    const auto i = static_cast<std::size_t>(p.index);
    Eigen::Vector3d in_camera;
    if (v.board >= 0) {
      const SceneBoard& board = scene.boards[static_cast<std::size_t>(v.board)];
      in_camera = from_target * scene.targets[static_cast<std::size_t>(board.target)].points[i].position;
    } else {
      const SceneMarkers& m = scene.markers[static_cast<std::size_t>(v.markers)];
      Eigen::Vector3d x = m.positions[i];
      if (m.has_motion) x += m.velocities[i] * (v.lag + camera.offset);
      in_camera = camera.cam_from_world * x;
    }
    Projected projected;
    if (project<Slopes::None>(camera.intrinsics, camera.lens, in_camera, projected))
      errors.push_back(projected.pixel - p.pixel);
    else
      errors.push_back(Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()));
  }
  return errors;
}

void estimate_motion(Scene& scene) {
  // Over longer gaps a hand does not move along a parabola.
  const double longest = 2.5 * scene.period;
  if (!(longest > 0)) return;
  for (auto& [target, track] : tracks(scene.boards))
    for (std::size_t i = 1; i + 1 < track.size(); ++i) {
      const SceneBoard &before = *track[i - 1], &after = *track[i + 1];
      SceneBoard& here = *track[i];
      const double back = here.time - before.time, on = after.time - here.time;
      if (!(back > 0 && on > 0 && back <= longest && on <= longest)) continue;
      std::tie(here.likely_velocity, here.acceleration) =
          parabola(before.world_from_target.translation, here.world_from_target.translation,
                   after.world_from_target.translation, back, on);
      const Eigen::Quaterniond turn =
          after.world_from_target.rotation * before.world_from_target.rotation.conjugate();
      here.likely_spin = vector_from_rotation(turn) / (back + on);
      here.has_motion = here.has_neighbours = true;
      here.spin_doubt = scene.spin_doubt;
      here.velocity_doubt = scene.velocity_doubt;
      if (here.free_motion) continue;
      here.spin = here.likely_spin;
      here.velocity = here.likely_velocity;
    }
  for (auto& [target, track] : tracks(scene.markers))
    for (std::size_t i = 1; i + 1 < track.size(); ++i) {
      const SceneMarkers &before = *track[i - 1], &after = *track[i + 1];
      SceneMarkers& here = *track[i];
      const double back = here.time - before.time, on = after.time - here.time;
      if (!(back > 0 && on > 0 && back <= longest && on <= longest)) continue;
      here.velocities.assign(here.positions.size(), Eigen::Vector3d::Zero());
      here.has_motion = before.indices == here.indices && after.indices == here.indices;
      if (!here.has_motion) continue;
      for (std::size_t k = 0; k < here.positions.size(); ++k)
        here.velocities[k] =
            parabola(before.positions[k], here.positions[k], after.positions[k], back, on).first;
    }
}

void free_motion(Scene& scene) {
  for (SceneBoard& b : scene.boards) {
    if (b.free_motion || b.frame == kAlways) continue;
    constexpr double kUnknown = 5;  // no neighbours: any motion of a hand
    if (!b.has_neighbours) {
      b.spin_doubt = kUnknown * kSpinDoubt;
      b.velocity_doubt = kUnknown * kVelocityDoubt;
    }
    b.free_motion = b.has_motion = true;
  }
}

}  // namespace floatstage::calib::solver
