// Method:  planes on which shadows agree, by search over planes
// ADR:     0349 (the floor), 0354 (walls)

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/parallel.h"
#include "matting/cast_shadows.h"

namespace floatstage::matting {
namespace {

constexpr std::size_t kAsked = 480;  // pixels in all, where a plane is sought
constexpr float kDeep = 0.8F;        // of the stage: what is lighter is alike on any plane
constexpr double kFound = 0.18;      // of what is deep, on a plane that is none yet
constexpr int kWide = 4;             // px that steps as wide are blurred by

constexpr double kBody = 0.05;  // of how far cameras look: so thick is somebody, to each side

constexpr double kEnough = 0.35;       // of what is deep, at z = 0: no other floor is sought
constexpr double kFloorIsSharp = 0.5;  // of what agrees on it does a body's thickness off it
constexpr double kBetterThere = 1.5;   // times what is at z = 0
constexpr double kTilt = 0.07;         // radians: steps of its tilt,
constexpr int kTilts = 3;              // to each side,
constexpr double kMostTilt = 0.3;
constexpr double kStep = 0.03;                       // and of its height, of how far cameras look,
constexpr double kDeepest = -0.9, kHighest = -0.05;  // from where they look

constexpr std::size_t kMostWalls = 3;             // as many as a corner and a pillar have
constexpr double kNearest = 0.15, kFarthest = 2;  // of how far cameras look, beyond where they look
constexpr double kAway = 0.06, kTurn = 0.1;       // steps: of the same, and radians
constexpr double kUpright = 0.95;                 // cosine: walls lean less, seen from what is up
constexpr std::size_t kCandidates = 6;            // of walls: who is dark agrees on a plane, too
constexpr std::size_t kAskedOfOne = 1920;         // pixels, of a candidate
constexpr double kFlat = 0.85;   // of what agrees within wide windows does within a pixel, on a plane
constexpr double kWindows = 12;  // of a side of what is deep: such windows are wide
constexpr double kCaster = 1;    // of its shadow: so many pixels show who casts it, at least
constexpr double kSharp = 0.9;   // of what agrees on the plane does a body's thickness off it

double looks_off(const Rig& rig) {
  const Eigen::Vector3d focus = focus_point(rig);
  double distance = 0;
  for (const RigCamera& c : rig.cameras) distance += (focus - c.cam_from_world.center()).norm();
  return distance / static_cast<double>(rig.cameras.size());
}

// A plane by three numbers, and the share of what is asked that agrees on it. Floors: two tilts and a height;
// walls: a turn about what is up, a lean, and how far they are beyond where cameras look.
struct Candidate {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  double share = -1;
};

// From steps that wide windows bridge to a sixteenth of them.
template <class Share>
Candidate in_finer_steps(Candidate here, const Eigen::Vector3d& steps, const Share& share_of) {
  for (int reach = kWide / 2, finer = 2; finer <= 16; finer *= 2, reach = 1) {
    here.share = -1;
    for (double had = -2; here.share > had;) {
      had = here.share;
      const Eigen::Vector3d middle = here.at;
      for (int k = 0; k < 27; ++k) {
        const Eigen::Vector3d at =
            middle + Eigen::Vector3d(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1).cwiseProduct(steps) / finer;
        if (const double share = share_of(at, reach); share > here.share) here = {at, share};
      }
    }
  }
  return here;
}

// Somebody who is dark agrees on many walls through himself: of those, one.
std::vector<Candidate> best_unlike(std::vector<Candidate> all) {
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.share > b.share; });
  std::vector<Candidate> best;
  for (const Candidate& c : all) {
    const auto alike = [&](const Candidate& other) {
      return std::abs(c.at.z() - other.at.z()) < 2.5 * kAway &&
             std::abs(std::remainder(c.at.x() - other.at.x(), 2 * std::numbers::pi)) < 4.5 * kTurn;
    };
    if (best.size() < kCandidates && std::none_of(best.begin(), best.end(), alike)) best.push_back(c);
  }
  return best;
}

