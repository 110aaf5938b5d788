// Method:  one joint least-squares solution over cameras, boards, markers and time offsets
// Paper:   B. Triggs and others, "Bundle adjustment: a modern synthesis", 2000; solved by Ceres with a
//          Schur complement
// Differs: board views are compressed to twenty rows; sums do not depend on the heap or on threads
// ADR:     0110, 0112, 0113

#include "calib/solver/bundle.h"

#include <algorithm>
#include <array>
#include <memory>

#include <ceres/ceres.h>

#include "calib/solver/ring.h"
#include "core/parallel.h"

namespace floatstage::calib::solver {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Pose = std::array<double, 7>;  // quaternion x y z w, translation
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Pose to_array(const Rigid3& t) {
  const Eigen::Quaterniond& q = t.rotation;
  return {q.x(), q.y(), q.z(), q.w(), t.translation.x(), t.translation.y(), t.translation.z()};
}

Rigid3 from_array(const Pose& p) {
  return {Eigen::Quaterniond(p[3], p[0], p[1], p[2]).normalized(), {p[4], p[5], p[6]}};
}

// A rotation vector (rad) from the left, and an addition to the translation.
class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* delta, double* out) const override {
    const Eigen::Quaterniond q(x[3], x[0], x[1], x[2]);
    const Eigen::Quaterniond turned = (rotation_from_vector({delta[0], delta[1], delta[2]}) * q).normalized();
    Eigen::Map<Eigen::Vector4d> quaternion(out, 4);
    quaternion = turned.coeffs();
    for (int i = 0; i < 3; ++i) out[4 + i] = x[4 + i] + delta[3 + i];
    return true;
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> j(jacobian);
    j.setZero();
    j.topLeftCorner<4, 3>() = 0.5 * quaternion_by_rotation(x);
    j.bottomRightCorner<3, 3>().setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    const Eigen::Quaterniond a(y[3], y[0], y[1], y[2]), b(x[3], x[0], x[1], x[2]);
    Eigen::Map<Eigen::Vector3d>(delta, 3) = vector_from_rotation(a * b.conjugate());
    for (int i = 0; i < 3; ++i) delta[3 + i] = y[4 + i] - x[4 + i];
    return true;
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> j(jacobian);
    j.setZero();
    j.topLeftCorner<3, 4>() = 2 * quaternion_by_rotation(x).transpose();
    j.bottomRightCorner<3, 3>().setIdentity();
    return true;
  }
  // Twice the derivative of a unit quaternion by a rotation vector; its columns are orthonormal.
  static Eigen::Matrix<double, 4, 3> quaternion_by_rotation(const double* q) {
    Eigen::Matrix<double, 4, 3> j;
    j << q[3], q[2], -q[1], -q[2], q[3], q[0], q[1], -q[0], q[3], -q[0], -q[1], -q[2];
    return j;
  }
};

// A pose, and its spin and velocity behind it.
class MovingPoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 13; }
  int TangentSize() const override { return 12; }
  bool Plus(const double* x, const double* delta, double* out) const override {
    for (int i = 0; i < 6; ++i) out[7 + i] = x[7 + i] + delta[6 + i];
    return pose_.Plus(x, delta, out);
  }
  bool PlusJacobian(const double* x, double* jacobian) const override {
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> pose;
    pose_.PlusJacobian(x, pose.data());
    Eigen::Map<Eigen::Matrix<double, 13, 12, Eigen::RowMajor>> j(jacobian);
    j.setZero();
    j.topLeftCorner<7, 6>() = pose;
    j.bottomRightCorner<6, 6>().setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* delta) const override {
    for (int i = 0; i < 6; ++i) delta[6 + i] = y[7 + i] - x[7 + i];
    return pose_.Minus(y, x, delta);
  }
  bool MinusJacobian(const double* x, double* jacobian) const override {
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> pose;
    pose_.MinusJacobian(x, pose.data());
    Eigen::Map<Eigen::Matrix<double, 12, 13, Eigen::RowMajor>> j(jacobian);
    j.setZero();
    j.topLeftCorner<6, 7>() = pose;
    j.bottomRightCorner<6, 6>().setIdentity();
    return true;
  }

 private:
  PoseManifold pose_;
};

