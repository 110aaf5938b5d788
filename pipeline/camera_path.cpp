#include "pipeline/camera_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/text.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Vector3d;
constexpr double kPi = std::numbers::pi;
constexpr double kSameFrame = 1e-6;  // of a frame: what rounding costs a time that is one

// What a cubic Hermite of a stretch leaves its first key with and comes to its second with, of full speed.
struct Eased {
  double out = 1, in = 1;
};

template <class T>
T hermite(const T& b, const T& c, const T& tangent_b, const T& tangent_c, double s) {
  const double s2 = s * s, s3 = s2 * s;
  return (2 * s3 - 3 * s2 + 1) * b + (s3 - 2 * s2 + s) * tangent_b + (3 * s2 - 2 * s3) * c +
         (s3 - s2) * tangent_c;
}

// A value at the four keys around a stretch, which goes from b to c; a and d may be b and c again.
template <class T>
struct Around {
  T a, b, c, d;
  double ta, tb, tc, td;

  T tangent_b() const { return tc > ta ? T((c - a) * ((tc - tb) / (tc - ta))) : T(c - b); }
  T tangent_c() const { return td > tb ? T((d - b) * ((tc - tb) / (td - tb))) : T(c - b); }
  T at(double t, const Eased& speed) const {
    return hermite<T>(b, c, tangent_b() * speed.out, tangent_c() * speed.in, (t - tb) / (tc - tb));
  }
};

// The keys of a path as they stand in the world at one time.
class Placed {
 public:
  Placed(std::vector<PathKey> keys, const Vector3d& subject) : keys_(std::move(keys)) {
    for (PathKey& k : keys_)
      if (k.follow) k.eye += subject, k.target += subject;
  }

  PathKey at(double time) const {
    std::size_t i = 0;
    while (i + 2 < keys_.size() && keys_[i + 1].time <= time) ++i;
    const Eased speed{1 - keys_[i].ease_out, 1 - keys_[i + 1].ease_in};
    PathKey key;
    key.time = time;
    key.target = around<Vector3d>(i, &PathKey::target).at(time, speed);
    key.up = around<Vector3d>(i, &PathKey::up).at(time, speed).normalized();
    key.fov_y = around<double>(i, &PathKey::fov_y).at(time, speed);
    key.eye = keys_[i].orbit ? orbit(i, time, speed) : straight(i, time, speed);
    return key;
  }

 private:
  template <class T>
  Around<T> around(std::size_t i, T PathKey::*member) const {
    const PathKey &a = keys_[i > 0 ? i - 1 : i], &b = keys_[i], &c = keys_[i + 1],
                  &d = keys_[std::min(i + 2, keys_.size() - 1)];
    return {a.*member, b.*member, c.*member, d.*member, a.time, b.time, c.time, d.time};
  }
  bool orbits(std::size_t i) const { return i + 1 < keys_.size() && keys_[i].orbit; }

  // Around the target: height above it, distance from the axis, angle from where the stretch begins.
  struct Cylinder {
    Vector3d axis, first, second;  // the last two span the plane across the axis
    explicit Cylinder(const PathKey& b, const PathKey& c) : axis((b.up + c.up).normalized()) {
      const Vector3d out = b.eye - b.target;
      first = out - axis * axis.dot(out);
      first = first.norm() > 1e-9 * out.norm() ? first.normalized() : axis.unitOrthogonal();
      second = axis.cross(first);
    }
    double angle(const PathKey& k) const {
      const Vector3d out = k.eye - k.target;
      return std::atan2(second.dot(out), first.dot(out));
    }
    Vector3d of(const PathKey& k) const {  // distance and height; the angle is the caller's
      const Vector3d out = k.eye - k.target;
      return {std::hypot(first.dot(out), second.dot(out)), axis.dot(out), 0};
    }
  };
  double sweep(std::size_t i) const {
    return Cylinder(keys_[i], keys_[i + 1]).angle(keys_[i + 1]) + 2 * kPi * *keys_[i].orbit;
  }

  Vector3d orbit(std::size_t i, double time, const Eased& speed) const {
    const PathKey &b = keys_[i], &c = keys_[i + 1];
    const Cylinder frame(b, c);
    // Speed carries over from and into orbits only.
    const bool before = i > 0 && orbits(i - 1), after = orbits(i + 1);
    Around<Vector3d> way{frame.of(b), frame.of(b), frame.of(c), frame.of(c), b.time, b.time, c.time, c.time};
    way.c.z() = way.d.z() = sweep(i);
    if (before) way.a = frame.of(keys_[i - 1]), way.a.z() = -sweep(i - 1), way.ta = keys_[i - 1].time;
    if (after)
      way.d = frame.of(keys_[i + 2]), way.d.z() = sweep(i) + sweep(i + 1), way.td = keys_[i + 2].time;
    const Vector3d p = way.at(time, speed);
    const Vector3d target = around<Vector3d>(i, &PathKey::target).at(time, speed);
    return target + frame.axis * p.y() +
           (frame.first * std::cos(p.z()) + frame.second * std::sin(p.z())) * p.x();
  }

