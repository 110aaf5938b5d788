#pragma once

#include <functional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "calib/solver/bundle.h"

namespace floatstage::calib::solver {

/// Covariance of all cameras' parameters at a solution, kCameraParameters rows a camera, zero for what was
/// not solved for: the inverse of the Schur complement of boards and markers, weak priors included. Positive
/// semidefinite.
Eigen::MatrixXd camera_covariance(const Scene& scene, const BundleOptions& options);

/// What one board or one instant's markers say of the cameras, itself eliminated: rows of the cameras'
/// parameters (a camera's may come twice), information about them and the gradient of half the squares.
struct ObjectPart {
  bool is_board = false;
  int object = 0;
  std::vector<Eigen::Index> rows;
  Eigen::MatrixXd information;
  Eigen::VectorXd gradient;
};
/// Shown one after the other: a point that eighty cameras see takes 13 MB.
using PartVisit = std::function<void(const ObjectPart&)>;

/// Boards (true) and markers, by their index in the scene, that some kept view shows: those that have a part.
std::vector<std::pair<bool, int>> seen_objects(const Scene& scene);

/// All parts together, with known distances and the weak priors.
/// `also` sees each part.
Eigen::MatrixXd camera_information(const Scene& scene, const BundleOptions& options,
                                   const PartVisit& also = {});

/// The rows of what is solved for.
std::vector<Eigen::Index> free_rows(const Scene& scene, const BundleOptions& options);

/// Numbers measured and numbers solved for: what the sum of squares is expected to be.
struct Redundancy {
  double rows = 0, unknowns = 0;
  double share() const { return rows > unknowns ? (rows - unknowns) / rows : 0; }
};
Redundancy redundancy(const Scene& scene, const BundleOptions& options);

}  // namespace floatstage::calib::solver
