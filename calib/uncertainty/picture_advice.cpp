// Method:  the next picture is the one that lowers the projection's variance over the working volume most
// Paper:   A. Richardson, J. Strom, E. Olson, "AprilCal: assisted and repeatable camera calibration", 2013,
//          section IV
// Differs: the gain is taken from the linearised solution, no picture is simulated; a few cameras at a time
// ADR:     0224

#include "calib/uncertainty/picture_advice.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <numbers>

#include <Eigen/Dense>

#include "calib/solver/projection.h"
#include "calib/solver/scene.h"
#include "core/statistics.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
constexpr double kRadians = std::numbers::pi / 180;
constexpr std::size_t kTogether =
    4;  // cameras whose covariance is followed: one and those it shares most with

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// A camera and those that saw most targets with it; it comes first.
std::vector<int> neighbours(const Calibration& c, int camera) {
  std::vector<std::pair<int, int>> shared;
  for (const CameraLink& l : c.links)
    if (l.a == camera || l.b == camera) shared.emplace_back(-l.frames, l.a == camera ? l.b : l.a);
  std::sort(shared.begin(), shared.end());
  std::vector<int> out{camera};
  for (const auto& [frames, other] : shared)
    if (out.size() < kTogether) out.push_back(other);
  return out;
}

Calibration part_of(const Calibration& c, const std::vector<int>& cameras) {
  Calibration out;
  out.reference = c.reference < 0 ? -1 : 0;
  std::vector<Index> rows;
  for (const int i : cameras) {
    out.rig.cameras.push_back(c.rig.cameras[at(i)]);
    out.cameras.push_back(c.cameras[at(i)]);
    out.scatter.push_back(c.scatter[at(i)]);
    for (Index k = 0; k < kCovarianceRows; ++k) rows.push_back(kCovarianceRows * i + k);
  }
  out.covariance = c.covariance(rows, rows);
  return out;
}

double sigma_of(const Calibration& c, const WorkingVolume& volume) {
  const Measured sigma = projection_sigma(c, ProjectionUncertainty(c, volume.points), 0, volume);
  return sigma ? *sigma : 0;
}

Rigid3 world_from_board(const RigCamera& camera, const PictureToTake& p, const Eigen::Vector3d& middle) {
  const Eigen::Vector2d pixel(p.place.x() * camera.model.width, p.place.y() * camera.model.height);
  const Eigen::Vector3d ray = unproject(camera.model, pixel).value_or(Eigen::Vector3d::UnitZ());
  // Facing the camera: the printed side is the board's -z when it looks along +z.
  const Eigen::Quaterniond tilt =
      Eigen::Quaterniond(Eigen::AngleAxisd(p.turned * kRadians, Eigen::Vector3d::UnitY()) *
                         Eigen::AngleAxisd(p.leaned * kRadians, Eigen::Vector3d::UnitX()));
  return camera.cam_from_world.inverse() * Rigid3{tilt, ray * p.distance - tilt * middle};
}

// What one picture of the board says of the cameras that see it, the board's own place eliminated.
MatrixXd information_of(const Calibration& c, const std::vector<Eigen::Vector3d>& board, const Rigid3& pose) {
  const Index size = c.covariance.rows();
  MatrixXd own = MatrixXd::Zero(size, size), shared = MatrixXd::Zero(size, 6);
  Eigen::Matrix<double, 6, 6> of_board = Eigen::Matrix<double, 6, 6>::Zero();
  for (std::size_t i = 0; i < c.rig.cameras.size(); ++i) {
    const RigCamera& camera = c.rig.cameras[i];
    const double noise = (c.cameras[i].rms_px ? *c.cameras[i].rms_px : 0.3) / std::sqrt(2.0) *
                         (c.scatter[i] ? *c.scatter[i] : 1);
    const double weight = 1 / std::max(noise, 0.01);
    for (const Eigen::Vector3d& p : board) {
      const Eigen::Vector3d x = pose * p, turned = camera.cam_from_world.rotation * x;
      const std::optional<Eigen::Vector2d> pixel = project(camera.model, camera.cam_from_world * x);
      solver::Projected seen;
      if (!pixel || !inside(camera.model, *pixel) ||
          !solver::project(solver::pack(camera.model), static_cast<LensKind>(camera.model.lens.index()),
                           turned + camera.cam_from_world.translation, seen))
        continue;
      Eigen::Matrix<double, 2, kCovarianceRows> by_camera;
      by_camera << seen.by_intrinsics, -seen.by_point * solver::cross_matrix(turned), seen.by_point;
      const Eigen::Matrix<double, 2, 3> by_world =
          seen.by_point * camera.cam_from_world.rotation.toRotationMatrix();
      Eigen::Matrix<double, 2, 6> by_board;
      by_board << -by_world * solver::cross_matrix(pose.rotation * p), by_world;
      by_camera *= weight;
      by_board *= weight;
      const Index row = kCovarianceRows * static_cast<Index>(i);
      own.block<kCovarianceRows, kCovarianceRows>(row, row) += by_camera.transpose() * by_camera;
      shared.middleRows<kCovarianceRows>(row) += by_camera.transpose() * by_board;
      of_board += by_board.transpose() * by_board;
    }
  }
  of_board.diagonal().array() += 1e-9;
  return own - shared * of_board.ldlt().solve(shared.transpose());
}

