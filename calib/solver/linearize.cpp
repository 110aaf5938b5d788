// Method:  a view's residual and its derivatives, a board's
//          compressed by a QR decomposition
// Paper:   none: a board's view depends on its pixels through nineteen numbers
// Differs: the view's own jitter in time is eliminated, so that its direction counts less
// ADR:     0112, 0121

#include "calib/solver/linearize.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/QR>

namespace floatstage::calib::solver {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// A residual of two rows scaled so that its square is the loss of its square; its derivative likewise.
struct Robust {
  double scale = 1;  // of the residual
  double bend = 0;   // derivative: scale * d + residual * bend * (residual · d)
};

Robust robust(Loss loss, double square) {
  Robust r;
  if (loss.cauchy <= 0 || square < 1e-12) return r;
  const double c2 = loss.cauchy * loss.cauchy;
  const double rho = c2 * std::log1p(square / c2), slope = 1 / (1 + square / c2);
  r.scale = std::sqrt(rho / square);
  r.bend = (slope * square - rho) / (square * square * r.scale);
  return r;
}

template <class Row>
void apply(const Robust& r, const Vector2d& residual, Row&& derivative) {
  const auto along = (residual.transpose() * derivative).eval();
  derivative *= r.scale;
  derivative += r.bend * residual * along;
}

// The triangle of the QR decomposition of `rows`, which is overwritten; zeros below when there are fewer
// rows.
using Compressed = Eigen::Matrix<double, kBoardRows, kBoardRows>;
Compressed compress(Eigen::Matrix<double, Eigen::Dynamic, kBoardRows>& rows) {
  Compressed out = Compressed::Zero();
  Eigen::HouseholderQR<Eigen::Ref<Eigen::Matrix<double, Eigen::Dynamic, kBoardRows>>> qr(rows);
  const auto height = std::min<Eigen::Index>(rows.rows(), kBoardRows);
  out.topRows(height) = qr.matrixQR().topRows(height).triangularView<Eigen::Upper>();
  return out;
}

// How the rotation of a rotation vector changes with it, as a rotation vector from the left.
Matrix3d left_jacobian(const Vector3d& v) {
  const double angle = v.norm();
  const Matrix3d x = cross_matrix(v);
  if (angle < 1e-6) return Matrix3d::Identity() + 0.5 * x;
  return Matrix3d::Identity() + (1 - std::cos(angle)) / (angle * angle) * x +
         (angle - std::sin(angle)) / (angle * angle * angle) * x * x;
}

// Instead of a number more to solve for, its direction counts less: of rows r + j (τ - τ₀) with τ ~ N(0, σ²)
// what is left without τ has the covariance I + σ² j jᵀ, by whose root rows are divided.
void eliminate_jitter(const SceneView& v, double sigma, LinearView& out) {
  const double square = out.by_offset.squaredNorm(), known = 1 + sigma * sigma * square;
  out.jitter = 0;
  out.jitter_sigma = sigma;
  if (!(square > 0)) return;
  out.residual -= out.by_offset * v.jitter;
  out.jitter = -sigma * sigma * out.by_offset.dot(out.residual) / known;
  out.jitter_sigma = sigma / std::sqrt(known);
  const Eigen::VectorXd along = out.by_offset / std::sqrt(square);
  const double less = 1 - 1 / std::sqrt(known);
  const auto divide = [&](auto& rows) { rows -= (less * along) * (along.transpose() * rows).eval(); };
  divide(out.residual);
  divide(out.by_intrinsics);
  divide(out.by_camera);
  divide(out.by_object);
  divide(out.by_offset);
}

using BoardRows = Eigen::Matrix<double, Eigen::Dynamic, kBoardRows>;

// Fills in two rows a kept point: the derivatives by the intrinsics and by a twist of the camera's frame
// (which moves a point by ω × p + v), and the residual; none where only the sum of squares is asked for.
// Returns the sum of squares; absent when a point is behind the camera.
std::optional<double> fill_rows(const SceneCamera& camera, const Target& target, const SceneView& v,
                                const Rigid3& from_target, Loss loss, bool with_rows, BoardRows& rows) {
  const Matrix3d turn = from_target.rotation.toRotationMatrix();
  Eigen::Index row = 0;
  double cost = 0;
  Projected projected;
  for (const ScenePoint& p : v.points) {
    if (!p.kept) continue;
    const Vector3d in_camera =
        turn * target.points[static_cast<std::size_t>(p.index)].position + from_target.translation;
    if (!(with_rows ? project(camera.intrinsics, camera.lens, in_camera, projected)
                    : project<Slopes::None>(camera.intrinsics, camera.lens, in_camera, projected)))
      return std::nullopt;
    const double weight = 1 / (p.sigma * camera.noise);
    const Vector2d residual = (projected.pixel - p.pixel) * weight;
    const Robust r = robust(loss, residual.squaredNorm());
    cost += (r.scale * residual).squaredNorm();
    if (!with_rows) continue;
    auto block = rows.middleRows<2>(row);
    block.leftCols<kIntrinsics>() = weight * projected.by_intrinsics;
    block.middleCols<3>(kIntrinsics) = -weight * projected.by_point * cross_matrix(in_camera);
    block.middleCols<3>(kIntrinsics + 3) = weight * projected.by_point;
    apply(r, residual, block.leftCols<kIntrinsics + 6>());
    block.col(kIntrinsics + 6) = r.scale * residual;
    row += 2;
  }
  return cost;
}

// From the derivative by a twist of the camera's frame to those by both poses, the motion and the offset,
// which all act through such a twist.
void spread_twist(const Eigen::Matrix<double, kBoardRows, 6>& by_twist, const SceneCamera& camera,
                  const SceneBoard& board, const Rigid3& from_target, double dt, LinearView& out) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const Matrix3d rotation = camera.cam_from_world.rotation.toRotationMatrix();
  Matrix6 of_camera = Matrix6::Identity(), of_board = Matrix6::Zero();
  of_camera.bottomLeftCorner<3, 3>() = cross_matrix(camera.cam_from_world.translation);
  of_board.topLeftCorner<3, 3>() = rotation;
  of_board.bottomLeftCorner<3, 3>() = cross_matrix(from_target.translation) * rotation;
  of_board.bottomRightCorner<3, 3>() = rotation;
  Eigen::Matrix<double, 6, 1> motion = Eigen::Matrix<double, 6, 1>::Zero();
  out.by_object.resize(kBoardRows, board.free_motion ? 12 : 6);
  if (board.has_motion) {
    motion << board.spin, board.velocity + board.acceleration * dt;
    motion = of_board * motion;
    if (board.free_motion) {
      Matrix6 of_motion = dt * of_board;
      of_motion.leftCols<3>() *= left_jacobian(board.spin * dt);
      out.by_object.rightCols<6>() = by_twist * of_motion;
    }
    // What turns the board at its own time is carried along by the turn since.
    of_board.leftCols<3>() *= rotation_from_vector(board.spin * dt).toRotationMatrix();
  }
  out.by_camera = by_twist * of_camera;
  out.by_object.leftCols<6>() = by_twist * of_board;
  out.by_offset = by_twist * motion;
}

