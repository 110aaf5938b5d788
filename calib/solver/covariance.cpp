// Method:  the cameras' covariance: the inverse of the Schur
//          complement of boards and markers
// Paper:   B. Triggs and others, "Bundle adjustment: a modern synthesis", 2000, section 6
// Differs: weak priors take part; directions that are nothing but rounding stay out
// ADR:     none; docs/algorithms/calibration.md

#include "calib/solver/covariance.h"

#include <algorithm>
#include <map>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace floatstage::calib::solver {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

bool has_kept(const SceneView& v) {
  return std::any_of(v.points.begin(), v.points.end(), [](const ScenePoint& p) { return p.kept; });
}

// Views by what they show, so that one object after the other can be eliminated.
std::map<std::pair<bool, int>, std::vector<const SceneView*>> by_object(const Scene& scene) {
  std::map<std::pair<bool, int>, std::vector<const SceneView*>> groups;
  for (const SceneView& v : scene.views)
    if (usable(scene, v) && has_kept(v))
      groups[{v.board >= 0, v.board >= 0 ? v.board : v.markers}].push_back(&v);
  return groups;
}

MatrixXd by_parameters(const LinearView& linear) {
  MatrixXd j(linear.residual.size(), kCameraParameters);
  j << linear.by_intrinsics, linear.by_camera, linear.by_offset;
  return j;
}

// Eigenvalues that are nothing but rounding are directions of which nothing is known; they stay out.
MatrixXd inverse(const MatrixXd& m) {
  const Eigen::VectorXd scale = m.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scale.asDiagonal() * m * scale.asDiagonal());
  const double smallest = 1e-13 * eigen.eigenvalues().cwiseAbs().maxCoeff();
  const Eigen::VectorXd inverted =
      eigen.eigenvalues().unaryExpr([&](double v) { return v > smallest ? 1 / v : 1 / smallest; });
  return scale.asDiagonal() * eigen.eigenvectors() * inverted.asDiagonal() *
         eigen.eigenvectors().transpose() * scale.asDiagonal();
}

}  // namespace

std::vector<Index> free_rows(const Scene& scene, const BundleOptions& options) {
  std::vector<Index> free;
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    if (!scene.cameras[c].placed) continue;
    const CameraMask mask = free_parameters(scene, static_cast<int>(c), options);
    for (Index k = 0; k < kCameraParameters; ++k)
      if (mask[k]) free.push_back(kCameraParameters * static_cast<Index>(c) + k);
  }
  return free;
}

namespace {

void add_distances(const Scene& scene, MatrixXd& information) {
  for (const SceneDistance& d : scene.distances) {
    const Eigen::Matrix<double, 1, 12> row =
        linearize_distance(d, scene.cameras[static_cast<std::size_t>(d.a)].cam_from_world,
                           scene.cameras[static_cast<std::size_t>(d.b)].cam_from_world)
            .by_poses;
    const Index at[] = {kCameraParameters * d.a + kIntrinsics, kCameraParameters * d.b + kIntrinsics};
    for (int i = 0; i < 2; ++i)
      for (int k = 0; k < 2; ++k)
        information.block<6, 6>(at[i], at[k]) += row.segment<6>(6 * i).transpose() * row.segment<6>(6 * k);
  }
}

// What is known of an object beside its views.
MatrixXd own_knowledge(const Scene& scene, const SceneMarkers* markers, const SceneBoard* board) {
  const Index width = markers              ? 3 * static_cast<Index>(markers->positions.size())
                      : board->free_motion ? 12
                                           : 6;
  MatrixXd own = MatrixXd::Zero(width, width);
  if (markers) {
    MatrixXd by_positions;
    marker_residual(*markers, scene.targets[static_cast<std::size_t>(markers->target)], &by_positions);
    own += by_positions.transpose() * by_positions;
  }
  if (board && board->free_motion) own.diagonal().tail<6>() += motion_weights(*board).cwiseAbs2();
  return own;
}

// The views of one board or of one instant's markers, with the object eliminated (Schur complement). At the
// solution an object's own gradient is 0: what is left of the cameras' is theirs.
ObjectPart part_of(const Scene& scene, bool is_board, int object, const std::vector<const SceneView*>& views,
                   Loss loss) {
  ObjectPart part{is_board, object, {}, {}, {}};
  const SceneMarkers* markers = is_board ? nullptr : &scene.markers[static_cast<std::size_t>(object)];
  const SceneBoard* board = is_board ? &scene.boards[static_cast<std::size_t>(object)] : nullptr;
  if (markers && views.size() < 2)
    return part;  // one ray says nothing of its camera, and cannot place its points
  const MatrixXd known = own_knowledge(scene, markers, board);
  MatrixXd own = MatrixXd::Zero(known.rows(), known.cols());
  struct Shared {
    Index camera;
    MatrixXd own, block;  // by the camera alone, and with the object
    Eigen::VectorXd gradient;
  };
  std::vector<Shared> shared;
  for (const SceneView* v : views) {
    LinearView linear;
    linearize(scene, *v, loss, true, linear);
    if (!linear.valid) continue;
    const MatrixXd j = by_parameters(linear);
    shared.push_back(
        {v->camera, j.transpose() * j, j.transpose() * linear.by_object, j.transpose() * linear.residual});
    own += linear.by_object.transpose() * linear.by_object;
  }
  own += known;
  const Eigen::LDLT<MatrixXd> solved(own);
  std::vector<MatrixXd> eliminated;
  for (const Shared& s : shared) eliminated.push_back(solved.solve(s.block.transpose()));
  const Index size = kCameraParameters * static_cast<Index>(shared.size());
  part.information.setZero(size, size);
  part.gradient.resize(size);
  for (std::size_t i = 0; i < shared.size(); ++i) {
    const Index row = kCameraParameters * static_cast<Index>(i);
    // What cameras say of one lens stands in the rows of the one that owns it.
    const Index lens = lens_owner(scene.cameras, static_cast<int>(shared[i].camera));
    for (Index k = 0; k < kCameraParameters; ++k)
      part.rows.push_back(kCameraParameters * (k < kIntrinsics ? lens : shared[i].camera) + k);
    part.gradient.segment<kCameraParameters>(row) = shared[i].gradient;
    part.information.block<kCameraParameters, kCameraParameters>(row, row) = shared[i].own;
    for (std::size_t k = 0; k < shared.size(); ++k)
      part.information.block<kCameraParameters, kCameraParameters>(
          row, kCameraParameters * static_cast<Index>(k)) -= shared[i].block * eliminated[k];
  }
  return part;
}

// A lens is as well known in every camera that has it.
void share_lenses(const Scene& scene, MatrixXd& covariance) {
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    if (scene.cameras[c].lens_of < 0) continue;
    const Index to = kCameraParameters * static_cast<Index>(c),
                from = kCameraParameters * static_cast<Index>(scene.cameras[c].lens_of);
    covariance.middleRows(to, kIntrinsics) = covariance.middleRows(from, kIntrinsics).eval();
    covariance.middleCols(to, kIntrinsics) = covariance.middleCols(from, kIntrinsics).eval();
  }
}