MatrixXd with(const MatrixXd& covariance, const MatrixXd& information) {
  const MatrixXd known = information * covariance;
  const MatrixXd mixed = MatrixXd::Identity(known.rows(), known.cols()) + known;
  const MatrixXd less = covariance * mixed.partialPivLu().solve(known);
  const MatrixXd out = covariance - less;
  return 0.5 * (out + out.transpose());
}

std::vector<PictureToTake> candidates(const RigCamera& camera, const WorkingVolume& volume) {
  std::vector<double> depths;
  for (const Eigen::Vector3d& x : volume.points) {
    const Eigen::Vector3d in_camera = camera.cam_from_world * x;
    if (const auto pixel = project(camera.model, in_camera); pixel && inside(camera.model, *pixel))
      depths.push_back(in_camera.z());
  }
  std::vector<PictureToTake> out;
  if (depths.empty()) return out;
  constexpr double kTilt = 40;  // beyond 60 corners are no longer found; below 20 little is learnt
  for (const double distance : {percentile(depths, 0.1), percentile(depths, 0.9)})
    for (const double x : {0.2, 0.5, 0.8})
      for (const double y : {0.2, 0.5, 0.8})
        for (const auto& [turned, leaned] :
             {std::pair{0.0, 0.0}, std::pair{kTilt, 0.0}, std::pair{-kTilt, 0.0}, std::pair{0.0, kTilt},
              std::pair{0.0, -kTilt}})
          out.push_back({{x, y}, distance, turned, leaned});
  return out;
}

std::string words(const PictureToTake& p) {
  const char* const down[] = {"upper ", "", "lower "};
  const char* const across[] = {"left", "middle", "right"};
  const std::string place = text(down[p.place.y() < 0.4   ? 0
                                      : p.place.y() < 0.6 ? 1
                                                          : 2],
                                 across[p.place.x() < 0.4   ? 0
                                        : p.place.x() < 0.6 ? 1
                                                            : 2]);
  const std::string tilt = p.turned != 0 ? text("turned by ", std::abs(p.turned), "° about its upright, the ",
                                                p.turned > 0 ? "left" : "right", " edge nearer")
                           : p.leaned != 0 ? text("leaned by ", std::abs(p.leaned), "°, the ",
                                                  p.leaned > 0 ? "lower" : "upper", " edge nearer")
                                           : std::string("facing it");
  return text("at the ", place, " of its picture, ", std::fixed, std::setprecision(2), p.distance,
              " m away, ", std::setprecision(0), tilt);
}

PictureAdvice advise_camera(const Calibration& whole, int camera, const Target& target,
                            const WorkingVolume& volume, double bar_px) {
  Calibration c = part_of(whole, neighbours(whole, camera));
  std::vector<Eigen::Vector3d> board;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const TargetPoint& p : target.points)
    if (p.normal.isZero() || p.normal.isApprox(target.points[0].normal)) board.push_back(p.position);
  for (const Eigen::Vector3d& p : board) middle += p / static_cast<double>(board.size());
  PictureAdvice out{c.rig.cameras[0].serial, sigma_of(c, volume), 0, {}, ""};
  out.then_px = out.now_px;
  const std::vector<PictureToTake> possible = candidates(c.rig.cameras[0], volume);
  std::vector<MatrixXd> says;
  for (const PictureToTake& p : possible)
    says.push_back(information_of(c, board, world_from_board(c.rig.cameras[0], p, middle)));
  constexpr std::size_t kMost = 10;
  while (out.pictures.size() < kMost && out.then_px > bar_px && !possible.empty()) {
    std::size_t best = 0;
    double least = out.then_px;
    MatrixXd kept;
    Calibration trial = c;
    for (std::size_t i = 0; i < possible.size(); ++i) {
      trial.covariance = with(c.covariance, says[i]);
      const double sigma = sigma_of(trial, volume);
      if (!(sigma < least)) continue;
      least = sigma;
      best = i;
      kept = trial.covariance;
    }
    if (kept.size() == 0) break;
    c.covariance = kept;
    out.then_px = least;
    out.pictures.push_back(possible[best]);
  }
  std::string list;
  for (const PictureToTake& p : out.pictures) list += text("\n    ", words(p));
  out.sentence = text("camera '", out.camera, "': ", std::fixed, std::setprecision(2), out.now_px,
                      " px of projection sigma, the bar is ", bar_px, "; ", out.pictures.size(),
                      " more pictures bring it to about ", out.then_px, " px. Show the board", list);
  return out;
}

}  // namespace

std::vector<PictureAdvice> pictures_to_add(const Calibration& c, const Observations& o,
                                           const WorkingVolume& volume, double bar_px) {
  const auto target = std::find_if(o.targets.begin(), o.targets.end(), [](const Target& t) {
    return t.kind == TargetKind::Board && !t.points.empty();
  });
  std::vector<PictureAdvice> out;
  if (target == o.targets.end() || c.rig.cameras.empty() || volume.points.empty()) return out;
  const ProjectionUncertainty uncertainty(c, volume.points);
  std::vector<std::pair<double, int>> failing;
  for (int i = 0; i < static_cast<int>(c.rig.cameras.size()); ++i)
    if (const Measured sigma = projection_sigma(c, uncertainty, i, volume); sigma && *sigma > bar_px)
      failing.emplace_back(-*sigma, i);
  std::sort(failing.begin(), failing.end());
  for (std::size_t i = 0; i < std::min<std::size_t>(3, failing.size()); ++i)
    out.push_back(advise_camera(c, failing[i].second, *target, volume, bar_px));
  return out;
}

}  // namespace floatstage::calib
