// Method:  cameras whose errors follow the targets' motion,
//          solved again with time offsets
// Paper:   none
// Differs: named only where that explains the errors; of two cameras the later one is late
// ADR:     0113, 0155

#include <algorithm>
#include <cmath>
#include <iomanip>

#include "calib/solver/failures.h"
#include "calib/solver/linearize.h"
#include "calib/solver/stages.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib::solver {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// The offset (s) that would most reduce each camera's errors if nothing else changed.
std::vector<double> suspected_offsets(const Scene& scene) {
  std::vector<double> along(scene.cameras.size()), square(scene.cameras.size());
  for (const SceneView& v : scene.views) {
    if (!usable(scene, v)) continue;
    LinearView linear;
    linearize(scene, v, {3}, true, linear);
    if (!linear.valid) continue;
    along[at(v.camera)] += linear.by_offset.dot(linear.residual);
    square[at(v.camera)] += linear.by_offset.squaredNorm();
  }
  std::vector<double> out;
  for (std::size_t c = 0; c < along.size(); ++c) out.push_back(square[c] > 0 ? -along[c] / square[c] : 0);
  return out;
}

std::vector<double> offsets_of(const Scene& scene) {
  std::vector<double> out;
  for (const SceneCamera& c : scene.cameras) out.push_back(c.offset);
  return out;
}

double cost_of(const Scene& scene) {
  double sum = 0;
  for (const SceneView& v : scene.views)
    if (usable(scene, v))
      for (const Eigen::Vector2d& e : errors_of(scene, v)) sum += std::log1p(std::min(e.squaredNorm(), 1e6));
  return sum;
}

}  // namespace

std::vector<NamedFailure> late_cameras(const Scene& scene, const CalibrationOptions& options) {
  if (options.time_offsets || !(scene.period > 0) || scene.cameras.size() < 2) return {};
  Scene moving = scene;
  for (SceneView& v : moving.views) v.lag = 0;
  for (SceneView& v : moving.views)
    for (ScenePoint& p : v.points) p.kept = true;
  select_inliers(moving, 1e12);
  estimate_motion(moving);
  const std::vector<double> suspected = suspected_offsets(moving);
  constexpr double kSuspicious = 0.12;  // of a frame: the boards have followed a late camera part of the way
  if (std::none_of(suspected.begin(), suspected.end(),
                   [&](double s) { return std::abs(s) > kSuspicious * scene.period; }))
    return {};

  const double before = cost_of(moving);
  // A late camera's intrinsics have bent to its errors; all is solved again, while the motion and the noise
  // follow.
  BundleOptions bundle{.loss = {3}, .offsets = true, .iterations = 8, .threads = options.threads};
  constexpr int kRounds = 12;
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<double> last = offsets_of(moving);
    solve(moving, bundle);
    estimate_motion(moving);
    measure_noise(moving, bundle);
    double change = 0;
    for (std::size_t c = 0; c < last.size(); ++c)
      change = std::max(change, std::abs(moving.cameras[c].offset - last[c]));
    if (change < 0.01 * scene.period) break;
  }
  constexpr double kConvincing = 0.9;  // of the errors' cost before
  if (!(cost_of(moving) < kConvincing * before)) return {};
  // Pictures that show an earlier instant than their frame's came late. Of two cameras the later one is late.
  std::vector<double> lateness;
  for (const double offset : offsets_of(moving)) lateness.push_back(-offset);
  const double usual = median(std::move(lateness));
  std::vector<NamedFailure> out;
  for (const SceneCamera& c : moving.cameras) {
    const double frames = (-c.offset - usual) / scene.period;
    if (std::abs(frames) < options.late_frames) continue;
    out.push_back({CalibrationFailure::LateCamera, c.serial,
                   text("camera '", c.serial, "' is ", std::fixed, std::setprecision(2), std::abs(frames),
                        " frames ", frames > 0 ? "late" : "early",
                        ": its errors follow the target's motion; repair its synchronisation (or, for a "
                        "steady lag, let the session solve for "
                        "time offsets) and record again")});
  }
  return out;
}

}  // namespace floatstage::calib::solver
