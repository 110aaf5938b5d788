#include "tests/calib/halves.h"

#include <cmath>
#include <set>

#include <Eigen/Dense>

#include "calib/solver/scene.h"
#include "calib/uncertainty/working_volume.h"
#include "core/random.h"

namespace floatstage::calib {
namespace {

struct Half {
  Calibration solved;
  Rigid3 from_whole;  // into its world
};

Rigid3 moved(const Eigen::Matrix<double, 6, 1>& twist) {
  return {solver::rotation_from_vector(twist.head<3>()), twist.tail<3>()};
}

// b's world moved so that both halves see the volume in the same pixels, as nearly as a motion can do it.
void align(const Half& a, Half& b, const std::vector<Eigen::Vector3d>& volume) {
  const auto pixel = [](const Half& h, std::size_t c, const Eigen::Vector3d& in_own) {
    const RigCamera& rc = h.solved.rig.cameras[c];
    return project(rc.model, rc.cam_from_world * in_own);
  };
  for (int round = 0; round < 4; ++round) {
    Eigen::Matrix<double, 6, 6> normal = Eigen::Matrix<double, 6, 6>::Identity() * 1e-9;
    Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
    for (std::size_t c = 0; c < a.solved.rig.cameras.size(); ++c)
      for (const Eigen::Vector3d& x : volume) {
        const Eigen::Vector3d in_b = b.from_whole * x;
        const auto pa = pixel(a, c, a.from_whole * x), pb = pixel(b, c, in_b);
        if (!pa || !pb || !inside(a.solved.rig.cameras[c].model, *pa)) continue;
        Eigen::Matrix<double, 2, 6> j;
        bool good = true;
        for (int k = 0; k < 6; ++k) {
          constexpr double kStep = 1e-6;
          const auto p = pixel(b, c, moved(kStep * Eigen::Matrix<double, 6, 1>::Unit(k)) * in_b);
          good = good && p;
          if (p) j.col(k) = (*p - *pb) / kStep;
        }
        if (!good) continue;
        normal += j.transpose() * j;
        right += j.transpose() * (*pa - *pb);
      }
    b.from_whole = moved(normal.ldlt().solve(right)) * b.from_whole;
  }
}

}  // namespace

std::vector<int> frames_of(const Observations& all) {
  std::set<int> frames;
  for (const TargetView& v : all.views) frames.insert(v.frame);
  return {frames.begin(), frames.end()};
}

Observations only_frames(const Observations& all, const std::vector<int>& frames) {
  Observations out = all;
  const std::set<int> wanted(frames.begin(), frames.end());
  std::erase_if(out.views, [&](const TargetView& v) { return !wanted.contains(v.frame); });
  return out;
}

Observations only_camera(const Observations& all, int camera) {
  Observations out = all;
  out.cameras = {all.cameras[static_cast<std::size_t>(camera)]};
  std::erase_if(out.views, [&](const TargetView& v) { return v.camera != camera; });
  for (TargetView& v : out.views) v.camera = 0;
  return out;
}

HalvesRatio halves_ratio(const Observations& all, int splits, int blocks, std::uint64_t seed,
                         bool time_offsets) {
  const Result<Calibration> whole = calibrate(all, {.time_offsets = time_offsets, .holdout_every = 0});
  HalvesRatio out;
  if (!whole) return out;
  const WorkingVolume volume = hull_of_targets(*whole);
  const std::vector<int> frames = frames_of(all);
  Random random(seed);
  double apart = 0, stated = 0;
  long count = 0;
  for (int split = 0; split < splits; ++split) {
    std::vector<int> order(static_cast<std::size_t>(blocks));
    for (int i = 0; i < blocks; ++i) order[static_cast<std::size_t>(i)] = i;
    for (std::size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[static_cast<std::size_t>(random.uniform() * static_cast<double>(i))]);
    const std::set<int> first(order.begin(), order.begin() + blocks / 2);
    std::vector<int> of[2];
    for (std::size_t i = 0; i < frames.size(); ++i)
      of[first.contains(static_cast<int>(i * static_cast<std::size_t>(blocks) / frames.size())) ? 0 : 1]
          .push_back(frames[i]);
    Half halves[2];
    bool good = true;
    for (int h = 0; h < 2; ++h) {
      Result<Calibration> solved =
          calibrate(only_frames(all, of[h]), {.time_offsets = time_offsets, .holdout_every = 0});
      good = good && solved && solved->rig.cameras.size() == all.cameras.size();
      if (!good) break;
      halves[h].solved = *std::move(solved);
      halves[h].from_whole =
          halves[h].solved.rig.cameras[0].cam_from_world.inverse() * whole->rig.cameras[0].cam_from_world;
    }
    if (!good) continue;
    ++out.splits;
    if (whole->reference >= 0)
      align(halves[0], halves[1], volume.points);
    else  // the world is given
      halves[0].from_whole = halves[1].from_whole = Rigid3{};
    std::vector<Eigen::Vector3d> in[2];
    for (int h = 0; h < 2; ++h)
      for (const Eigen::Vector3d& x : volume.points) in[h].push_back(halves[h].from_whole * x);
    const ProjectionUncertainty a(halves[0].solved, in[0]), b(halves[1].solved, in[1]);
    for (int c = 0; c < static_cast<int>(all.cameras.size()); ++c)
      for (std::size_t i = 0; i < volume.points.size(); ++i) {
        const RigCamera &ca = halves[0].solved.rig.cameras[static_cast<std::size_t>(c)],
                        &cb = halves[1].solved.rig.cameras[static_cast<std::size_t>(c)];
        const auto pa = project(ca.model, ca.cam_from_world * in[0][i]),
                   pb = project(cb.model, cb.cam_from_world * in[1][i]);
        if (!pa || !pb || !inside(ca.model, *pa)) continue;
        apart += 0.5 * (*pa - *pb).squaredNorm();
        stated += std::pow(a.sigma_px(c, in[0][i]), 2) + std::pow(b.sigma_px(c, in[1][i]), 2);
        ++count;
      }
  }
  if (count == 0) return out;
  out.apart_px = std::sqrt(apart / static_cast<double>(count));
  out.stated_px = std::sqrt(stated / static_cast<double>(count));
  out.ratio = out.apart_px / out.stated_px;
  return out;
}

}  // namespace floatstage::calib