// Derivatives by the 7 numbers of a pose, such that PlusJacobian takes them back to the 6 of its tangent.
// What comes behind the pose stays as it is.
void spread(const Eigen::Ref<const Eigen::MatrixXd>& tangent, const double* pose, double* out) {
  Eigen::Map<RowMajor> j(out, tangent.rows(), tangent.cols() + 1);
  j.leftCols<4>() = 2 * tangent.leftCols<3>() * PoseManifold::quaternion_by_rotation(pose).transpose();
  j.rightCols(tangent.cols() - 3) = tangent.rightCols(tangent.cols() - 3);
}

constexpr std::size_t kBoardSize = 13;  // a pose, spin and velocity

// Ceres' own copy of the parameters, and the linearised views that its cost functions read.
struct Workspace {
  Scene& scene;
  const BundleOptions& options;
  std::vector<Pose> cameras;
  // Boards (13 numbers each, the last six only where motion is solved for) and behind them markers. Ceres
  // orders the blocks of a group by their addresses: in one array these do not depend on the heap, and so
  // neither do the sums.
  std::vector<double> objects;
  std::vector<std::size_t> marker_begin;
  std::vector<int> views;  // the usable ones
  std::vector<LinearView> linear;

  Workspace(Scene& s, const BundleOptions& o) : scene(s), options(o) {
    for (const SceneCamera& c : s.cameras) cameras.push_back(to_array(c.cam_from_world));
    for (const SceneBoard& b : s.boards) {
      const Pose pose = to_array(b.world_from_target);
      objects.insert(objects.end(), pose.begin(), pose.end());
      for (const Eigen::Vector3d& v : {b.spin, b.velocity}) objects.insert(objects.end(), v.begin(), v.end());
    }
    for (const SceneMarkers& m : s.markers) {
      marker_begin.push_back(objects.size());
      for (const Eigen::Vector3d& p : m.positions) objects.insert(objects.end(), p.begin(), p.end());
    }
    for (std::size_t i = 0; i < s.views.size(); ++i) {
      const SceneView& v = s.views[i];
      const bool any =
          std::any_of(v.points.begin(), v.points.end(), [](const ScenePoint& p) { return p.kept; });
      if (any && usable(s, v)) views.push_back(static_cast<int>(i));
    }
    linear.resize(views.size());
  }

  double* board(std::size_t i) { return objects.data() + kBoardSize * i; }
  double* markers(std::size_t i) { return objects.data() + marker_begin[i]; }
  double* object_of(const SceneView& v) {
    return v.board >= 0 ? board(static_cast<std::size_t>(v.board))
                        : markers(static_cast<std::size_t>(v.markers));
  }

  double* intrinsics_of(std::size_t camera) {
    return scene.cameras[static_cast<std::size_t>(lens_owner(scene.cameras, static_cast<int>(camera)))]
        .intrinsics.data();
  }

  void to_scene() {
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      SceneCamera& c = scene.cameras[i];
      if (c.placed) c.cam_from_world = from_array(cameras[i]);
      if (c.lens_of >= 0) c.intrinsics = scene.cameras[static_cast<std::size_t>(c.lens_of)].intrinsics;
    }
    for (std::size_t i = 0; i < scene.boards.size(); ++i)
      if (SceneBoard& b = scene.boards[i]; b.placed) {
        const double* const p = board(i);
        b.world_from_target = from_array({p[0], p[1], p[2], p[3], p[4], p[5], p[6]});
        if (!b.free_motion) continue;
        b.spin = Eigen::Vector3d(p[7], p[8], p[9]);
        b.velocity = Eigen::Vector3d(p[10], p[11], p[12]);
      }
    for (std::size_t i = 0; i < scene.markers.size(); ++i)
      for (std::size_t k = 0; k < scene.markers[i].positions.size(); ++k)
        scene.markers[i].positions[k] = Eigen::Map<const Eigen::Vector3d>(markers(i) + 3 * k);
  }
};