  // As the spline goes; beside an orbit as fast as that.
  Vector3d straight(std::size_t i, double time, const Eased& speed) const {
    const Around<Vector3d> way = around<Vector3d>(i, &PathKey::eye);
    Vector3d tangent_b = way.tangent_b(), tangent_c = way.tangent_c();
    const double h = way.tc - way.tb, tiny = 1e-5;
    if (i > 0 && orbits(i - 1)) {
      const double step = tiny * (way.tb - way.ta);
      tangent_b = (orbit(i - 1, way.tb, {}) - orbit(i - 1, way.tb - step, {})) * (h / step);
    }
    if (orbits(i + 1)) {
      const double step = tiny * (way.td - way.tc);
      tangent_c = (orbit(i + 1, way.tc + step, {}) - orbit(i + 1, way.tc, {})) * (h / step);
    }
    return hermite<Vector3d>(way.b, way.c, tangent_b * speed.out, tangent_c * speed.in, (time - way.tb) / h);
  }

  std::vector<PathKey> keys_;
};

bool says_take_time(const PathKey& key) { return key.take_time.has_value(); }

}  // namespace

Vector3d SubjectTrack::at(double take_time) const {
  if (centres.empty()) return Vector3d::Zero();
  const double last = static_cast<double>(centres.size() - 1),
               frame = std::floor(take_time * frame_rate + kSameFrame);
  return centres[static_cast<std::size_t>(std::clamp(frame, 0.0, last))];
}

bool CameraPath::follows() const {
  return std::any_of(keys.begin(), keys.end(), [](const PathKey& k) { return k.follow; });
}

bool CameraPath::has_take_times() const { return std::any_of(keys.begin(), keys.end(), says_take_time); }

PathKey sample(const CameraPath& path, double time, const SubjectTrack& subject) {
  FLOATSTAGE_CHECK(!path.keys.empty(), "sampling a path without keys");
  const std::vector<PathKey>& keys = path.keys;
  const Vector3d centre = path.follows() ? subject.at(take_time(path, time)) : Vector3d::Zero();
  if (time > keys.front().time && time < keys.back().time) return Placed(keys, centre).at(time);
  PathKey held = time <= keys.front().time ? keys.front() : keys.back();
  if (std::exchange(held.follow, false)) held.eye += centre, held.target += centre;
  return held;
}

double take_time(const CameraPath& path, double time) {
  const PathKey *before = nullptr, *after = nullptr;
  for (const PathKey& key : path.keys) {
    if (!key.take_time) continue;
    if (key.time <= time) before = &key;
    if (key.time > time && !after) after = &key;
  }
  if (!before && !after) return time;
  if (!before) return *after->take_time - (after->time - time);
  if (!after) return *before->take_time + (time - before->time);
  const double share = (time - before->time) / (after->time - before->time);
  return *before->take_time + share * (*after->take_time - *before->take_time);
}

std::size_t shown_at(const CameraPath& path, double time, double take_rate, std::span<const int> frames) {
  FLOATSTAGE_CHECK(!frames.empty(), "there is no frame to show");
  if (frames.size() == 1 || !(take_rate > 0)) return 0;
  const double frame = std::floor(take_time(path, time) * take_rate + kSameFrame);
  if (!path.has_take_times()) return static_cast<std::size_t>(std::max(0.0, frame)) % frames.size();
  const auto nearest = std::min_element(
      frames.begin(), frames.end(), [&](int a, int b) { return std::abs(a - frame) < std::abs(b - frame); });
  return static_cast<std::size_t>(nearest - frames.begin());
}

View view_of(const PathKey& key, int width, int height, const Eigen::AlignedBox3d& subject) {
  View view;
  const double f = height / (2 * std::tan(key.fov_y * kPi / 360));
  view.model = {.width = width,
                .height = height,
                .fx = f,
                .fy = f,
                .cx = width / 2.0,
                .cy = height / 2.0,
                .skew = 0,
                .lens = {}};
  view.view_from_world = look_at(key.eye, key.target, key.up);
  const double radius = subject.isEmpty() ? 1 : subject.diagonal().norm() / 2;
  const double distance =
      subject.isEmpty() ? (key.target - key.eye).norm() : (subject.center() - key.eye).norm();
  view.far_plane = distance + 1.5 * radius;
  view.near_plane = std::max(distance - 1.5 * radius, view.far_plane * 1e-3);
  return view;
}

}  // namespace floatstage::pipeline
