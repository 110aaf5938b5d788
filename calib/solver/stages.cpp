// Method:  from a loose solution to a full one, outliers out and
//          back in, noise measured on the way
// Paper:   W. Förstner's estimate of variance components
// Differs: no camera is trusted more than is usual in its rig
// ADR:     0114

#include "calib/solver/stages.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>

#include "calib/solver/covariance.h"
#include "calib/solver/lens_terms.h"
#include "calib/solver/linearize.h"
#include "calib/solver/timing.h"
#include "core/parallel.h"
#include "core/statistics.h"

namespace floatstage::calib::solver {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// Of each camera's rows the share that the solution left free: without it the camera that boards follow most
// would seem the best, be trusted more, and draw the boards to itself altogether (Förstner's estimate of
// variance components).
std::vector<double> free_shares(const Scene& scene, const BundleOptions& options) {
  std::vector<double> rows(scene.cameras.size()), taken(scene.cameras.size()), timed(scene.views.size());
  std::vector<Eigen::MatrixXd> boards(scene.boards.size()), own(scene.views.size());
  for (std::size_t b = 0; b < boards.size(); ++b) {
    const Eigen::Index width = scene.boards[b].free_motion ? 12 : 6;
    boards[b].setZero(width, width);
    if (width == 12) boards[b].diagonal().tail<6>() = motion_weights(scene.boards[b]).cwiseAbs2();
  }
  parallel_for(scene.views.size(), options.threads, [&](std::size_t i) {
    LinearView linear;
    const SceneView& v = scene.views[i];
    if (v.board < 0 || !usable(scene, v)) return;
    linearize(scene, v, options.loss, true, linear);
    if (!linear.valid) return;
    own[i] = linear.by_object.transpose() * linear.by_object;
    if (linear.jitter_sigma > 0) timed[i] = 1 - std::pow(linear.jitter_sigma / scene.jitter_sigma, 2);
  });
  for (std::size_t i = 0; i < scene.views.size(); ++i)
    if (own[i].size() > 0) boards[at(scene.views[i].board)] += own[i];
  for (std::size_t i = 0; i < scene.views.size(); ++i) {
    const SceneView& v = scene.views[i];
    if (!usable(scene, v)) continue;
    rows[at(v.camera)] +=
        2.0 * static_cast<double>(std::count_if(v.points.begin(), v.points.end(),
                                                [](const ScenePoint& p) { return p.kept; }));
    if (own[i].size() > 0) taken[at(v.camera)] += timed[i] + boards[at(v.board)].ldlt().solve(own[i]).trace();
  }
  // Markers are a small part of any capture; they take theirs evenly.
  const double all = redundancy(scene, options).share();
  std::vector<double> shares;
  for (std::size_t c = 0; c < rows.size(); ++c) {
    taken[c] += static_cast<double>(free_parameters(scene, static_cast<int>(c), options).count());
    shares.push_back(scene.markers.empty() ? (rows[c] > taken[c] ? 1 - taken[c] / rows[c] : 0) : all);
  }
  return shares;
}

constexpr int kTimedRounds = 12;       // how boards move follows where they are
constexpr double kFirstJitter = 0.05;  // periods
constexpr int kRounds = 4;             // of leaving out and taking back; the set hardly changes after two

void settle(Scene& scene, BundleOptions& bundle, const CalibrationOptions& options) {
  const int rounds = bundle.offsets ? kTimedRounds : kRounds;
  for (int round = 0; round < rounds; ++round) {
    if (bundle.offsets) {
      if (round > 0) regroup(scene);
      estimate_motion(scene);
      if (round > 0) free_motion(scene);
      if (round > 0 && scene.jitter_sigma == 0) scene.jitter_sigma = kFirstJitter * scene.period;
    }
    solve(scene, bundle);
    measure_noise(scene, bundle);
    if (bundle.offsets && round > 0) measure_timing(scene);
    const bool other_lens = drop_folding_terms(scene);
    if (select_inliers(scene, options.outlier_sigmas) == 0 && !other_lens &&
        !(bundle.offsets && round < kTimedRounds / 2))
      break;
    bundle.iterations = 15;
  }
  solve(scene, bundle);
}

}  // namespace