// Projects all views on all threads before Ceres asks for them one by one: the same sums at any number of
// threads.
class ProjectViews final : public ceres::EvaluationCallback {
 public:
  explicit ProjectViews(Workspace& w) : w_(w) {}
  void PrepareForEvaluation(bool with_derivatives, bool new_point) override {
    if (!new_point && (have_derivatives_ || !with_derivatives)) return;
    w_.to_scene();
    parallel_for(w_.views.size(), w_.options.threads, [&](std::size_t i) {
      linearize(w_.scene, w_.scene.views[static_cast<std::size_t>(w_.views[i])], w_.options.loss,
                with_derivatives, w_.linear[i]);
    });
    have_derivatives_ = with_derivatives;
  }

 private:
  Workspace& w_;
  bool have_derivatives_ = false;
};

class ViewCost final : public ceres::CostFunction {
 public:
  ViewCost(Workspace& w, std::size_t index) : w_(w), index_(index) {
    const SceneView& v = view();
    const int markers =
        v.board >= 0
            ? 0
            : 3 * static_cast<int>(w.scene.markers[static_cast<std::size_t>(v.markers)].positions.size());
    set_num_residuals(v.board >= 0 ? kBoardRows : 2 * static_cast<int>(v.points.size()));
    const bool moves = v.board >= 0 && w.scene.boards[static_cast<std::size_t>(v.board)].free_motion;
    *mutable_parameter_block_sizes() = {kIntrinsics, 7, v.board >= 0 ? (moves ? 13 : 7) : markers, 1};
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    const LinearView& linear = w_.linear[index_];
    if (!linear.valid) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, linear.residual.size()) = linear.residual;
    if (!jacobians) return true;
    const SceneView& v = view();
    const Eigen::Index height = linear.residual.size();
    if (jacobians[0])
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, kIntrinsics, Eigen::RowMajor>>(
          jacobians[0], height, kIntrinsics) = linear.by_intrinsics;
    if (jacobians[1])
      spread(linear.by_camera, w_.cameras[static_cast<std::size_t>(v.camera)].data(), jacobians[1]);
    if (jacobians[2]) {
      if (v.board >= 0)
        spread(linear.by_object, w_.object_of(v), jacobians[2]);
      else
        Eigen::Map<RowMajor>(jacobians[2], height, linear.by_object.cols()) = linear.by_object;
    }
    if (jacobians[3]) Eigen::Map<Eigen::VectorXd>(jacobians[3], height) = linear.by_offset;
    return true;
  }

 private:
  const SceneView& view() const { return w_.scene.views[static_cast<std::size_t>(w_.views[index_])]; }
  Workspace& w_;
  std::size_t index_;
};

// (x - start) / sigma of the intrinsics.
class IntrinsicsPrior final : public ceres::SizedCostFunction<kIntrinsics, kIntrinsics> {
 public:
  explicit IntrinsicsPrior(const SceneCamera& c) : start_(c.start), sigma_(prior_sigmas(c)) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Map<Intrinsics> r(residuals);
    r = (Eigen::Map<const Intrinsics>(parameters[0]) - start_).cwiseQuotient(sigma_);
    if (jacobians && jacobians[0])
      Eigen::Map<RowMajor>(jacobians[0], kIntrinsics, kIntrinsics) =
          sigma_.cwiseInverse().asDiagonal().toDenseMatrix();
    return true;
  }

 private:
  const Intrinsics start_, sigma_;
};

// How far a plain lens' pixels are from the shape that they began with.
class PixelShape final : public ceres::SizedCostFunction<1, kIntrinsics> {
 public:
  explicit PixelShape(const SceneCamera& c) : start_(c.start[1] / c.start[0]) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const double fx = parameters[0][0], fy = parameters[0][1], weight = 1 / kPixelShapeSigma;
    residuals[0] = (start_ * fx / fy - 1) * weight;
    if (jacobians && jacobians[0]) {
      Eigen::Map<Eigen::Matrix<double, 1, kIntrinsics>> j(jacobians[0]);
      j.setZero();
      j[0] = start_ / fy * weight;
      j[1] = -start_ * fx / (fy * fy) * weight;
    }
    return true;
  }

 private:
  const double start_;
};

// What neighbouring frames say of a board's motion.
class MotionPrior final : public ceres::SizedCostFunction<6, 13> {
 public:
  explicit MotionPrior(const SceneBoard& b) : weights_(motion_weights(b)) {
    likely_ << b.likely_spin, b.likely_velocity;
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::Map<Vector6> r(residuals, 6);
    r = (Eigen::Map<const Vector6>(parameters[0] + 7) - likely_).cwiseProduct(weights_);
    if (jacobians && jacobians[0]) {
      Eigen::Map<RowMajor> j(jacobians[0], 6, 13);
      j.setZero();
      j.rightCols<6>() = weights_.asDiagonal();
    }
    return true;
  }

