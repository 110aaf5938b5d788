// Method:  the nearest lens that a format holds: damped least squares over the rays of the picture
// Paper:   K. Levenberg, "A method for the solution of certain non-linear problems in least squares", 1944
// Differs: a turn of the camera is fitted too; it takes half of a skew
// ADR:     0226

#include "calib/formats/refit.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <limits>

#include <Eigen/Cholesky>

#include "calib/observations.h"
#include "calib/solver/projection.h"
#include "calib/solver/scene.h"
#include "core/text.h"

namespace floatstage::calib {
namespace {

using solver::Intrinsics;
using solver::kIntrinsics;
using solver::kLensRow;
using solver::kSkewRow;
constexpr int kUnknowns = kIntrinsics + 3;
using Vector = Eigen::Matrix<double, kUnknowns, 1>;
using Matrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;

struct Sight {
  Eigen::Vector3d ray;
  Eigen::Vector2d pixel;
};

// Pixels all over the picture, its border too, and their rays.
std::vector<Sight> sights_of(const CameraModel& m, int columns, int rows) {
  std::vector<Sight> out;
  for (int r = 0; r <= rows; ++r)
    for (int c = 0; c <= columns; ++c) {
      const Eigen::Vector2d pixel(1.0 * m.width * c / columns, 1.0 * m.height * r / rows);
      if (const std::optional<Eigen::Vector3d> ray = unproject(m, pixel)) out.push_back({*ray, pixel});
    }
  return out;
}

constexpr int kAllRadial = static_cast<int>(solver::kRadialRows.size());

bool is_rational(const CameraModel& m) {
  const auto* b = std::get_if<BrownConrady>(&m.lens);
  return b && b->rational();
}

bool fits(const CameraModel& m, const LensLimits& holds) {
  if (m.skew != 0 && !holds.skew) return false;
  if (std::holds_alternative<KannalaBrandt>(m.lens)) return holds.fisheye;
  const auto* b = std::get_if<BrownConrady>(&m.lens);
  if (!b) return true;
  const Intrinsics packed = solver::pack(m);
  for (std::size_t i = static_cast<std::size_t>(holds.radial); i < solver::kRadialRows.size(); ++i)
    if (packed[solver::kRadialRows[i]] != 0) return false;
  return holds.tangential || (b->p1 == 0 && b->p2 == 0);
}

// A camera with a lens of one kind, turned against where it was.
struct Candidate {
  LensKind lens = LensKind::None;
  Intrinsics intrinsics = Intrinsics::Zero();
  Eigen::Matrix<bool, kIntrinsics, 1> free = Eigen::Matrix<bool, kIntrinsics, 1>::Constant(false);
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();
};

Candidate start(const CameraModel& from, LensKind lens, const LensLimits& holds) {
  Candidate c;
  c.lens = lens;
  c.intrinsics = solver::pack(from);
  c.free.head<4>().setConstant(true);
  c.free[kSkewRow] = holds.skew && from.skew != 0;
  if (lens == LensKind::BrownConrady) {
    for (int i = 0; i < holds.radial; ++i) c.free[solver::kRadialRows[static_cast<std::size_t>(i)]] = true;
    c.free.segment<2>(solver::kTangentialRow).setConstant(holds.tangential);
  }
  if (lens == LensKind::KannalaBrandt) c.free.segment<4>(kLensRow).setConstant(true);
  // A numerator without its denominator is no start.
  const bool loses_denominator = is_rational(from) && holds.radial < kAllRadial;
  if (static_cast<LensKind>(from.lens.index()) != lens || loses_denominator) {
    c.intrinsics.segment<solver::kLensRows>(kLensRow).setZero();
    // tan θ by powers of θ: an equidistant lens that bends nothing.
    if (lens == LensKind::KannalaBrandt)
      c.intrinsics.segment<4>(kLensRow) << 1.0 / 3, 2.0 / 15, 17.0 / 315, 62.0 / 2835;
  }
  for (int i = 0; i < kIntrinsics; ++i)
    if (!c.free[i]) c.intrinsics[i] = 0;
  return c;
}

// Sum of squares, and the normal equations where they are wanted; infinite where a ray is lost.
double squares(const Candidate& c, const std::vector<Sight>& sights, Matrix* normal, Vector* right) {
  if (normal) normal->setZero(), right->setZero();
  double sum = 0;
  for (const Sight& s : sights) {
    solver::Projected p;
    const Eigen::Vector3d ray = c.turn * s.ray;
    if (!solver::project(c.intrinsics, c.lens, ray, p)) return std::numeric_limits<double>::infinity();
    const Eigen::Vector2d error = p.pixel - s.pixel;
    sum += error.squaredNorm();
    if (!normal) continue;
    Eigen::Matrix<double, 2, kUnknowns> j;
    j << p.by_intrinsics, -p.by_point * solver::cross_matrix(ray);
    for (int i = 0; i < kIntrinsics; ++i)
      if (!c.free[i]) j.col(i).setZero();
    *normal += j.transpose() * j;
    *right -= j.transpose() * error;
  }
  return sum;
}

void improve(Candidate& c, const std::vector<Sight>& sights) {
  double damping = 1e-6;
  Matrix normal;
  Vector right;
  double now = squares(c, sights, &normal, &right);
  for (int i = 0; i < 200 && std::isfinite(now) && damping < 1e8; ++i) {
    Matrix damped = normal;
    for (int k = 0; k < kUnknowns; ++k) damped(k, k) += damping * normal(k, k) + 1e-12 + (normal(k, k) == 0);
    const Vector step = damped.ldlt().solve(right);
    Candidate next = c;
    next.intrinsics += step.head<kIntrinsics>();
    next.turn = (solver::rotation_from_vector(step.tail<3>()) * c.turn).normalized();
    const double then = squares(next, sights, nullptr, nullptr);
    if (!(then < now)) {
      damping *= 10;
      continue;
    }
    const bool done = now - then < 1e-12 * now;
    c = next;
    damping = std::max(1e-12, damping / 10);
    now = squares(c, sights, &normal, &right);
    if (done) break;
  }
}

// The furthest that a ray is off, by the projection that all of the program uses.
double furthest(const CameraModel& m, const Eigen::Quaterniond& turn, const std::vector<Sight>& sights) {
  double most = 0;
  for (const Sight& s : sights) {
    const std::optional<Eigen::Vector2d> pixel = project(m, turn * s.ray);
    if (!pixel) return std::numeric_limits<double>::infinity();
    most = std::max(most, (*pixel - s.pixel).norm());
  }
  return most;
}

std::string what_it_lacks(const CameraModel& m, const LensLimits& holds) {
  const auto* b = std::get_if<BrownConrady>(&m.lens);
  if (m.skew != 0 && !holds.skew) return "a skew";
  if (std::holds_alternative<KannalaBrandt>(m.lens)) return "a fisheye lens";
  if (is_rational(m) && holds.radial > 0) return "a rational lens (k4 to k6)";
  if (b && b->k3 != 0 && holds.radial < 3 && holds.radial > 0) return "a third radial term";
  return "this lens";
}

std::string remedy(const CameraModel& m, const LensLimits& holds) {
  if (m.skew != 0 && !holds.skew)
    return "write qualisys or middlebury, which hold a skew, or calibrate without it";
  if (std::holds_alternative<KannalaBrandt>(m.lens)) return "write colmap or kalibr, which hold a fisheye";
  if (is_rational(m) && holds.radial > 0)
    return text("write colmap or opencv, which hold it, or calibrate with radial = ", holds.radial);
  if (holds.radial == 2) return "calibrate with radial = 2, or write colmap, opencv or qualisys";
  return "write colmap, or undistort the pictures first";
}

}  // namespace

Result<FittedRig> fit_to_format(const Rig& rig, const LensLimits& holds, std::string_view format,
                                double largest_px) {
  if (Result<void> ok = check(rig); !ok) return forward(ok);
  FittedRig out{rig, {}};
  for (RigCamera& camera : out.rig.cameras) {
    const CameraModel was = camera.model;
    const Rigid3 stood = camera.cam_from_world;
    if (fits(was, holds)) {
      out.residual_px.push_back(Measured::not_measured("the format holds this camera as it is"));
      continue;
    }
    const std::vector<Sight> sights = sights_of(was, 24, 18), between = sights_of(was, 61, 47);
    double least = std::numeric_limits<double>::infinity();
    std::vector<LensKind> kinds = {holds.radial > 0 ? LensKind::BrownConrady : LensKind::None};
    if (holds.fisheye) kinds.push_back(LensKind::KannalaBrandt);
    // A denominator that nothing asks for only makes the lens fold over.
    LensLimits room = holds;
    if (!is_rational(was)) room.radial = std::min(room.radial, 3);
    for (const LensKind lens : kinds) {
      Candidate c = start(was, lens, room);
      improve(c, sights);
      const CameraModel model = solver::unpack(c.intrinsics, lens, was.width, was.height);
      const double off =
          check(model) ? furthest(model, c.turn, between) : std::numeric_limits<double>::infinity();
      if (!(off < least)) continue;
      least = off;
      camera.model = model;
      camera.cam_from_world = Rigid3{c.turn, Eigen::Vector3d::Zero()} * stood;
      camera.cam_from_world.rotation.normalize();
    }
    if (!(least <= largest_px)) {
      const std::string how_far =
          std::isfinite(least)
              ? text("the nearest camera that it holds is up to ", std::setprecision(3), least,
                     " px off, and at most ", largest_px, " px are accepted (--largest-residual)")
              : std::string("no camera that it holds sees all of the picture");
      return fail(ErrorCode::Unsupported,
                  text("camera '", camera.serial, "' has ", what_it_lacks(was, holds), ", which ", format,
                       " cannot hold; ", how_far, "; ", remedy(was, holds)));
    }
    out.residual_px.emplace_back(least, static_cast<long>(between.size()));
  }
  return out;
}

}  // namespace floatstage::calib