int select_inliers(Scene& scene, double sigmas) {
  int changed = 0;
  for (SceneView& v : scene.views) {
    if (!usable(scene, v)) continue;
    const double noise = scene.cameras[at(v.camera)].noise;
    const std::vector<Eigen::Vector2d> errors = errors_of(scene, v);
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const bool keep = errors[i].norm() < sigmas * noise * v.points[i].sigma;
      changed += keep != v.points[i].kept;
      v.points[i].kept = keep;
    }
  }
  return changed;
}

void measure_noise(Scene& scene, const BundleOptions& options) {
  std::vector<std::vector<double>> squares(scene.cameras.size());
  for (const SceneView& v : scene.views) {
    if (!usable(scene, v)) continue;
    const std::vector<Eigen::Vector2d> errors = errors_of(scene, v);
    for (std::size_t i = 0; i < errors.size(); ++i)
      if (std::isfinite(errors[i].norm()))
        squares[at(v.camera)].push_back(errors[i].squaredNorm() / (v.points[i].sigma * v.points[i].sigma));
  }
  // What was solved for has taken up its share of the errors: of each board as much as a camera knew of it.
  const std::vector<double> shares = free_shares(scene, options);
  for (std::size_t c = 0; c < squares.size(); ++c) {
    const std::vector<double>& s = squares[c];
    if (s.empty()) continue;
    // The median of a squared length of two normal numbers is 2 ln 2; from there the mean of what is no
    // outlier.
    const double robust = median(s) / (2 * std::log(2.0)), limit = 4.5 * 4.5 * robust;
    double sum = 0;
    int count = 0;
    for (const double q : s)
      if (q < limit) {
        sum += q;
        ++count;
      }
    const double variance = count > 0 ? sum / (2.0 * count * std::max(0.1, shares[c])) : 1;
    scene.cameras[c].noise = std::clamp(std::sqrt(variance), 0.02, 1000.0);
  }
  // No camera is trusted more than is usual in its rig: where cameras contradict one another (they are not
  // synchronous, say), one of them would otherwise win the boards for itself. One that is worse is trusted
  // less.
  std::vector<double> trust;
  for (std::size_t c = 0; c < squares.size(); ++c)
    if (!squares[c].empty()) trust.push_back(1 / scene.cameras[c].noise);
  if (trust.empty()) return;
  const double usual = 1 / median(std::move(trust));
  constexpr double kWorst = 30;  // a camera that is a frame late
  for (SceneCamera& c : scene.cameras) c.noise = std::clamp(c.noise, usual, kWorst * usual);
}

BundleOptions solve_in_stages(Scene& scene, const CalibrationOptions& options) {
  BundleOptions bundle{.threads = options.threads};
  // A start may be off by tens of pixels; a lens by as many at the border.
  for (SceneCamera& c : scene.cameras) c.noise = 1;
  measure_noise(scene, bundle);
  bundle.loss.cauchy = 2;
  bundle.intrinsics = Freedom::Focal;
  bundle.iterations = 12;
  solve(scene, bundle);
  measure_noise(scene, bundle);
  bundle.intrinsics = Freedom::All;
  bundle.iterations = 30;
  solve(scene, bundle);
  measure_noise(scene, bundle);
  select_inliers(scene, 2 * options.outlier_sigmas);
  drop_folding_terms(scene);
  solve(scene, bundle);
  measure_noise(scene, bundle);
  select_inliers(scene, options.outlier_sigmas);
  BundleOptions settled = solve_again(scene, options);
  if (drop_unshown_third(scene, settled)) settled = solve_again(scene, options);
  // Numerator and denominator are told from one another by little: solved for together from 0 they would run
  // away.
  if (!admit_denominators(scene)) return settled;
  select_inliers(scene, 4 * options.outlier_sigmas);  // without it a border may have looked wrong
  bundle.iterations = 50;
  solve(scene, bundle);
  measure_noise(scene, bundle);
  select_inliers(scene, options.outlier_sigmas);
  do settled = solve_again(scene, options);
  while (drop_unshown_denominators(scene, settled));
  return settled;
}

BundleOptions solve_again(Scene& scene, const CalibrationOptions& options) {
  BundleOptions bundle{.offsets = options.time_offsets, .iterations = 30, .threads = options.threads};
  settle(scene, bundle, options);
  return bundle;
}

}  // namespace floatstage::calib::solver