// So many of them at most, evenly.
template <class Pixel>
std::vector<Pixel> some_of(const std::vector<Pixel>& all, std::size_t count) {
  if (all.size() <= count) return all;
  std::vector<Pixel> some;
  some.reserve(count);
  for (std::size_t k = 0; k < count; ++k) some.push_back(all[k * all.size() / count]);
  return some;
}

}  // namespace

std::vector<CastShadows::Dark> CastShadows::deep(std::span<const ShadedPlane> but_on) const {
  std::vector<Dark> deep;
  for (const std::vector<Dark>& dark : dark_)
    for (const Dark& d : dark) {
      const Share& left = shades_[d.camera].left[d.pixel];
      if (*std::max_element(left.begin(), left.end()) < kDeep &&
          std::none_of(but_on.begin(), but_on.end(),
                       [&](const ShadedPlane& plane) { return is_shadow(d, plane, 1); }))
        deep.push_back(d);
    }
  return deep;
}

// Pixels that are much darker, brighter or of another colour.
std::size_t CastShadows::much_changed() const {
  std::size_t changed = 0;
  for (std::size_t i = 0; i < shades_.size(); ++i)
    for (std::size_t p = 0; p < shades_[i].mask.size(); ++p) {
      const auto [least, most] = std::minmax_element(shades_[i].left[p].begin(), shades_[i].left[p].end());
      changed += noise_[i][p] < kUnsure && (*least < kDeep || *most > 1 / kDeep);
    }
  return changed;
}

double CastShadows::share_on(std::span<const Dark> asked, const ShadedPlane& plane, int reach,
                             int threads) const {
  std::vector<char> yes(asked.size());
  parallel_for(asked.size(), threads, [&](std::size_t i) { yes[i] = is_shadow(asked[i], plane, reach); });
  return static_cast<double>(std::count(yes.begin(), yes.end(), 1)) / static_cast<double>(asked.size());
}

// Over all tilts and heights in steps that wide windows bridge, then around the best in finer ones.
void CastShadows::seek_floor(int threads) {
  const std::vector<Dark> asked = some_of(deep(walls_), kAsked);
  if (asked.size() < kAsked) return;
  const double distance = looks_off(rig_);
  const auto is_there = [&](const ShadedPlane& floor, double share) {
    const auto moved = [&](double by) {
      return share_on(asked, {floor.normal, floor.offset + by * distance}, 1, threads);
    };
    return share >= kFound && std::max(moved(-kBody), moved(kBody)) <= kFloorIsSharp * share;
  };
  const double usual = share_on(asked, floor_, 1, threads);
  found_floor_ = is_there(floor_, usual);
  if (usual >= kEnough) return;
  const Eigen::Vector3d focus = focus_point(rig_);
  double most = 0;
  ShadedPlane best;
  for (const Eigen::Vector3d& up : {Eigen::Vector3d(Eigen::Vector3d::UnitZ()), mean_up(rig_)}) {
    const Eigen::Vector3d across = up.unitOrthogonal(), along = up.cross(across);
    const auto floor_at = [&](const Eigen::Vector3d& at) {
      const Eigen::Vector3d n = (up + at.x() * across + at.y() * along).normalized();
      return ShadedPlane{n, n.dot(focus) + at.z() * distance};
    };
    const auto share_of = [&](const Eigen::Vector3d& at, int reach) {
      if (at.head<2>().norm() > kMostTilt || at.z() > kHighest) return -1.0;
      return share_on(asked, floor_at(at), reach, threads);
    };
    Candidate floor;
    for (int a = -kTilts; a <= kTilts; ++a)
      for (int b = -kTilts; b <= kTilts; ++b)
        for (double h = kDeepest; h <= kHighest; h += kStep) {
          const Eigen::Vector3d at(a * kTilt, b * kTilt, h);
          if (const double share = share_of(at, kWide); share > floor.share) floor = {at, share};
        }
    floor = in_finer_steps(floor, {kTilt, kTilt, kStep}, share_of);
    if (floor.share > most) most = floor.share, best = floor_at(floor.at);
  }
  if (most < kBetterThere * usual || !is_there(best, most)) return;
  floor_ = best;
  found_floor_ = true;
}

