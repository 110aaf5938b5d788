// Method:  the turn that makes silhouettes coherent with the others' visual hull
// Paper:   C. Hernández, F. Schmitt, R. Cipolla, "Silhouette coherence for camera calibration under circular
//          motion", 2007
// Differs: distances in the picture instead of a share of coherent pixels, so that least squares find it;
//          one camera against a hull without it, which its own turn does not change; uncertainty by a
//          jackknife over stretches of outline (Efron 1982), since neighbouring points err together
// ADR:     0233

#include "calib/silhouettes/silhouette_turn.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <ceres/ceres.h>
#include <opencv2/imgproc.hpp>

#include "calib/solver/scene.h"

namespace floatstage::calib {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBorder = 2;      // px: outlines this near to the picture's border are the border's
constexpr int kStretches = 12;     // of each outline, for the jackknife
constexpr int kFewestPoints = 50;  // of all outlines
constexpr double kLoss = 1;        // px: what sticks out farther counts less (Cauchy's)
// By rounds, each a hundredth of the turn nearer. At first the loss is nearly least squares', which has one
// best; that is followed to kLoss (Blake and Zisserman 1987: graduated non-convexity).
constexpr double kLosses[] = {8 * kLoss, 4 * kLoss, 2 * kLoss, kLoss, kLoss, kLoss};

// Signed distances (px) from the silhouette that the others leave, positive outside, over the part of the
// picture that matters.
class DistanceField {
 public:
  explicit DistanceField(const SilhouetteWitness& witness) : scale_(witness.scale) {
    const Matte& m = witness.others;
    const cv::Mat inside(m.height, m.width, CV_8UC1, const_cast<std::uint8_t*>(m.alpha.get()), m.stride);
    cv::Rect box = cv::boundingRect(inside);
    const int margin = static_cast<int>(2 * kFarthestOutside) * scale_;
    box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
          cv::Rect(0, 0, m.width, m.height);
    origin_ = {box.x, box.y};
    const cv::Mat part = inside(box);
    cv::distanceTransform(part == 0, distance_, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    note_inside(part);
  }

  // Distance and its gradient at a pixel of the camera's picture.
  double at(const Vector2d& pixel, Vector2d& gradient) const {
    const double x = std::clamp(pixel.x() * scale_ - 0.5 - origin_.x(), 0.0, distance_.cols - 1.001),
                 y = std::clamp(pixel.y() * scale_ - 0.5 - origin_.y(), 0.0, distance_.rows - 1.001);
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const double u = x - i, v = y - j, a = value(i, j), b = value(i + 1, j), c = value(i, j + 1),
                 d = value(i + 1, j + 1);
    gradient = {(1 - v) * (b - a) + v * (d - c), (1 - u) * (c - a) + u * (d - b)};
    return ((1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * c + u * d)) / scale_;
  }

 private:
  // Inside nothing is asked but that it is inside; only beside the edge, where it decides how the distance
  // grows, the way to the background counts: 1 or the root of 2. Farther in it is more than those.
  void note_inside(const cv::Mat& part) {
    constexpr float kDeeper = 2;
    cv::Mat beside, around;
    cv::erode(part, beside, cv::getStructuringElement(cv::MORPH_CROSS, {3, 3}));
    cv::erode(part, around, cv::getStructuringElement(cv::MORPH_RECT, {3, 3}));
    for (int y = 0; y < part.rows; ++y) {
      const std::uint8_t *in = part.ptr(y), *four = beside.ptr(y), *eight = around.ptr(y);
      float* d = distance_.ptr<float>(y);
      for (int x = 0; x < part.cols; ++x)
        if (in[x] != 0) d[x] = four[x] == 0 ? -1.F : eight[x] == 0 ? -std::numbers::sqrt2_v<float> : -kDeeper;
    }
  }
  // The edge lies between the two pixels that are nearest to each other.
  double value(int i, int j) const {
    const double d = static_cast<double>(distance_.at<float>(j, i));
    return d > 0 ? d - 0.5 : d + 0.5;
  }
  int scale_;
  Eigen::Vector2i origin_;
  cv::Mat distance_;
};

struct OutlinePoint {
  Vector3d ray;
  int witness = 0, stretch = 0;
};

// Where the point is after a small turn from the present one.
struct Moving {
  Vector2d pixel;
  Eigen::Matrix<double, 2, 3> by_turn;
};

std::vector<OutlinePoint> points_of(const CameraModel& model, const SilhouetteWitness& witness, int index,
                                    std::optional<std::size_t> wanted) {
  std::vector<OutlinePoint> out;
  const std::vector<Vector2d>& all = witness.own.points;
  const std::size_t step = wanted ? std::max<std::size_t>(1, all.size() / *wanted) : 1;
  for (std::size_t i = 0; i < all.size(); i += step) {
    const Vector2d& p = all[i];
    if (p.x() < kBorder || p.y() < kBorder || p.x() > model.width - kBorder || p.y() > model.height - kBorder)
      continue;
    if (const auto ray = unproject(model, p)) out.push_back({*ray, index});
  }
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i].stretch = index * kStretches + static_cast<int>(i * kStretches / out.size());
  return out;
}

std::optional<Moving> moving(const CameraModel& model, const Vector3d& ray) {
  const auto at = project(model, ray);
  if (!at) return std::nullopt;
  Moving out{*at, {}};
  constexpr double kStep = 1e-5;  // rad
  for (int k = 0; k < 3; ++k) {
    const auto there = project(model, ray + kStep * Vector3d::Unit(k).cross(ray));
    if (!there) return std::nullopt;
    out.by_turn.col(k) = (*there - *at) / kStep;
  }
  return out;
}

class SticksOut final : public ceres::SizedCostFunction<1, 3> {
 public:
  SticksOut(const DistanceField& field, const Moving& moving) : field_(field), moving_(moving) {}
  bool Evaluate(const double* const* turn, double* residual, double** jacobians) const override {
    Vector2d gradient;
    const double distance =
        field_.at(moving_.pixel + moving_.by_turn * Eigen::Map<const Vector3d>(turn[0]), gradient);
    residual[0] = std::max(distance, 0.0);
    if (jacobians == nullptr || jacobians[0] == nullptr) return true;
    Eigen::Map<Eigen::RowVector3d> by_turn(jacobians[0]);
    by_turn.setZero();
    if (distance > 0) by_turn = gradient.transpose() * moving_.by_turn;
    return true;
  }

