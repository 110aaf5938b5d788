#include "tests/calib/synthetic_capture.h"

#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "core/text.h"

namespace floatstage::calib {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kRadians = std::numbers::pi / 180;

RigCamera camera(int index, const Vector3d& eye, const Vector3d& at, double focal, const Lens& lens,
                 int width = 1280, int height = 960) {
  RigCamera c;
  c.serial = text("cam", index);
  c.model = {.width = width,
             .height = height,
             .fx = focal,
             .fy = focal * 1.002,
             .cx = 0.5 * width + 7.3 + index,
             .cy = 0.5 * height - 4.1 + index,
             .lens = lens};
  c.cam_from_world = look_at(eye, at, {0, 0, 1});
  return c;
}

BrownConrady usual_lens(int i) {
  return {.k1 = -0.12 + 0.004 * i, .k2 = 0.06 - 0.002 * i, .p1 = 2e-4, .p2 = -3e-4, .k3 = -0.004};
}

bool sees(const RigCamera& c, const TargetPoint& p, const Rigid3& world_from_target, double steepest,
          Eigen::Vector2d& pixel) {
  const Rigid3 cam_from_target = c.cam_from_world * world_from_target;
  const Vector3d x = cam_from_target * p.position;
  if (!p.normal.isZero() &&
      -(cam_from_target.rotation * p.normal).dot(x.normalized()) < std::cos(steepest * kRadians))
    return false;
  const std::optional<Eigen::Vector2d> seen = project(c.model, x);
  if (!seen || !inside(c.model, *seen)) return false;
  pixel = *seen;
  return true;
}

}  // namespace

Target grid_board(int columns, int rows, double pitch) {
  Target t;
  t.name = "board";
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      t.points.push_back({r * columns + c, {pitch * c, pitch * r, 0}, {0, 0, -1}});
  t.grid = TargetGrid{columns, rows, pitch};
  return t;
}

Target two_sided_board(int columns, int rows, double pitch, double thickness) {
  Target t = grid_board(columns, rows, pitch);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      t.points.push_back(
          {1000 + r * columns + c, {pitch * (columns - 1 - c), pitch * r, thickness}, {0, 0, 1}});
  return t;
}

Target wand(const std::vector<double>& places, double sigma) {
  Target t;
  t.name = "wand";
  t.kind = TargetKind::Wand;
  for (std::size_t i = 0; i < places.size(); ++i)
    t.points.push_back({static_cast<int>(i), {places[i], 0, 0}, Vector3d::Zero()});
  for (std::size_t i = 0; i + 1 < places.size(); ++i)
    t.lengths.push_back({static_cast<int>(i), static_cast<int>(i) + 1, places[i + 1] - places[i], sigma});
  return t;
}

Rig ring_rig(int cameras, double radius, double height) {
  Rig rig;
  for (int i = 0; i < cameras; ++i) {
    const double a = 2 * std::numbers::pi * i / cameras;
    rig.cameras.push_back(camera(i, {radius * std::cos(a), radius * std::sin(a), height + 0.3 * (i % 2)},
                                 {0, 0, 1}, 1150 + 20 * i, usual_lens(i)));
  }
  return rig;
}

Rig facing_rig() {
  Rig rig;
  for (int i = 0; i < 8; ++i) {
    const double side = i < 4 ? 1 : -1, y = 0.9 * (i % 4 - 1.5);
    rig.cameras.push_back(
        camera(i, {3 * side, y, 1.2 + 0.4 * (i % 2)}, {0, 0.2 * y, 1}, 1150 + 20 * i, usual_lens(i)));
  }
  return rig;
}

Rig mixed_rig() {
  Rig rig;
  for (int i = 0; i < 3; ++i)
    rig.cameras.push_back(camera(i, {1.6 * std::cos(0.6 * (i - 1)), 1.6 * std::sin(0.6 * (i - 1)), 1.3},
                                 {0, 0, 1}, 420 + 5 * i,
                                 KannalaBrandt{-0.01 - 0.002 * i, 0.004, -0.002, 0.0003}));
  rig.cameras.push_back(camera(3, {6, 0.5, 1.5}, {0, 0, 1}, 3800, BrownConrady{.k1 = 0.05, .k2 = -0.1}));
  return rig;
}

Rig dome_rig(int cameras) {
  Rig rig;
  for (int i = 0; i < cameras; ++i) {  // a spiral from the floor to the top
    const double up = 0.1 + 0.8 * i / cameras, a = 2.4 * i, level = std::sqrt(1 - up * up);
    rig.cameras.push_back(camera(i, {3 * level * std::cos(a), 3 * level * std::sin(a), 0.4 + 3 * up},
                                 {0, 0, 1}, 1150 + 10 * i, usual_lens(i % 8)));
  }
  return rig;
}

Path wandering(const CaptureOptions& options, double speed) {
  Random random(options.seed * 7919 + 17);
  std::vector<double> phases;
  for (int i = 0; i < 8; ++i) phases.push_back(random.uniform(0, 2 * std::numbers::pi));
  const Vector3d center = options.center;
  const double extent = options.extent;
  return [=](double seconds) {
    // Incommensurable frequencies: the path never returns.
    const double t = speed * seconds;
    const Vector3d place =
        center + extent * Vector3d(std::sin(1.31 * t + phases[0]), std::sin(1.73 * t + phases[1]),
                                   std::sin(1.13 * t + phases[2]));
    const Eigen::Quaterniond face(
        Eigen::AngleAxisd(0.9 * t + phases[3], Vector3d::UnitZ()) *
        Eigen::AngleAxisd(std::numbers::pi / 2 + 0.6 * std::sin(1.57 * t + phases[4]), Vector3d::UnitX()) *
        Eigen::AngleAxisd(0.5 * std::sin(2.1 * t + phases[5]), Vector3d::UnitY()) *
        Eigen::AngleAxisd(0.7 * std::sin(0.77 * t + phases[6]), Vector3d::UnitZ()));
    return Rigid3{face, place};
  };
}