 private:
  const Vector6 weights_;
  Vector6 likely_;
};

class DistanceCost final : public ceres::SizedCostFunction<1, 7, 7> {
 public:
  explicit DistanceCost(const SceneDistance& known) : known_(known) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const auto pose = [&](int i) {
      Pose p;
      std::copy(parameters[i], parameters[i] + 7, p.begin());
      return from_array(p);
    };
    const LinearDistance linear = linearize_distance(known_, pose(0), pose(1));
    residuals[0] = linear.residual;
    for (int i = 0; jacobians && i < 2; ++i)
      if (jacobians[i]) spread(linear.by_poses.segment<6>(6 * i), parameters[i], jacobians[i]);
    return true;
  }

 private:
  const SceneDistance known_;
};

constexpr double kDoubtfulDistance = 3;  // sigmas
constexpr double kDoubtfulLength = 10;   // sigmas

// What is known of markers: lengths between them, and where they are when they were surveyed.
class MarkerKnowledge final : public ceres::CostFunction {
 public:
  MarkerKnowledge(const SceneMarkers& markers, const Target& target) : markers_(markers), target_(target) {
    set_num_residuals(static_cast<int>(marker_residual(markers, target, nullptr).size()));
    *mutable_parameter_block_sizes() = {3 * static_cast<int>(markers.positions.size())};
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    SceneMarkers here = markers_;
    for (std::size_t k = 0; k < here.positions.size(); ++k)
      here.positions[k] = Eigen::Map<const Eigen::Vector3d>(parameters[0] + 3 * k);
    Eigen::MatrixXd by_positions;
    const Eigen::VectorXd r = marker_residual(here, target_, &by_positions);
    Eigen::Map<Eigen::VectorXd>(residuals, r.size()) = r;
    if (jacobians && jacobians[0])
      Eigen::Map<RowMajor>(jacobians[0], by_positions.rows(), by_positions.cols()) = by_positions;
    return true;
  }

 private:
  const SceneMarkers markers_;
  const Target& target_;
};

void add_lens(ceres::Problem& problem, SceneCamera& c, const CameraMask& free) {
  std::vector<int> still;
  for (int k = 0; k < kIntrinsics; ++k)
    if (!free[k]) still.push_back(k);
  if (still.size() == kIntrinsics) {
    problem.SetParameterBlockConstant(c.intrinsics.data());
    return;
  }
  if (!still.empty()) problem.SetManifold(c.intrinsics.data(), new ceres::SubsetManifold(kIntrinsics, still));
  problem.AddResidualBlock(new IntrinsicsPrior(c), nullptr, c.intrinsics.data());
  if (c.plain_lens) problem.AddResidualBlock(new PixelShape(c), nullptr, c.intrinsics.data());
}

void add_cameras(ceres::Problem& problem, Workspace& w, const std::vector<bool>& seen) {
  for (std::size_t i = 0; i < w.scene.cameras.size(); ++i) {
    SceneCamera& c = w.scene.cameras[i];
    const CameraMask free = free_parameters(w.scene, static_cast<int>(i), w.options);
    if (problem.HasParameterBlock(c.intrinsics.data())) add_lens(problem, c, free);
    if (!seen[i]) continue;
    problem.SetManifold(w.cameras[i].data(), new PoseManifold);
    if (!free[kIntrinsics]) problem.SetParameterBlockConstant(w.cameras[i].data());
    if (!free[kIntrinsics + 6]) problem.SetParameterBlockConstant(&c.offset);
  }
}

// Which of the scene's things a usable view shows.
struct Seen {
  std::vector<bool> cameras, boards, markers;
};

