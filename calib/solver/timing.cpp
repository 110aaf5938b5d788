// Method:  when pictures were taken and how far hands stray from
//          smooth motion, as variance components
// Paper:   W. Förstner's estimate of variance components
// Differs: each picture has an instant of its own; a view goes to the frame nearest to it
// ADR:     0113, 0121

#include "calib/solver/timing.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <Eigen/Cholesky>

#include "calib/solver/linearize.h"

namespace floatstage::calib::solver {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

struct Moments {
  double squares = 0;
  int count = 0;
};

// Half a hundredth of a period is nothing that anybody could tell from no jitter at all.
constexpr double kLeastJitter = 0.005;  // periods

}  // namespace

int regroup(Scene& scene) {
  if (!(scene.period > 0)) return 0;
  std::map<int, std::map<double, int>> by_time;  // target → time → board
  for (std::size_t b = 0; b < scene.boards.size(); ++b)
    if (!scene.targets[at(scene.boards[b].target)].is_static)
      by_time[scene.boards[b].target].emplace(scene.boards[b].time, static_cast<int>(b));
  int changed = 0;
  for (SceneView& v : scene.views) {
    if (v.board < 0 || scene.targets[at(scene.boards[at(v.board)].target)].is_static) continue;
    const SceneBoard& old = scene.boards[at(v.board)];
    const double taken = old.time + v.lag, instant = taken + scene.cameras[at(v.camera)].offset;
    const auto distance = [&](const std::pair<const double, int>& t) { return std::abs(t.first - instant); };
    const std::map<double, int>& times = by_time.at(old.target);
    auto nearest = times.lower_bound(instant);
    if (nearest == times.end() ||
        (nearest != times.begin() && distance(*std::prev(nearest)) < distance(*nearest)))
      --nearest;
    // Not back and forth for what lies in the middle.
    constexpr double kClearly = 0.05;  // periods
    if (nearest->second == v.board ||
        distance(*nearest) > std::abs(old.time - instant) - kClearly * scene.period)
      continue;
    v.board = nearest->second;
    v.lag = taken - nearest->first;
    ++changed;
  }
  if (changed == 0) return 0;
  std::vector<bool> seen(scene.boards.size());
  for (const SceneView& v : scene.views)
    if (v.board >= 0) seen[at(v.board)] = true;
  for (std::size_t b = 0; b < seen.size(); ++b)
    if (!seen[b]) scene.boards[b].placed = false;
  return changed;
}

void estimate_jitter(Scene& scene) {
  if (!(scene.jitter_sigma > 0)) return;
  for (SceneView& v : scene.views) {
    if (v.board < 0 || !usable(scene, v)) continue;
    LinearView linear;
    for (int i = 0; i < 2; ++i) {  // twice: the first may come from far off
      linearize(scene, v, {}, true, linear);
      if (linear.valid) v.jitter = linear.jitter;
    }
  }
}

void measure_timing(Scene& scene) {
  estimate_jitter(scene);
  const double was = scene.jitter_sigma;
  Moments jitter, spin, velocity;
  std::vector<Eigen::MatrixXd> information(scene.boards.size());
  for (std::size_t b = 0; b < scene.boards.size(); ++b) {
    const SceneBoard& board = scene.boards[b];
    if (!board.placed || !board.free_motion) continue;
    information[b] = Eigen::MatrixXd::Zero(12, 12);
    information[b].diagonal().tail<6>() = motion_weights(board).cwiseAbs2();
  }
  for (const SceneView& v : scene.views) {
    if (v.board < 0 || !usable(scene, v) || !scene.boards[at(v.board)].has_motion) continue;
    LinearView linear;
    linearize(scene, v, {}, true, linear);
    if (!linear.valid) continue;
    constexpr double kSaysSomething = 0.999;
    if (was > 0 && linear.jitter_sigma < kSaysSomething * was) {
      jitter.squares += v.jitter * v.jitter + linear.jitter_sigma * linear.jitter_sigma;
      ++jitter.count;
    }
    if (linear.by_object.cols() == 12)
      information[at(v.board)] += linear.by_object.transpose() * linear.by_object;
  }
  constexpr int kFewest = 10;  // boards or views: fewer say nothing of how it usually is
  if (jitter.count >= kFewest)
    scene.jitter_sigma = std::max(kLeastJitter * scene.period, std::sqrt(jitter.squares / jitter.count));

  for (std::size_t b = 0; b < scene.boards.size(); ++b) {
    const SceneBoard& board = scene.boards[b];
    if (information[b].size() == 0 || !board.has_neighbours) continue;
    const Eigen::MatrixXd covariance = information[b].ldlt().solve(Eigen::MatrixXd::Identity(12, 12));
    const Eigen::VectorXd variance = covariance.diagonal();
    spin.squares += (board.spin - board.likely_spin).squaredNorm() + variance.segment<3>(6).sum();
    velocity.squares += (board.velocity - board.likely_velocity).squaredNorm() + variance.segment<3>(9).sum();
    spin.count += 3;
    velocity.count += 3;
  }
  if (spin.count < 3 * kFewest) return;
  // Never so small that the motion of neighbours is taken for exact, never more than a hand does.
  scene.spin_doubt = std::clamp(std::sqrt(spin.squares / spin.count), 0.01 * kSpinDoubt, kSpinDoubt);
  scene.velocity_doubt =
      std::clamp(std::sqrt(velocity.squares / velocity.count), 0.01 * kVelocityDoubt, kVelocityDoubt);
}

}  // namespace floatstage::calib::solver
