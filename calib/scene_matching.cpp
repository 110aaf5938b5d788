#include "calib/scene_matching.h"

#include <algorithm>
#include <cmath>
#include <limits>
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

// `possible(i, k)` says whether two keypoints need be compared.
template <class Possible>
SceneMatches match_pair(const Keypoints& one, const Keypoints& other, int a, int b,
                        const Possible& possible) {
  std::vector<Best> of_one(one.keypoints.size()), of_other(other.keypoints.size());
  for (std::size_t i = 0; i < of_one.size(); ++i)
    for (std::size_t k = 0; k < of_other.size(); ++k) {
      if (!possible(i, k)) continue;
      const int like = likeness(one.descriptors[i], other.descriptors[k]);
      of_one[i].add(static_cast<int>(k), like);
      of_other[k].add(static_cast<int>(i), like);
    }
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

// A keypoint's ray (z = 1), and the plane through it and the other camera, in the other camera: its epipolar
// line.
struct Line {
  Vector3d ray = Vector3d::Zero(),
           line =
               Vector3d::Zero();  // line: such that line·ray is a distance at z = 1; zero when there is none
};

std::vector<Line> lines(const Keypoints& picture, const RigCamera& camera, const RigCamera& other) {
  const Rigid3 other_from_camera = other.cam_from_world * camera.cam_from_world.inverse();
  std::vector<Line> out(picture.keypoints.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    const std::optional<Vector3d> ray = unproject(camera.model, picture.keypoints[i].pixel);
    if (!ray) continue;
    const Vector3d plane = other_from_camera.translation.cross(other_from_camera.rotation * *ray);
    const double across = plane.head<2>().norm();
    if (across > 0) out[i] = {*ray, plane / across};
  }
  return out;
}

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
  std::vector<SceneMatches> pairs = every_pair(pictures.size());
  parallel_for(pairs.size(), threads, [&](std::size_t p) {
    const auto [a, b, none] = pairs[p];
    pairs[p] =
        match_pair(pictures[at(a)], pictures[at(b)], a, b, [](std::size_t, std::size_t) { return true; });
  });
  return pairs;
}

std::vector<SceneMatches> match_along_lines(std::span<const SceneKeypoints> pictures, const Rig& rig,
                                            double tolerance, int threads) {
  std::vector<SceneMatches> pairs = every_pair(pictures.size());
  parallel_for(pairs.size(), threads, [&](std::size_t p) {
    const int a = pairs[p].a, b = pairs[p].b;
    const RigCamera &one = rig.cameras[at(a)], &other = rig.cameras[at(b)];
    const std::vector<Line> in_other = lines(pictures[at(a)], one, other),
                            in_one = lines(pictures[at(b)], other, one);
    const double near_other = tolerance / other.model.fx, near_one = tolerance / one.model.fx;
    pairs[p] = match_pair(pictures[at(a)], pictures[at(b)], a, b, [&](std::size_t i, std::size_t k) {
      const Line &x = in_other[i], &y = in_one[k];
      if (std::abs(x.line.dot(y.ray)) > near_other || std::abs(y.line.dot(x.ray)) > near_one) return false;
      return x.ray.z() > 0 && y.ray.z() > 0;
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