void linearize_board(const Scene& scene, const SceneView& v, Loss loss, bool with_derivatives,
                     LinearView& out) {
  const SceneCamera& camera = scene.cameras[static_cast<std::size_t>(v.camera)];
  const SceneBoard& board = scene.boards[static_cast<std::size_t>(v.board)];
  const Target& target = scene.targets[static_cast<std::size_t>(board.target)];
  const double dt = v.lag + v.jitter + camera.offset;
  const Rigid3 from_target = camera.cam_from_world * board.at(dt);
  const auto kept =
      std::count_if(v.points.begin(), v.points.end(), [](const ScenePoint& p) { return p.kept; });
  BoardRows rows(2 * kept, kBoardRows);
  const bool jitters = board.has_motion && scene.jitter_sigma > 0;
  const bool needs_rows = with_derivatives || jitters;
  const std::optional<double> cost = fill_rows(camera, target, v, from_target, loss, needs_rows, rows);
  if (!cost) return;
  out.valid = true;
  if (!needs_rows) {  // only the sum of squares is asked for
    out.residual = Eigen::VectorXd::Zero(kBoardRows);
    out.residual[0] = std::sqrt(*cost);
    return;
  }
  const Compressed r = compress(rows);
  out.residual = r.col(kIntrinsics + 6);
  out.by_intrinsics = r.leftCols<kIntrinsics>();
  spread_twist(r.middleCols<6>(kIntrinsics), camera, board, from_target, dt, out);
  if (jitters) eliminate_jitter(v, scene.jitter_sigma, out);
}