// Over all planes behind everybody in steps that wide windows bridge; then the best that are unlike, each in
// finer steps: the best of those that are flat, sharp, and have somebody before them.
std::optional<ShadedPlane> CastShadows::another_wall(int threads) const {
  std::vector<ShadedPlane> known = walls_;
  known.push_back(floor_);
  const std::vector<Dark> all = deep(known), asked = some_of(all, kAsked), of_one = some_of(all, kAskedOfOne);
  if (asked.size() < kAsked) return std::nullopt;
  const double side = std::sqrt(static_cast<double>(all.size()) / static_cast<double>(rig_.cameras.size()));
  const int wide = std::max(kWide, static_cast<int>(side / kWindows));
  const double casting = static_cast<double>(much_changed() - (deep({}).size() - all.size()));
  const Eigen::Vector3d focus = focus_point(rig_);
  const double distance = looks_off(rig_);
  Candidate found;
  ShadedPlane wall;
  std::vector<Eigen::Vector3d> ups = {floor_.normal};
  if (!found_floor_ && mean_up(rig_).dot(floor_.normal) < kUpright) ups.push_back(mean_up(rig_));
  for (const Eigen::Vector3d& up : ups) {
    const Eigen::Vector3d across = up.unitOrthogonal(), along = up.cross(across);
    const auto wall_at = [&](const Eigen::Vector3d& at) {
      const Eigen::Vector3d level = std::cos(at.x()) * across + std::sin(at.x()) * along;
      const Eigen::Vector3d normal = std::cos(at.y()) * level + std::sin(at.y()) * up;
      return ShadedPlane{normal, normal.dot(focus) - at.z() * distance, 2 * (1 + kFarthest)};
    };
    const auto share_at = [&](const Eigen::Vector3d& at, std::span<const Dark> of, int reach) {
      const ShadedPlane here = wall_at(at);
      for (const RigCamera& c : rig_.cameras)
        if (here.normal.dot(c.cam_from_world.center()) <= here.offset) return 0.0;
      return share_on(of, here, reach, threads);
    };
    const auto is_there = [&](const Eigen::Vector3d& at) {
      const auto moved = [&](double by) { return share_at(at + Eigen::Vector3d(0, 0, by), of_one, 1); };
      const double share = moved(0), near = share_at(at, of_one, wide);
      const double shadow = near * static_cast<double>(all.size());
      return share >= kFlat * near && std::max(moved(-kBody), moved(kBody)) <= kSharp * share &&
             casting - shadow >= kCaster * shadow;
    };
    std::vector<Candidate> coarse;
    for (double away = kNearest; away <= kFarthest; away += kAway)
      for (double turn = 0; turn < 2 * std::numbers::pi; turn += kTurn) {
        const Eigen::Vector3d at(turn, 0, away);
        if (const double share = share_at(at, asked, kWide); share >= kFound) coarse.push_back({at, share});
      }
    for (const Candidate& candidate : best_unlike(std::move(coarse))) {
      const Candidate fine =
          in_finer_steps(candidate, {kTurn, kTurn, kAway},
                         [&](const Eigen::Vector3d& at, int reach) { return share_at(at, asked, reach); });
      if (fine.share < kFound || fine.share <= found.share || !is_there(fine.at)) continue;
      found = fine;
      wall = wall_at(fine.at);
    }
  }
  if (found.share < 0) return std::nullopt;
  return wall;
}

void CastShadows::seek(int threads) {
  if (!found_floor_) seek_floor(threads);
  const std::size_t had = walls_.size();
  while (walls_.size() < kMostWalls) {
    const std::optional<ShadedPlane> wall = another_wall(threads);
    if (!wall) break;
    walls_.push_back(*wall);
  }
  if (!found_floor_ && walls_.size() > had) seek_floor(threads);
}

}  // namespace floatstage::matting
