#include "core/rig.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "core/serial.h"
#include "core/text.h"

namespace floatstage {
namespace {

Eigen::Vector3d axis_in_world(const RigCamera& c, const Eigen::Vector3d& axis) {
  return c.cam_from_world.rotation.conjugate() * axis;
}

}  // namespace

bool is_usable_serial(std::string_view s) {
  return !s.empty() && s.front() != '.' && std::all_of(s.begin(), s.end(), [](unsigned char c) {
    return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || c == '.' ||
           c == '_' || c == '-';
  });
}

int camera_index(const Rig& rig, std::string_view serial) {
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    if (rig.cameras[i].serial == serial) return static_cast<int>(i);
  // A take or a session from when serials kept their picture's extension (core/serial.h).
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    if (without_media_extension(rig.cameras[i].serial) == without_media_extension(serial))
      return static_cast<int>(i);
  return -1;
}

Result<void> check(const Rig& rig) {
  if (rig.cameras.empty()) return fail(ErrorCode::BadData, "the rig has no camera");
  for (const RigCamera& c : rig.cameras) {
    auto bad = [&](const std::string& what) {
      return fail(ErrorCode::BadData, text("camera '", c.serial, "': ", what));
    };
    if (!is_usable_serial(c.serial))
      return bad("a serial must be letters, digits, '.', '_' and '-', and not begin with '.'");
    const auto same = [&](const RigCamera& other) { return other.serial == c.serial; };
    if (std::find_if(rig.cameras.begin(), rig.cameras.end(), same) !=
        rig.cameras.begin() + (&c - rig.cameras.data()))
      return bad("two cameras have this serial");
    if (Result<void> ok = check(c.model); !ok) return bad(ok.error().message);
    const Rigid3& t = c.cam_from_world;
    if (!t.rotation.coeffs().allFinite() || !t.translation.allFinite())
      return bad("cam_from_world is not finite");
    if (std::abs(t.rotation.norm() - 1) > 1e-6)
      return bad("the rotation of cam_from_world is not of unit length");
    if (!c.color.matrix.allFinite()) return bad("the colour matrix is not finite");
    for (const double e : {c.color.decode.x(), c.color.decode.y(), c.color.decode.z(), c.color.encode})
      if (!(e >= 0.1 && e <= 10)) return bad("a colour curve's exponent is not between 0.1 and 10");
  }
  return {};
}

Eigen::Vector3d focus_point(const Rig& rig) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero(), centroid = Eigen::Vector3d::Zero(),
                  mean_axis = Eigen::Vector3d::Zero();
  for (const RigCamera& c : rig.cameras) {
    const Eigen::Vector3d axis = axis_in_world(c, Eigen::Vector3d::UnitZ()),
                          center = c.cam_from_world.center();
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - axis * axis.transpose();
    a += across;
    b += across * center;
    centroid += center;
    mean_axis += axis;
  }
  const double n = static_cast<double>(rig.cameras.size());
  centroid /= n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(a);
  if (eigen.eigenvalues()(0) > 1e-6 * n) return a.ldlt().solve(b);
  if (mean_axis.norm() < 1e-6 * n) return centroid;  // cameras that face each other along one line
  double spread = 0;
  for (const RigCamera& c : rig.cameras)
    spread = std::max(spread, (c.cam_from_world.center() - centroid).norm());
  return centroid + mean_axis.normalized() * std::max(spread, 1.0);
}

Eigen::Vector3d mean_up(const Rig& rig) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const RigCamera& c : rig.cameras) sum += axis_in_world(c, -Eigen::Vector3d::UnitY());
  return sum.norm() > 1e-9 ? sum.normalized() : Eigen::Vector3d::UnitZ();
}

}  // namespace floatstage