Seen add_views(ceres::Problem& problem, Workspace& w) {
  Scene& scene = w.scene;
  Seen seen{std::vector<bool>(scene.cameras.size()), std::vector<bool>(scene.boards.size()),
            std::vector<bool>(scene.markers.size())};
  for (std::size_t i = 0; i < w.views.size(); ++i) {
    const SceneView& v = scene.views[static_cast<std::size_t>(w.views[i])];
    const auto camera = static_cast<std::size_t>(v.camera);
    problem.AddResidualBlock(new ViewCost(w, i), nullptr, w.intrinsics_of(camera), w.cameras[camera].data(),
                             w.object_of(v), &scene.cameras[camera].offset);
    seen.cameras[camera] = true;
    if (v.board >= 0)
      seen.boards[static_cast<std::size_t>(v.board)] = true;
    else
      seen.markers[static_cast<std::size_t>(v.markers)] = true;
  }
  return seen;
}

void add_boards(ceres::Problem& problem, Workspace& w, const std::vector<bool>& seen,
                ceres::ParameterBlockOrdering& ordering) {
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) continue;
    if (w.scene.boards[i].free_motion) {
      problem.SetManifold(w.board(i), new MovingPoseManifold);
      problem.AddResidualBlock(new MotionPrior(w.scene.boards[i]), nullptr, w.board(i));
    } else {
      problem.SetManifold(w.board(i), new PoseManifold);
    }
    ordering.AddElementToGroup(w.board(i), 0);
  }
}

void add_markers(ceres::Problem& problem, Workspace& w, const std::vector<bool>& seen,
                 ceres::ParameterBlockOrdering& ordering) {
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) continue;
    const SceneMarkers& markers = w.scene.markers[i];
    const Target& target = w.scene.targets[static_cast<std::size_t>(markers.target)];
    ordering.AddElementToGroup(w.markers(i), 0);
    if (marker_residual(markers, target, nullptr).size() > 0)
      // Lengths that contradict the boards must not drag markers off their rays: then nobody could say which
      // is wrong.
      problem.AddResidualBlock(new MarkerKnowledge(markers, target), new ceres::CauchyLoss(kDoubtfulLength),
                               w.markers(i));
  }
}

void add_distances(ceres::Problem& problem, Workspace& w, const std::vector<bool>& seen) {
  if (!w.options.cameras_move) return;
  for (const SceneDistance& d : w.scene.distances) {
    const auto a = static_cast<std::size_t>(d.a), b = static_cast<std::size_t>(d.b);
    if (seen[a] && seen[b])
      problem.AddResidualBlock(new DistanceCost(d), new ceres::CauchyLoss(kDoubtfulDistance),
                               w.cameras[a].data(), w.cameras[b].data());
  }
}

// How far a camera's centre is from a circle that is solved for (centre, axis, radius), in sigmas.
struct OffRing {
  double sigma;
  template <class T>
  bool operator()(const T* pose, const T* ring, T* residuals) const {
    const Eigen::Map<const Eigen::Quaternion<T>> turn(pose);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> shift(pose + 4), center(ring), axis(ring + 3);
    const Eigen::Matrix<T, 3, 1> d =
        -(turn.normalized().conjugate() * Eigen::Matrix<T, 3, 1>(shift)) - center;
    const T along = d.dot(axis);
    residuals[0] = along / T(sigma);
    residuals[1] = ((d - along * axis).norm() - ring[6]) / T(sigma);
    return true;
  }
};

// `ring`: 7 numbers, which must stay where they are while the problem does.
void add_ring(ceres::Problem& problem, Workspace& w, const std::vector<bool>& seen, std::vector<double>& ring,
              ceres::ParameterBlockOrdering& ordering) {
  if (!(w.scene.ring > 0) || !w.options.cameras_move) return;
  std::vector<Eigen::Vector3d> centers;
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (seen[i]) centers.push_back(w.scene.cameras[i].cam_from_world.center());
  const std::optional<Ring> start = fit_ring(centers);
  if (!start) return;
  ring.assign({start->center.x(), start->center.y(), start->center.z(), start->axis.x(), start->axis.y(),
               start->axis.z(), start->radius});
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (seen[i])
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<OffRing, 2, 7, 7>(new OffRing{w.scene.ring * start->radius}),
          nullptr, w.cameras[i].data(), ring.data());
  problem.SetManifold(ring.data(),
                      new ceres::ProductManifold<ceres::EuclideanManifold<3>, ceres::SphereManifold<3>,
                                                 ceres::EuclideanManifold<1>>);
  ordering.AddElementToGroup(ring.data(), 3);
}

