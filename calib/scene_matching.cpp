#include "calib/scene_matching.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>

#include <Eigen/Dense>

#include "calib/scene_rays.h"
#include "core/parallel.h"

namespace floatstage::calib {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Keypoints = SceneKeypoints;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

constexpr double kFarthest = 0.7;  // radians between descriptors
constexpr double kMargin = 0.8;    // nearest over second nearest

int likeness(const Keypoints::Descriptor& a, const Keypoints::Descriptor& b) {
  int sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += static_cast<int>(a[i]) * static_cast<int>(b[i]);
  return sum;
}

double angle(int like) { return std::acos(std::min(like / (512.0 * 512.0), 1.0)); }

// The two most alike so far.
struct Best {
  int index = -1, first = 0, second = 0;
  void add(int i, int like) {
    if (like > first) {
      second = first;
      first = like;
      index = i;
    } else {
      second = std::max(second, like);
    }
  }
  bool clear() const {
    return index >= 0 && angle(first) <= kFarthest && angle(first) < kMargin * angle(second);
  }
};

// `for_candidates(i, take)` calls take(k) for every keypoint of the other that need be compared with i, in
// any order: of two that are equally alike neither is clear.
template <class Candidates>
SceneMatches match_pair(const Keypoints& one, const Keypoints& other, int a, int b,
                        const Candidates& for_candidates) {
  std::vector<Best> of_one(one.keypoints.size()), of_other(other.keypoints.size());
  for (std::size_t i = 0; i < of_one.size(); ++i)
    for_candidates(i, [&](std::size_t k) {
      const int like = likeness(one.descriptors[i], other.descriptors[k]);
      of_one[i].add(static_cast<int>(k), like);
      of_other[k].add(static_cast<int>(i), like);
    });
  SceneMatches out{a, b, {}};
  for (std::size_t i = 0; i < of_one.size(); ++i)
    if (of_one[i].clear())
      if (const Best& back = of_other[at(of_one[i].index)]; back.clear() && back.index == static_cast<int>(i))
        out.matches.push_back({static_cast<int>(i), of_one[i].index, of_one[i].first});
  return out;
}

std::vector<SceneMatches> every_pair(std::size_t pictures) {
  std::vector<SceneMatches> pairs;
  for (int a = 0; a < static_cast<int>(pictures); ++a)
    for (int b = a + 1; b < static_cast<int>(pictures); ++b) pairs.push_back({a, b, {}});
  return pairs;
}

// Of more pictures than this, each is compared with its best partners only: what farther ones share is
// joined through those between.
constexpr std::size_t kFewPictures = 32, kPartners = 16;

// Every pair in which one is among the other's partners, those of the largest score(a, b); a score below zero
// is none.
template <class Score>
std::vector<SceneMatches> chosen_pairs(std::size_t pictures, const Score& score) {
  std::vector<SceneMatches> pairs = every_pair(pictures);
  if (pictures <= kFewPictures) return pairs;
  std::vector<std::vector<std::pair<double, std::size_t>>> of(pictures);  // score, pair
  for (std::size_t p = 0; p < pairs.size(); ++p)
    if (const double s = score(p, pairs[p].a, pairs[p].b); s >= 0)
      for (const int picture : {pairs[p].a, pairs[p].b}) of[at(picture)].emplace_back(-s, p);
  std::vector<bool> chosen(pairs.size());
  for (auto& list : of) {
    std::sort(list.begin(), list.end());
    for (std::size_t i = 0; i < std::min(list.size(), kPartners); ++i) chosen[list[i].second] = true;
  }
  std::vector<SceneMatches> out;
  for (std::size_t p = 0; p < pairs.size(); ++p)
    if (chosen[p]) out.push_back(pairs[p]);
  return out;
}

// All with all.
SceneMatches match_all(const Keypoints& one, const Keypoints& other, int a, int b) {
  return match_pair(one, other, a, b, [n = other.keypoints.size()](std::size_t, const auto& take) {
    for (std::size_t k = 0; k < n; ++k) take(k);
  });
}

// The largest keypoints of a picture: few, and seen from far and near.
Keypoints largest(const Keypoints& picture) {
  constexpr std::size_t kVotes = 400;
  std::vector<std::size_t> order(picture.keypoints.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t i, std::size_t k) {
    return picture.keypoints[i].size > picture.keypoints[k].size;
  });
  Keypoints out;
  for (std::size_t i = 0; i < std::min(order.size(), kVotes); ++i) {
    out.keypoints.push_back(picture.keypoints[order[i]]);
    out.descriptors.push_back(picture.descriptors[order[i]]);
  }
  return out;
}