// What is known of lenses beside the views.
void add_lens_knowledge(const Scene& scene, MatrixXd& information) {
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    const SceneCamera& camera = scene.cameras[c];
    const Index at = kCameraParameters * static_cast<Index>(c);
    information.diagonal().segment<kIntrinsics>(at) +=
        prior_sigmas(camera).cwiseMax(1e-12).cwiseAbs2().cwiseInverse();
    if (!camera.plain_lens || !(camera.intrinsics[1] > 0)) continue;
    const double fx = camera.intrinsics[0], fy = camera.intrinsics[1];
    const double weight = camera.start[1] / camera.start[0] / (fy * kPixelShapeSigma);
    const Eigen::RowVector2d row(weight, -weight * fx / fy);
    information.block<2, 2>(at, at) += row.transpose() * row;
  }
}

}  // namespace

std::vector<std::pair<bool, int>> seen_objects(const Scene& scene) {
  std::vector<std::pair<bool, int>> objects;
  for (const auto& [object, views] : by_object(scene)) objects.push_back(object);
  return objects;
}

MatrixXd camera_information(const Scene& scene, const BundleOptions& options, const PartVisit& also) {
  const Index size = kCameraParameters * static_cast<Index>(scene.cameras.size());
  MatrixXd information = MatrixXd::Zero(size, size);
  add_distances(scene, information);
  for (const auto& [object, views] : by_object(scene)) {
    const ObjectPart p = part_of(scene, object.first, object.second, views, options.loss);
    for (std::size_t k = 0; k < p.rows.size(); ++k)  // a camera may be among an object's several times
      for (std::size_t i = 0; i < p.rows.size(); ++i)
        information(p.rows[i], p.rows[k]) += p.information(static_cast<Index>(i), static_cast<Index>(k));
    if (also) also(p);
  }
  add_lens_knowledge(scene, information);
  return information;
}

MatrixXd camera_covariance(const Scene& scene, const BundleOptions& options) {
  const MatrixXd information = camera_information(scene, options);
  const Index size = information.rows();
  const std::vector<Index> free = free_rows(scene, options);
  MatrixXd result = MatrixXd::Zero(size, size);
  if (free.empty()) return result;
  const MatrixXd reduced = information(free, free);
  result(free, free) = inverse(0.5 * (reduced + reduced.transpose()));
  share_lenses(scene, result);
  return result;
}

Redundancy redundancy(const Scene& scene, const BundleOptions& options) {
  Redundancy r;
  for (const auto& [object, views] : by_object(scene)) {
    for (const SceneView* v : views)
      r.rows += 2.0 * static_cast<double>(std::count_if(v->points.begin(), v->points.end(),
                                                        [](const ScenePoint& p) { return p.kept; }));
    if (object.first) {
      r.unknowns += 6;  // a motion that is solved for is measured by its neighbours: one row an unknown
      continue;
    }
    const SceneMarkers& markers = scene.markers[static_cast<std::size_t>(object.second)];
    r.unknowns += 3.0 * static_cast<double>(markers.positions.size());
    r.rows += static_cast<double>(
        marker_residual(markers, scene.targets[static_cast<std::size_t>(markers.target)], nullptr).size());
  }
  for (std::size_t c = 0; c < scene.cameras.size(); ++c)
    if (scene.cameras[c].placed)
      r.unknowns += static_cast<double>(free_parameters(scene, static_cast<int>(c), options).count());
  return r;
}

}  // namespace floatstage::calib::solver