void linearize_markers(const Scene& scene, const SceneView& v, Loss loss, LinearView& out) {
  const SceneCamera& camera = scene.cameras[static_cast<std::size_t>(v.camera)];
  const SceneMarkers& markers = scene.markers[static_cast<std::size_t>(v.markers)];
  const double dt = v.lag + camera.offset;
  const Matrix3d rotation = camera.cam_from_world.rotation.toRotationMatrix();
  const auto height = 2 * static_cast<Eigen::Index>(v.points.size());
  out.residual.setZero(height);
  out.by_intrinsics.setZero(height, kIntrinsics);
  out.by_camera.setZero(height, 6);
  out.by_object.setZero(height, 3 * static_cast<Eigen::Index>(markers.positions.size()));
  out.by_offset.setZero(height);
  Eigen::Index row = 0;
  Projected projected;
  for (const ScenePoint& p : v.points) {
    if (!p.kept) continue;
    const auto i = static_cast<std::size_t>(p.index);
    const Vector3d velocity = markers.has_motion ? markers.velocities[i] : Vector3d(Vector3d::Zero());
    const Vector3d turned = rotation * (markers.positions[i] + velocity * dt);
    if (!project(camera.intrinsics, camera.lens, turned + camera.cam_from_world.translation, projected))
      return;
    const double weight = 1 / (p.sigma * camera.noise);
    const Vector2d residual = (projected.pixel - p.pixel) * weight;
    const Robust r = robust(loss, residual.squaredNorm());
    Eigen::Matrix<double, 2, 3> by_point = weight * projected.by_point;
    Eigen::Matrix<double, 2, kIntrinsics> by_intrinsics = weight * projected.by_intrinsics;
    apply(r, residual, by_point);
    apply(r, residual, by_intrinsics);
    out.residual.segment<2>(row) = r.scale * residual;
    out.by_intrinsics.middleRows<2>(row) = by_intrinsics;
    out.by_camera.block<2, 3>(row, 0) = -by_point * cross_matrix(turned);
    out.by_camera.block<2, 3>(row, 3) = by_point;
    out.by_object.block<2, 3>(row, 3 * p.index) = by_point * rotation;
    out.by_offset.segment<2>(row) = by_point * (rotation * velocity);
    row += 2;
  }
  out.valid = true;
}

}  // namespace

void linearize(const Scene& scene, const SceneView& view, Loss loss, bool with_derivatives, LinearView& out) {
  out.valid = false;
  if (view.board >= 0)
    linearize_board(scene, view, loss, with_derivatives, out);
  else
    linearize_markers(scene, view, loss, out);
}

LinearDistance linearize_distance(const SceneDistance& known, const Rigid3& a, const Rigid3& b) {
  const Vector3d between = a.center() - b.center();
  const double length = std::max(between.norm(), 1e-9);
  LinearDistance out;
  out.residual = (length - known.metres) / known.sigma;
  // A centre is -Rᵀt: it moves with the translation and with the rotation.
  const auto by_pose = [&](const Rigid3& pose) {
    const Matrix3d turn = pose.rotation.conjugate().toRotationMatrix();
    Eigen::Matrix<double, 3, 6> center;
    center << -turn * cross_matrix(pose.translation), -turn;
    return Eigen::Matrix<double, 1, 6>(between.transpose() / (length * known.sigma) * center);
  };
  out.by_poses << by_pose(a), -by_pose(b);
  return out;
}

Eigen::VectorXd marker_residual(const SceneMarkers& markers, const Target& target,
                                Eigen::MatrixXd* by_positions) {
  const auto place = [&](int id) {
    const auto found = std::find(markers.indices.begin(), markers.indices.end(), point_index(target, id));
    return found == markers.indices.end() ? -1 : static_cast<int>(found - markers.indices.begin());
  };
  std::vector<const TargetLength*> lengths;
  for (const TargetLength& l : target.lengths)
    if (place(l.a) >= 0 && place(l.b) >= 0) lengths.push_back(&l);
  const auto count = static_cast<Eigen::Index>(markers.positions.size());
  const auto surveyed = target.positions_sigma ? 3 * count : 0,
             known = static_cast<Eigen::Index>(lengths.size());
  Eigen::VectorXd r(known + surveyed);
  if (by_positions) by_positions->setZero(r.size(), 3 * count);
  for (Eigen::Index i = 0; i < known; ++i) {
    const TargetLength& l = *lengths[static_cast<std::size_t>(i)];
    const int a = place(l.a), b = place(l.b);
    const Vector3d between =
        markers.positions[static_cast<std::size_t>(a)] - markers.positions[static_cast<std::size_t>(b)];
    const double length = std::max(between.norm(), 1e-9);
    r[i] = (length - l.metres) / l.sigma;
    if (!by_positions) continue;
    by_positions->block<1, 3>(i, 3 * a) = between.transpose() / (length * l.sigma);
    by_positions->block<1, 3>(i, 3 * b) = -by_positions->block<1, 3>(i, 3 * a);
  }
  for (Eigen::Index i = 0; i < surveyed / 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double weight = 1 / *target.positions_sigma;
    r.segment<3>(known + 3 * i) =
        weight *
        (markers.positions[k] - target.points[static_cast<std::size_t>(markers.indices[k])].position);
    if (by_positions) by_positions->block<3, 3>(known + 3 * i, 3 * i) = weight * Eigen::Matrix3d::Identity();
  }
  return r;
}

}  // namespace floatstage::calib::solver