// Pairs of which a few keypoints tell that they show the same things.
std::vector<SceneMatches> pairs_by_vote(std::span<const Keypoints> pictures, int threads) {
  if (pictures.size() <= kFewPictures) return every_pair(pictures.size());
  std::vector<Keypoints> few(pictures.size());
  for (std::size_t i = 0; i < few.size(); ++i) few[i] = largest(pictures[i]);
  const std::vector<SceneMatches> all = every_pair(pictures.size());
  std::vector<double> votes(all.size());
  parallel_for(all.size(), threads, [&](std::size_t p) {
    votes[p] = static_cast<double>(
        match_all(few[at(all[p].a)], few[at(all[p].b)], all[p].a, all[p].b).matches.size());
  });
  return chosen_pairs(pictures.size(), [&](std::size_t p, int, int) { return votes[p]; });
}

// Pairs of cameras that stand near one another and do not look in opposite directions.
std::vector<SceneMatches> pairs_by_place(const Rig& rig) {
  return chosen_pairs(rig.cameras.size(), [&](std::size_t, int a, int b) {
    const Rigid3 &one = rig.cameras[at(a)].cam_from_world, &other = rig.cameras[at(b)].cam_from_world;
    const Vector3d ahead = one.rotation.conjugate() * Vector3d::UnitZ();
    if (ahead.dot(other.rotation.conjugate() * Vector3d::UnitZ()) < 0) return -1.0;
    return 1 / (1e-9 + (one.center() - other.center()).norm());
  });
}

// A keypoint's ray (z = 1), and the plane through it and the other camera, in the other camera: its epipolar
// line. All these planes pass through both cameras; `turn` is the angle of each about the line that joins
// them.
struct Line {
  Vector3d ray = Vector3d::Zero(),
           line =
               Vector3d::Zero();  // line: such that line·ray is a distance at z = 1; zero when there is none
  double turn = 0;                // 0 to pi
  double off = 0;                 // distance of the ray's end (z = 1) from the line that joins the cameras
};

// Two directions across the line that joins two cameras, from which angles about it are counted.
std::array<Vector3d, 2> across_baseline(const RigCamera& one, const RigCamera& other) {
  const Vector3d baseline = other.cam_from_world.center() - one.cam_from_world.center();
  const Vector3d u = baseline.unitOrthogonal();
  return {u, baseline.normalized().cross(u)};
}

std::vector<Line> lines(const Keypoints& picture, const RigCamera& camera, const RigCamera& other,
                        const std::array<Vector3d, 2>& across) {
  const Rigid3 other_from_camera = other.cam_from_world * camera.cam_from_world.inverse();
  const Vector3d u = camera.cam_from_world.rotation * across[0],
                 v = camera.cam_from_world.rotation * across[1];
  std::vector<Line> out(picture.keypoints.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::optional<Vector3d> ray = unproject(camera.model, picture.keypoints[i].pixel);
    if (!ray || !(ray->z() > 0)) continue;
    const Vector3d plane = other_from_camera.translation.cross(other_from_camera.rotation * *ray);
    const double norm = plane.head<2>().norm();
    if (!(norm > 0)) continue;
    const double x = ray->dot(u), y = ray->dot(v), turn = std::atan2(y, x);
    out[i] = {*ray, plane / norm, turn < 0 ? turn + std::numbers::pi : turn, std::hypot(x, y)};
  }
  return out;
}

// Keypoints in the order in which a plane that turns about the line between two cameras meets them.
class Fan {
 public:
  explicit Fan(const std::vector<Line>& lines) {
    for (std::size_t k = 0; k < lines.size(); ++k)
      if (lines[k].ray.z() > 0) order_.emplace_back(lines[k].turn, k);
    std::sort(order_.begin(), order_.end());
  }

  // Calls take(k) for all that may lie within `near` (at z = 1) of the line that k draws into the picture of
  // x, and for a few beside them.
  template <class Take>
  void near(const Line& x, double near, const Take& take) const {
    // What is off a plane by an angle is off the line in the picture by x.off times its sine, or more.
    constexpr double kRounding = 1e-9;
    const double sine = near / std::max(x.off, 1e-300);
    const double reach = sine < 1 ? std::asin(sine) + kRounding : std::numbers::pi;
    if (reach >= std::numbers::pi / 2) return range(0, std::numbers::pi, take);
    range(x.turn - reach, x.turn + reach, take);
    if (x.turn < reach) range(x.turn - reach + std::numbers::pi, std::numbers::pi, take);
    if (x.turn + reach > std::numbers::pi) range(0, x.turn + reach - std::numbers::pi, take);
  }

 private:
  template <class Take>
  void range(double from, double to, const Take& take) const {
    for (auto it = std::lower_bound(order_.begin(), order_.end(), std::pair(from, std::size_t{0}));
         it != order_.end() && it->first <= to; ++it)
      take(it->second);
  }

  std::vector<std::pair<double, std::size_t>> order_;  // turn, keypoint
};

// A point while matches are joined: picture and keypoint, ascending by picture.
using Track = std::vector<std::pair<int, int>>;

// The two as one, unless a picture has two keypoints of it.
std::optional<Track> joined(const Track& a, const Track& b) {
  Track out(a.size() + b.size());
  std::merge(a.begin(), a.end(), b.begin(), b.end(), out.begin());
  const auto twice = std::adjacent_find(out.begin(), out.end(),
                                        [](const auto& x, const auto& y) { return x.first == y.first; });
  if (twice != out.end()) return std::nullopt;
  return out;
}