// Ceres orders the blocks of a group by their addresses, so blocks of different arrays are in different
// groups: the sums must not depend on where the heap put an array.
void order_cameras(const ceres::Problem& problem, Workspace& w, const std::vector<bool>& seen,
                   ceres::ParameterBlockOrdering& ordering) {
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (problem.HasParameterBlock(w.scene.cameras[i].intrinsics.data()))
      ordering.AddElementToGroup(w.scene.cameras[i].intrinsics.data(), 1);
    if (!seen[i]) continue;
    ordering.AddElementToGroup(&w.scene.cameras[i].offset, 1);
    ordering.AddElementToGroup(w.cameras[i].data(), 2);
  }
}

}  // namespace

Eigen::Matrix<double, 6, 1> motion_weights(const SceneBoard& b) {
  Vector6 weights;
  weights << Eigen::Vector3d::Constant(1 / b.spin_doubt), Eigen::Vector3d::Constant(1 / b.velocity_doubt);
  return weights;
}

Intrinsics prior_sigmas(const SceneCamera& c) {
  Intrinsics sigma = Intrinsics::Ones();
  sigma.head<2>() = 0.5 * c.start.head<2>();
  sigma[2] = 0.1 * c.width;
  sigma[3] = 0.1 * c.height;
  sigma[kSkewRow] = 0.1 * c.start[0];
  return sigma;
}

CameraMask free_parameters(const Scene& scene, int camera, const BundleOptions& options) {
  const SceneCamera& c = scene.cameras[static_cast<std::size_t>(camera)];
  CameraMask free = CameraMask::Constant(false);
  if (!options.cameras_move) return free;
  if (!c.intrinsics_fixed && c.lens_of < 0 && options.intrinsics != Freedom::None) {
    const int coefficients = coefficient_count(c.lens);
    free.head<2>().setConstant(true);
    if (options.intrinsics == Freedom::All) {
      free.head(4 + coefficients).setConstant(true);
      free[kSkewRow] = true;
      if (c.plain_lens && coefficients > 0) free.segment<kLensRows - 2>(kLensRow + 2).setConstant(false);
    } else if (coefficients > 0) {
      free[kLensRow] = true;
    }
    for (int k = 0; k < kIntrinsics; ++k) free[k] = free[k] && !c.held[k];
  }
  if (!c.pose_fixed && camera != scene.reference) free.segment<6>(kIntrinsics).setConstant(true);
  if (options.offsets && camera != scene.reference) free[kIntrinsics + 6] = true;
  return free;
}

BundleSummary solve(Scene& scene, const BundleOptions& options) {
  Workspace w(scene, options);
  if (w.views.empty()) return {};
  const Scene before = scene;
  ProjectViews project_views(w);
  ceres::Problem::Options problem_options;
  problem_options.evaluation_callback = &project_views;
  ceres::Problem problem(problem_options);
  const auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  const Seen seen = add_views(problem, w);
  add_cameras(problem, w, seen.cameras);
  add_boards(problem, w, seen.boards, *ordering);
  add_markers(problem, w, seen.markers, *ordering);
  add_distances(problem, w, seen.cameras);
  std::vector<double> ring;
  add_ring(problem, w, seen.cameras, ring, *ordering);
  order_cameras(problem, w, seen.cameras, *ordering);

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = options.iterations;
  solver.num_threads = 1;  // more of them add in the order in which they arrive
  solver.function_tolerance = 1e-9;
  solver.gradient_tolerance = 1e-14;
  solver.parameter_tolerance = 1e-10;
  solver.logging_type = ceres::SILENT;
  // A numerator and its denominator are nearly one: without damping that stays, rounding makes the normal
  // equations indefinite.
  constexpr double kAlwaysDamped = 1e8;
  if (std::any_of(scene.cameras.begin(), scene.cameras.end(),
                  [](const SceneCamera& c) { return c.denominator_terms > 0 && !c.held[kDenominatorRow]; }))
    solver.max_trust_region_radius = kAlwaysDamped;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) {
    scene = before;
    return {};
  }
  w.to_scene();
  return {summary.termination_type == ceres::CONVERGENCE, static_cast<int>(summary.iterations.size()),
          summary.final_cost};
}

}  // namespace floatstage::calib::solver
