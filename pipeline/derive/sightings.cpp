// Points and boards in a take's world, by what several cameras see of them: rays met by least squares, the
// board fitted with S. Umeyama's similarity (PAMI 1991). docs/adr/0240-worlds-by-what-is-known.md

#include "pipeline/derive/sightings.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>

#include "calib/detect.h"
#include "core/parallel.h"
#include "core/text.h"

namespace floatstage::pipeline {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Rays closer together than half a degree tell the depth to no better than a hundredth of the distance.
constexpr double kLeastAngle = 0.01;

struct Seen {
  std::map<int, std::vector<Sighting>> points;  // by the board's number
  std::set<int> cameras;
  std::string why_not;  // of the first camera without it
};

Result<Seen> look_for(capture::TakeReader& take, const calib::TargetDesign& board, int frame) {
  const std::size_t count = take.rig().cameras.size();
  std::vector<Result<calib::Detection>> found(count, calib::Detection());
  parallel_for(count, 0, [&](std::size_t c) {
    const Result<Frame> picture = take.frame(static_cast<int>(c), frame);
    if (!picture) {
      found[c] = forward(picture);
      return;
    }
    if (picture->empty()) return;
    const Result<Image> rgb = to_rgb(*picture);
    found[c] = rgb ? Result<calib::Detection>(calib::detect(board, *rgb)) : forward(rgb);
  });
  Seen seen;
  for (std::size_t c = 0; c < count; ++c) {
    if (!found[c]) return forward(found[c]);
    if (found[c]->points.empty() && seen.why_not.empty())
      seen.why_not = text("camera '", take.rig().cameras[c].serial,
                          "': ", found[c]->reason.empty() ? "no picture" : found[c]->reason);
    for (const calib::SeenPoint& p : found[c]->points) {
      seen.points[p.id].push_back({static_cast<int>(c), p.pixel});
      seen.cameras.insert(static_cast<int>(c));
    }
  }
  return seen;
}

}  // namespace

Result<Placed> place(const Rig& rig, const std::vector<Sighting>& seen, const std::string& what,
                     double most) {
  Matrix3d a = Matrix3d::Zero();
  Vector3d b = Vector3d::Zero();
  std::set<int> cameras;
  for (const Sighting& s : seen) {
    const RigCamera& c = rig.cameras[static_cast<std::size_t>(s.camera)];
    const std::optional<Vector3d> ray = unproject(c.model, s.pixel);
    if (!ray) continue;
    const Vector3d direction = (c.cam_from_world.rotation.conjugate() * *ray).normalized();
    const Matrix3d across = Matrix3d::Identity() - direction * direction.transpose();
    a += across;
    b += across * c.cam_from_world.center();
    cameras.insert(s.camera);
  }
  const double n = static_cast<double>(std::max<std::size_t>(cameras.size(), 1));
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(a);
  if (cameras.size() < 2 || solver.eigenvalues()(0) < kLeastAngle * kLeastAngle / 4 * n)
    return fail(ErrorCode::InvalidArgument,
                text(what, ": two cameras must show it from directions that differ; ", cameras.size(),
                     cameras.size() == 1 ? " does" : " do"));
  Placed placed{a.ldlt().solve(b), 0};
  for (const Sighting& s : seen) {
    const RigCamera& c = rig.cameras[static_cast<std::size_t>(s.camera)];
    const std::optional<Eigen::Vector2d> at = project(c.model, c.cam_from_world * placed.point);
    if (!at)
      return fail(ErrorCode::InvalidArgument, text(what, ": it would lie behind camera '", c.serial, "'"));
    placed.error += (*at - s.pixel).squaredNorm() / static_cast<double>(seen.size());
  }
  placed.error = std::sqrt(placed.error);
  if (placed.error > most)
    return fail(ErrorCode::InvalidArgument,
                text(what, ": no point lies there in all pictures, the best misses by ", placed.error,
                     " px; mark it again, or calibrate"));
  return placed;
}

Result<BoardWorld> world_from_board(capture::TakeReader& take, const calib::TargetDesign& board, int frame,
                                    double height) {
  const Result<Seen> seen = look_for(take, board, frame);
  if (!seen) return forward(seen);
  const std::vector<Vector3d> design = calib::target_points(board);
  std::vector<Vector3d> from, to;
  for (const auto& [id, sightings] : seen->points) {
    const Result<Placed> placed = place(take.rig(), sightings, text("point ", id));
    if (!placed) continue;
    from.push_back(placed->point);
    to.push_back(design[static_cast<std::size_t>(id)] + Vector3d(0, 0, height));
  }
  constexpr std::size_t kFewest = 6;
  if (from.size() < kFewest)
    return fail(ErrorCode::BadData,
                text(take.layout().folder().string(), ": frame ", frame, ": ", seen->cameras.size(),
                     " cameras found the board and agree about ", from.size(), " of its points, ", kFewest,
                     " are needed; choose a frame in which two cameras see all of it",
                     seen->why_not.empty() ? "" : text(" (", seen->why_not, ")")));
  Eigen::Matrix3Xd p(3, from.size()), q(3, from.size());
  for (std::size_t i = 0; i < from.size(); ++i)
    p.col(static_cast<Eigen::Index>(i)) = from[i], q.col(static_cast<Eigen::Index>(i)) = to[i];
  const Eigen::Matrix4d similarity = Eigen::umeyama(p, q, true);
  BoardWorld world;
  world.change.scale = std::cbrt(similarity.topLeftCorner<3, 3>().determinant());
  world.change.rotation =
      Eigen::Quaterniond(Matrix3d(similarity.topLeftCorner<3, 3>() / world.change.scale)).normalized();
  world.change.translation = similarity.topRightCorner<3, 1>();
  world.points = static_cast<int>(from.size());
  world.cameras = static_cast<int>(seen->cameras.size());
  Eigen::AlignedBox3d box;
  for (std::size_t i = 0; i < from.size(); ++i) {
    world.rms += (world.change * from[i] - to[i]).squaredNorm() / static_cast<double>(from.size());
    box.extend(to[i]);
  }
  world.rms = std::sqrt(world.rms);
  constexpr double kFlat = 0.05;  // of its size: more is no board, or another one than was said
  if (world.rms > kFlat * box.diagonal().norm())
    return fail(ErrorCode::BadData,
                text(take.layout().folder().string(), ": frame ", frame,
                     ": what the cameras see misses the board by ", 1000 * world.rms,
                     " mm; is the calibration another session's, or the board another one?"));
  return world;
}

}  // namespace floatstage::pipeline