// Leaves out what is farthest off until all agree; absent when fewer than three cameras do.
std::optional<SceneFeature> agreed(SceneFeature feature, const Rig& rig, double tolerance) {
  while (feature.seen.size() >= 3) {
    const std::optional<Vector3d> place = meeting_point(rig, feature.seen);
    if (!place) return std::nullopt;
    feature.position = *place;
    double worst = 0;
    std::size_t which = 0;
    for (std::size_t s = 0; s < feature.seen.size(); ++s) {
      const auto& [camera, pixel] = feature.seen[s];
      const RigCamera& c = rig.cameras[at(camera)];
      const std::optional<Vector2d> seen = project(c.model, c.cam_from_world * *place);
      const double off = seen ? (*seen - pixel).norm() : std::numeric_limits<double>::infinity();
      if (off > worst) std::tie(worst, which) = std::pair(off, s);
    }
    if (worst <= tolerance) return feature;
    feature.seen.erase(feature.seen.begin() + static_cast<std::ptrdiff_t>(which));
  }
  return std::nullopt;
}

}  // namespace

std::vector<SceneMatches> match_pictures(std::span<const SceneKeypoints> pictures, int threads) {
  std::vector<SceneMatches> pairs = pairs_by_vote(pictures, threads);
  parallel_for(pairs.size(), threads, [&](std::size_t p) {
    const int a = pairs[p].a, b = pairs[p].b;
    pairs[p] = match_all(pictures[at(a)], pictures[at(b)], a, b);
  });
  return pairs;
}

std::vector<SceneMatches> match_along_lines(std::span<const SceneKeypoints> pictures, const Rig& rig,
                                            double tolerance, int threads) {
  std::vector<SceneMatches> pairs = pairs_by_place(rig);
  parallel_for(pairs.size(), threads, [&](std::size_t p) {
    const int a = pairs[p].a, b = pairs[p].b;
    const RigCamera &one = rig.cameras[at(a)], &other = rig.cameras[at(b)];
    const std::array<Vector3d, 2> across = across_baseline(one, other);
    const std::vector<Line> in_other = lines(pictures[at(a)], one, other, across),
                            in_one = lines(pictures[at(b)], other, one, across);
    const Fan fan(in_one);
    const double near_other = tolerance / other.model.fx, near_one = tolerance / one.model.fx;
    pairs[p] = match_pair(pictures[at(a)], pictures[at(b)], a, b, [&](std::size_t i, const auto& take) {
      const Line& x = in_other[i];
      if (!(x.ray.z() > 0)) return;
      fan.near(x, near_one, [&](std::size_t k) {
        const Line& y = in_one[k];
        if (std::abs(x.line.dot(y.ray)) <= near_other && std::abs(y.line.dot(x.ray)) <= near_one) take(k);
      });
    });
  });
  return pairs;
}

std::vector<SceneFeature> points_of_matches(std::span<const SceneKeypoints> pictures,
                                            std::span<const SceneMatches> matches, const Rig& rig,
                                            double tolerance) {
  std::vector<std::tuple<int, int, int, int, int>> all;  // most alike first, then pictures and keypoints
  for (const SceneMatches& pair : matches)
    for (const SceneMatches::Match& m : pair.matches) all.emplace_back(-m.likeness, pair.a, pair.b, m.i, m.k);
  std::sort(all.begin(), all.end());
  std::vector<Track> tracks;
  std::vector<std::vector<int>> track_of;
  for (int picture = 0; picture < static_cast<int>(pictures.size()); ++picture) {
    track_of.emplace_back(pictures[at(picture)].keypoints.size());
    for (std::size_t k = 0; k < track_of.back().size(); ++k) {
      track_of.back()[k] = static_cast<int>(tracks.size());
      tracks.push_back({{picture, static_cast<int>(k)}});
    }
  }
  for (const auto& [unlike, a, b, i, k] : all) {
    const int into = track_of[at(a)][at(i)], from = track_of[at(b)][at(k)];
    if (into == from) continue;
    std::optional<Track> one = joined(tracks[at(into)], tracks[at(from)]);
    if (!one) continue;
    for (const auto& [picture, keypoint] : tracks[at(from)]) track_of[at(picture)][at(keypoint)] = into;
    tracks[at(from)].clear();
    tracks[at(into)] = *std::move(one);
  }
  std::vector<SceneFeature> out;
  for (const Track& track : tracks) {
    SceneFeature feature;
    for (const auto& [picture, keypoint] : track)
      feature.seen.emplace_back(picture, pictures[at(picture)].keypoints[at(keypoint)].pixel);
    if (std::optional<SceneFeature> kept = agreed(std::move(feature), rig, tolerance))
      out.push_back(*std::move(kept));
  }
  return out;
}

}  // namespace floatstage::calib