 private:
  const DistanceField& field_;
  Moving moving_;
};

struct Fit {
  const CameraModel& model;
  std::vector<DistanceField> fields;
  std::vector<OutlinePoint> points;

  // One solution around `turn`, to which its step is added.
  void improve(Vector3d& turn, double scale) const {
    ceres::CauchyLoss loss(scale);
    const Matrix3d rotation = solver::rotation_from_vector(turn).toRotationMatrix();
    ceres::Problem::Options ownership;
    ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem problem(ownership);
    Vector3d step(0, 0, 0);
    for (const OutlinePoint& p : points)
      if (const auto m = moving(model, rotation * p.ray))
        problem.AddResidualBlock(new SticksOut(fields[static_cast<std::size_t>(p.witness)], *m), &loss,
                                 step.data());
    if (problem.NumResidualBlocks() == 0) return;
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
    options.max_num_iterations = 20;
    options.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    turn =
        solver::vector_from_rotation(solver::rotation_from_vector(step) * solver::rotation_from_vector(turn));
  }

  // Distances of all points, with their derivatives.
  template <class Visit>
  void visit(const Vector3d& turn, const Visit& each) const {
    const Matrix3d rotation = solver::rotation_from_vector(turn).toRotationMatrix();
    for (const OutlinePoint& p : points) {
      const auto m = moving(model, rotation * p.ray);
      if (!m) continue;
      Vector2d gradient;
      const double distance = fields[static_cast<std::size_t>(p.witness)].at(m->pixel, gradient);
      each(p, distance, Vector3d(m->by_turn.transpose() * gradient));
    }
  }

