#include "calib/calibrate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iomanip>
#include <numbers>

#include "calib/solver/covariance.h"
#include "calib/solver/failures.h"
#include "calib/solver/frame_scatter.h"
#include "calib/solver/gauge.h"
#include "calib/solver/holdout.h"
#include "calib/solver/quality.h"
#include "calib/solver/stages.h"
#include "calib/solver/start.h"
#include "calib/uncertainty/working_volume.h"
#include "core/parallel.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

using solver::Scene;

Result<void> check_options(const CalibrationOptions& o) {
  if (!(o.outlier_sigmas >= 2) || o.holdout_every < 0 || o.threads < 0)
    return fail(
        ErrorCode::InvalidArgument,
        "calibration options: outliers begin at 2 sigmas or more, frames are held out every 0 or more, and "
        "threads are 0 or more");
  if (o.ring != 0 && !(o.ring >= 1e-5 && o.ring <= 0.3))
    return fail(ErrorCode::InvalidArgument,
                "calibration options: a ring is held within 0.00001 to 0.3 of its radius, or not at all (0)");
  return {};
}

Result<void> find_intrinsics(Scene& scene, int threads) {
  std::vector<Result<void>> results(scene.cameras.size());
  parallel_for(scene.cameras.size(), threads, [&](std::size_t c) {
    if (!scene.cameras[c].has_intrinsics) results[c] = solver::start_intrinsics(scene, static_cast<int>(c));
  });
  for (const Result<void>& r : results)
    if (!r) return r;
  return {};
}

// How far cameras are from where they are said to have been.
void compare_to_start(const Scene& scene, const Observations& o, Calibration& out) {
  for (std::size_t c = 0; c < o.cameras.size(); ++c) {
    if (o.cameras[c].pose != Prior::Start) continue;
    const Rigid3 &was = o.cameras[c].cam_from_world, &is = scene.cameras[c].cam_from_world;
    CameraQuality& q = out.cameras[c];
    q.moved_mm = 1e3 * (was.center() - is.center()).norm();
    q.turned_degrees = solver::angle_between(was.rotation, is.rotation) * 180 / std::numbers::pi;
    constexpr double kTurned = 0.1, kMoved = 3;  // degrees, mm
    if (*q.turned_degrees > kTurned || *q.moved_mm > kMoved)
      out.remarks.push_back(text("camera '", q.serial, "' has moved since its given pose: by ", std::fixed,
                                 std::setprecision(1), *q.moved_mm, " mm, turned by ", std::setprecision(2),
                                 *q.turned_degrees, "°"));
  }
}

// The public covariance lacks the rows of the time offsets.
std::vector<Eigen::Index> rows_without_offsets(std::size_t cameras) {
  std::vector<Eigen::Index> rows;
  for (std::size_t c = 0; c < cameras; ++c)
    for (int k = 0; k < kCovarianceRows; ++k)
      rows.push_back(solver::kCameraParameters * static_cast<Eigen::Index>(c) + k);
  return rows;
}

Eigen::MatrixXd without_offsets(const Eigen::MatrixXd& m, std::size_t cameras) {
  const std::vector<Eigen::Index> rows = rows_without_offsets(cameras);
  return m(rows, rows);
}

// The scene's cameras as they are now.
void take_cameras(const Scene& scene, const Observations& observations, Calibration& out) {
  out.reference = scene.reference;
  out.rig.cameras.clear();
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    const solver::SceneCamera& from = scene.cameras[c];
    CameraModel model = solver::unpack(from.intrinsics, from.lens, from.width, from.height);
    if (from.intrinsics_fixed) model = observations.cameras[c].model;
    out.rig.cameras.push_back({from.serial, model, from.cam_from_world, {}});
  }
  out.errors = solver::point_errors(scene, observations);
}

Eigen::MatrixXd with_offsets(const Eigen::MatrixXd& m, std::size_t cameras) {
  const Eigen::Index size = solver::kCameraParameters * static_cast<Eigen::Index>(cameras);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(size, size);
  const std::vector<Eigen::Index> rows = rows_without_offsets(cameras);
  out(rows, rows) = m;
  return out;
}

