// Method:  terms of a lens are kept where the capture shows them, by Wald's test
// Paper:   A. Wald, "Tests of statistical hypotheses concerning several parameters", 1943
// Differs: the three terms of a denominator are asked about together: each alone is hardly told from the
//          numerator's
// ADR:     0225, 0247

#include "calib/solver/lens_terms.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include "calib/solver/covariance.h"

namespace floatstage::calib::solver {
namespace {

constexpr int kThirdRow = kRadialRows[2];
constexpr int kDenominators = 3;

// Of a number of normal errors the sum of squares in sigmas, beyond which chance is as rare (0.27 %) as three
// sigmas of one are.
constexpr std::array<double, 1 + kDenominators> kShown = {0, 9, 11.83, 14.16};

// The curve of a Brown-Conrady lens must still rise at the corners of its picture.
bool covers_picture(const SceneCamera& c) {
  if (c.lens != LensKind::BrownConrady) return true;
  const CameraModel model = unpack(c.intrinsics, c.lens, c.width, c.height);
  for (const double x : {0.0, 1.0 * c.width})
    for (const double y : {0.0, 1.0 * c.height})
      if (!unproject(model, {x, y})) return false;
  return true;
}

void hold_third(SceneCamera& c) {
  c.held[kThirdRow] = true;
  c.intrinsics[kThirdRow] = 0;
}

bool frees_denominator(const SceneCamera& c) {
  return c.denominator_terms > 0 && !c.held.segment<kDenominators>(kDenominatorRow).all();
}

// The numerator belongs to its denominator: without it the lens of before is the better start.
void hold_denominator(SceneCamera& c) {
  c.held.segment<kDenominators>(kDenominatorRow).setConstant(true);
  c.held[kThirdRow] = c.third_was_held;
  c.intrinsics = c.without_denominator;
}

// A shorter quotient of the lens folds over less: k3 and the last of the denominator's terms go first.
void shorten(SceneCamera& c) {
  Eigen::Index last = kDenominatorRow + kDenominators - 1;
  while (c.held[last]) --last;
  if (last == kDenominatorRow) return hold_denominator(c);
  hold_third(c);
  c.held[last] = true;
  c.intrinsics[last] = 0;
}

bool is_solved_for(const SceneCamera& c) { return !c.intrinsics_fixed && c.lens_of < 0 && c.placed; }

// A camera's denominator in sigmas, squared, against what chance would do. `own`: the covariance of its
// intrinsics.
bool shows_denominator(const SceneCamera& c, const Eigen::MatrixXd& own) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = kDenominatorRow; k < kDenominatorRow + kDenominators; ++k)
    if (!c.held[k]) free.push_back(k);
  const Eigen::MatrixXd covariance = own(free, free);
  const Eigen::VectorXd terms = c.intrinsics(free);
  // What hardly anything is known of has the largest sigma; its rounding must not look like knowledge.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
  constexpr double kRounding = 1e-12;
  const double least = kRounding * eigen.eigenvalues().maxCoeff();
  const Eigen::VectorXd along = eigen.eigenvectors().transpose() * terms;
  double squares = 0;
  for (Eigen::Index i = 0; i < along.size(); ++i)
    squares += along[i] * along[i] / std::max(eigen.eigenvalues()[i], least);
  return squares >= kShown[free.size()];
}

}  // namespace

bool drop_folding_terms(Scene& scene) {
  bool any = false;
  for (SceneCamera& c : scene.cameras) {
    if (!is_solved_for(c) || c.held[kThirdRow] || frees_denominator(c) || covers_picture(c)) continue;
    hold_third(c);
    any = true;
  }
  return any;
}

// A third radial term is a guess at the picture's border where the capture does not show it: without it the
// lens is known better, and formats with two terms hold it.
bool drop_unshown_third(Scene& scene, const BundleOptions& solved) {
  constexpr double kThirdShown = 3;
  if (std::none_of(scene.cameras.begin(), scene.cameras.end(),
                   [](const SceneCamera& c) { return c.third_if_shown && !c.held[kThirdRow]; }))
    return false;
  const Eigen::MatrixXd covariance = camera_covariance(scene, solved);
  bool any = false;
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
    SceneCamera& c = scene.cameras[i];
    if (c.intrinsics_fixed || !c.third_if_shown || c.held[kThirdRow] || !c.placed) continue;
    const Eigen::Index row = kCameraParameters * static_cast<Eigen::Index>(i) + kThirdRow;
    if (std::abs(c.intrinsics[kThirdRow]) >= kThirdShown * std::sqrt(covariance(row, row))) continue;
    hold_third(c);
    any = true;
  }
  return any;
}

bool admit_denominators(Scene& scene) {
  bool any = false;
  for (SceneCamera& c : scene.cameras) {
    if (!is_solved_for(c) || c.denominator_terms == 0) continue;
    c.without_denominator = c.intrinsics;
    c.third_was_held = c.held[kThirdRow];
    c.held[kThirdRow] = false;  // a polynomial folds over where a quotient does not
    c.held.segment(kDenominatorRow, c.denominator_terms).setConstant(false);
    any = true;
  }
  return any;
}

bool drop_unshown_denominators(Scene& scene, const BundleOptions& solved) {
  if (std::none_of(scene.cameras.begin(), scene.cameras.end(), frees_denominator)) return false;
  const Eigen::MatrixXd covariance = camera_covariance(scene, solved);
  bool any = false;
  for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
    SceneCamera& c = scene.cameras[i];
    if (!is_solved_for(c) || !frees_denominator(c)) continue;
    const Eigen::Index row = kCameraParameters * static_cast<Eigen::Index>(i);
    if (!covers_picture(c))
      shorten(c);
    else if (!shows_denominator(c, covariance.block(row, row, kIntrinsics, kIntrinsics)))
      hold_denominator(c);
    else
      continue;
    any = true;
  }
  return any;
}

}  // namespace floatstage::calib::solver