void capture_more(Observations& seen, const Rig& truth, const Target& target, const Path& path,
                  const CaptureOptions& options) {
  Random random(options.seed);
  const auto index = static_cast<int>(seen.targets.size());
  seen.targets.push_back(target);
  Vector3d middle = Vector3d::Zero();
  for (const TargetPoint& p : target.points) middle += p.position / static_cast<double>(target.points.size());
  int first = 0;
  for (const TargetView& v : seen.views) first = std::max(first, v.frame + 100);
  for (int f = 0; f < options.frames; ++f)
    for (std::size_t c = 0; c < truth.cameras.size(); ++c) {
      const double shown = static_cast<int>(c) == options.late_camera ? f - options.late_frames : f;
      const double jitter = options.jitter_seconds > 0 ? options.jitter_seconds * random.normal() : 0;
      Rigid3 pose = path(shown * options.frame_seconds + jitter);
      pose.translation -= pose.rotation * middle;
      TargetView view{static_cast<int>(c),
                      index,
                      first + f,
                      {static_cast<std::int64_t>((first + f) * options.frame_seconds * 1e9)},
                      {}};
      for (const TargetPoint& p : target.points) {
        Eigen::Vector2d pixel;
        if (!sees(truth.cameras[c], p, pose, options.steepest_degrees, pixel)) continue;
        pixel += options.noise_px * Eigen::Vector2d(random.normal(), random.normal());
        if (random.uniform() < options.outliers) {
          const double angle = random.uniform(0, 2 * std::numbers::pi);
          pixel += random.uniform(5, 60) * Eigen::Vector2d(std::cos(angle), std::sin(angle));
        }
        view.points.push_back({p.id, pixel, std::max(options.noise_px, 0.01)});
      }
      if (view.points.size() >= (target.kind == TargetKind::Board ? 6u : 1u))
        seen.views.push_back(std::move(view));
    }
}

Observations capture(const Rig& truth, const Target& target, const Path& path,
                     const CaptureOptions& options) {
  Observations seen;
  for (const RigCamera& c : truth.cameras) {
    CalibrationCamera camera;
    camera.serial = c.serial;
    camera.width = c.model.width;
    camera.height = c.model.height;
    camera.lens = static_cast<LensKind>(c.model.lens.index());
    seen.cameras.push_back(camera);
  }
  capture_more(seen, truth, target, path, options);
  return seen;
}

TruthErrors compare(const Rig& solved, const Rig& truth, const CaptureOptions& options) {
  Random random(options.seed + 4711);
  std::vector<Vector3d> wanted, found;
  while (wanted.size() < 1000) {
    const Vector3d x =
        options.center +
        options.extent * Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    Matrix3d normal = Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    for (std::size_t c = 0; c < truth.cameras.size(); ++c) {
      const std::optional<Eigen::Vector2d> pixel =
          project(truth.cameras[c].model, truth.cameras[c].cam_from_world * x);
      if (!pixel || !inside(truth.cameras[c].model, *pixel)) continue;
      const std::optional<Vector3d> ray = unproject(solved.cameras[c].model, *pixel);
      if (!ray) continue;
      const Vector3d d = (solved.cameras[c].cam_from_world.rotation.conjugate() * *ray).normalized();
      const Matrix3d across = Matrix3d::Identity() - d * d.transpose();
      normal += across;
      right += across * solved.cameras[c].cam_from_world.center();
    }
    wanted.push_back(x);
    found.push_back(normal.ldlt().solve(right));
  }
  Vector3d mean_wanted = Vector3d::Zero(), mean_found = Vector3d::Zero();
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    mean_wanted += wanted[i] / 1000;
    mean_found += found[i] / 1000;
  }
  Matrix3d cross = Matrix3d::Zero();
  for (std::size_t i = 0; i < wanted.size(); ++i)
    cross += (wanted[i] - mean_wanted) * (found[i] - mean_found).transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const Matrix3d turn = svd.matrixU() * Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
  TruthErrors e;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    e.grid_mm += (turn * (found[i] - mean_found) + mean_wanted - wanted[i]).norm();  // mean × 1000
  for (std::size_t c = 0; c < truth.cameras.size(); ++c) {
    const CameraModel &a = solved.cameras[c].model, &b = truth.cameras[c].model;
    e.focal = std::max({e.focal, std::abs(a.fx / b.fx - 1), std::abs(a.fy / b.fy - 1)});
    const Matrix3d difference = solved.cameras[c].cam_from_world.rotation.toRotationMatrix() *
                                turn.transpose() *
                                truth.cameras[c].cam_from_world.rotation.toRotationMatrix().transpose();
    e.rotation_degrees = std::max(e.rotation_degrees, Eigen::AngleAxisd(difference).angle() / kRadians);
  }
  return e;
}

}  // namespace floatstage::calib