// How much more than its points' noise says the solution moves when frames are left out, by where the cameras
// see the targets' volume; the covariance grows by that. The blocks of one capture do not say in which
// direction, only how much: one number for all cameras.
std::vector<Measured> enlarge_by_scatter(const Scene& scene, const Observations& observations,
                                         const solver::BundleOptions& used, Eigen::MatrixXd& covariance) {
  const std::size_t count = scene.cameras.size();
  Calibration by_noise;
  take_cameras(scene, observations, by_noise);
  by_noise.covariance = without_offsets(covariance, count);
  const Eigen::MatrixXd metric = projection_metric(by_noise, hull_of_targets(by_noise));
  const solver::FrameScatter seen = solver::frame_scatter(scene, used, with_offsets(metric, count));
  if (seen.blocks == 0)
    return std::vector<Measured>(
        count, Measured::not_measured(text("fewer than ", solver::kFewestBlocks, " frames show what moves")));
  const double factor = std::max(1.0, seen.sigma_factor());
  covariance *= factor * factor;
  return std::vector<Measured>(count, Measured(factor, seen.blocks));
}

}  // namespace

const char* name_of(CalibrationFailure failure) {
  switch (failure) {
    case CalibrationFailure::ConstantDepth:
      return "constant-depth";
    case CalibrationFailure::PlanarMotion:
      return "planar-motion";
    case CalibrationFailure::SwappedRowsColumns:
      return "swapped-rows-columns";
    case CalibrationFailure::WrongSquareSize:
      return "wrong-square-size";
    case CalibrationFailure::MirroredBoard:
      return "mirrored-board";
    case CalibrationFailure::LateCamera:
      return "late-camera";
  }
  return "unknown";
}

Result<Calibration> calibrate(const Observations& observations, const CalibrationOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  if (Result<void> ok = check_options(options); !ok) return forward(ok);
  if (Result<void> ok = check(observations); !ok) return forward(ok);
  if (observations.cameras.empty()) return fail(ErrorCode::BadData, "there is no camera to calibrate");
  if (observations.views.empty())
    return fail(ErrorCode::BadData,
                "no picture of any camera shows a target; see the reasons that detection gave");

  Scene scene = solver::make_scene(observations);
  scene.ring = options.ring;
  Calibration out;
  out.failures = solver::wrong_layouts(scene);
  if (!out.failures.empty()) return out;  // nothing that follows would mean anything
  if (Result<void> ok = find_intrinsics(scene, options.threads); !ok) return forward(ok);
  const Result<std::vector<solver::CameraPair>> pairs = solver::start_poses(scene, options.threads);
  if (!pairs) return forward(pairs);
  for (const solver::CameraPair& p : *pairs) out.links.push_back({p.a, p.b, p.frames, p.points, p.in_tree});

  solver::select_inliers(scene, 1e12);  // what lies behind a camera at the start takes no part
  const solver::BundleOptions used = solver::solve_in_stages(scene, options);
  const std::vector<Measured> holdout = solver::holdout_errors(scene, observations, options);
  out.failures = solver::late_cameras(scene, options);

  Eigen::MatrixXd covariance = solver::camera_covariance(scene, used);
  out.scatter = enlarge_by_scatter(scene, observations, used, covariance);
  if (Result<void> ok = solver::set_gauge(scene, observations, covariance, out.remarks); !ok)
    return forward(ok);
  take_cameras(scene, observations, out);
  out.jitter_ms = options.time_offsets && scene.jitter_sigma > 0
                      ? Measured(1e3 * scene.jitter_sigma, static_cast<long>(scene.views.size()))
                      : Measured::not_measured("time offsets were not solved for");
  out.cameras = solver::camera_qualities(scene, out.errors, covariance);
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) out.cameras[c].holdout_px = holdout[c];
  out.lengths = solver::measure_lengths(scene);
  out.scale = solver::merged(out.lengths);
  for (NamedFailure& f : solver::weak_geometry(scene, out.cameras, out.lengths, options))
    out.failures.push_back(std::move(f));
  compare_to_start(scene, observations, out);
  for (const solver::SceneBoard& b : scene.boards)
    if (b.placed) out.places.push_back({b.target, b.frame, b.world_from_target});
  out.covariance = without_offsets(covariance, scene.cameras.size());
  if (Result<void> ok = check(out.rig); !ok)
    return fail(ErrorCode::BadData, text("the capture does not determine the cameras: ", ok.error().message,
                                         "; record it again with the board in more places"));
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace floatstage::calib