  double outside(const Vector3d& turn) const {
    double squares = 0;
    visit(turn, [&](const OutlinePoint&, double distance, const Vector3d&) {
      const double out = std::clamp(distance, 0.0, kFarthestOutside);
      squares += out * out;
    });
    return std::sqrt(squares / static_cast<double>(points.size()));
  }
};

// What remains when each stretch of outline is left out in turn, to first order.
std::optional<Matrix3d> jackknife(const Fit& fit, const Vector3d& turn, int stretches) {
  std::vector<Matrix3d> information(static_cast<std::size_t>(stretches), Matrix3d::Zero());
  std::vector<Vector3d> pull(information.size(), Vector3d::Zero());
  Matrix3d all = Matrix3d::Zero();
  fit.visit(turn, [&](const OutlinePoint& p, double distance, const Vector3d& slope) {
    if (distance <= 0) return;
    const double weight = 1 / (1 + distance * distance / (kLoss * kLoss));
    const auto at = static_cast<std::size_t>(p.stretch);
    information[at] += weight * slope * slope.transpose();
    pull[at] += weight * distance * slope;
  });
  for (const Matrix3d& one : information) all += one;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(all);
  if (!(eigen.eigenvalues()[0] > 1e-9 * eigen.eigenvalues()[2])) return std::nullopt;
  Matrix3d covariance = Matrix3d::Zero();
  for (std::size_t i = 0; i < information.size(); ++i) {
    const Vector3d step = (all - information[i] + 1e-6 * all).ldlt().solve(pull[i]);
    covariance += step * step.transpose();
  }
  const double n = stretches;
  return Matrix3d((n - 1) / n * covariance);
}

constexpr double degrees(double radians) { return 180 / std::numbers::pi * radians; }

}  // namespace

Rigid3 turned(const Rigid3& cam_from_world, const Vector3d& vector) {
  return Rigid3{solver::rotation_from_vector(vector), Vector3d::Zero()} * cam_from_world;
}

SilhouetteTurn measure_silhouette_turn(const CameraModel& model, std::span<const SilhouetteWitness> witnesses,
                                       std::optional<std::size_t> wanted) {
  SilhouetteTurn out;
  Fit fit{model, {}, {}};
  for (const SilhouetteWitness& witness : witnesses) {
    if (witness.own.empty() || witness.others.empty() || !(coverage(witness.others) > 0)) continue;
    const std::vector<OutlinePoint> points =
        points_of(model, witness, static_cast<int>(fit.fields.size()), wanted);
    fit.fields.emplace_back(witness);
    fit.points.insert(fit.points.end(), points.begin(), points.end());
  }
  out.points = static_cast<int>(fit.points.size());
  if (out.points < kFewestPoints) return out;
  out.outside_px = fit.outside(Vector3d::Zero());
  Vector3d turn(0, 0, 0);
  for (const double scale : kLosses) fit.improve(turn, scale);
  out.outside_after_px = fit.outside(turn);
  int gross = 0;
  fit.visit(turn, [&](const OutlinePoint&, double d, const Vector3d&) { gross += d > kFarthestOutside; });
  out.gross = static_cast<double>(gross) / out.points;
  const auto covariance = jackknife(fit, turn, static_cast<int>(fit.fields.size()) * kStretches);
  if (!covariance) return out;
  // The rays were turned to meet the picture of the rig; the camera is turned to meet its rays.
  out.known = true;
  out.vector = -turn;
  out.degrees = degrees(turn.norm());
  const Vector3d along = turn.norm() > 0 ? Vector3d(turn.normalized()) : Vector3d::UnitX();
  out.sigma_degrees = degrees(std::sqrt(along.dot(*covariance * along)));
  return out;
}

}  // namespace floatstage::calib
