// The solver's own opinion of how well it knows the cameras, against how it does.

#include "calib/solver/covariance.h"

#include <cmath>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "tests/calib/solver/solver_scenes.h"

namespace floatstage::calib::solver {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr double kNoise = 0.2;

TrueScene small_scene(std::uint64_t seed) {
  return true_scene(3, {.frames = 14, .noise_px = kNoise, .outliers = 0, .seed = seed, .frame_seconds = 0.4});
}

TEST(CameraCovariance, IsSymmetricAndPositiveSemidefinite) {
  const TrueScene s = small_scene(1);
  const MatrixXd m = camera_covariance(s.scene, {});
  ASSERT_EQ(m.rows(), 3 * kCameraParameters);
  EXPECT_LT((m - m.transpose()).norm(), 1e-12 * m.norm());
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<MatrixXd>(m).eigenvalues().minCoeff(), -1e-9 * m.norm());
}

TEST(CameraCovariance, IsNothingForWhatIsNotSolvedFor) {
  TrueScene s = small_scene(1);
  s.scene.cameras[1].intrinsics_fixed = true;
  const MatrixXd m = camera_covariance(s.scene, {});
  const auto variance = [&](int camera, Index k) {
    const Index at = kCameraParameters * camera + k;
    return m(at, at);
  };
  for (Index k = kIntrinsics; k < kIntrinsics + 6; ++k) {
    EXPECT_EQ(variance(0, k), 0) << "the first camera holds the world";
    EXPECT_GT(variance(1, k), 0);
  }
  for (Index k = 0; k < kIntrinsics; ++k) {
    EXPECT_EQ(variance(1, k), 0) << "its intrinsics are fixed";
    if (k >= kDenominatorRow)
      EXPECT_EQ(variance(2, k), 0) << "nobody asked for a denominator or a skew";
    else
      EXPECT_GT(variance(2, k), 0);
  }
  for (int camera = 0; camera < 3; ++camera)
    EXPECT_EQ(variance(camera, kCameraParameters - 1), 0) << "no time offsets";
  EXPECT_EQ(camera_covariance(s.scene, {.intrinsics = Freedom::None, .cameras_move = false}).norm(), 0);
}

TEST(CameraCovariance, GrowsWithTheSquareOfTheNoise) {
  TrueScene s = small_scene(1);
  for (SceneCamera& c : s.scene.cameras) c.noise = 1;
  const MatrixXd once = camera_covariance(s.scene, {});
  for (SceneCamera& c : s.scene.cameras) c.noise = 2;
  const MatrixXd twice = camera_covariance(s.scene, {});
  for (int camera = 1; camera < 3; ++camera)
    for (const Index k : {Index{0}, Index{1}, Index{kIntrinsics}, Index{kIntrinsics + 3}}) {
      const Index at = kCameraParameters * camera + k;
      EXPECT_NEAR(twice(at, at) / once(at, at), 4, 0.1) << "camera " << camera << ", parameter " << k;
    }
}

// Chi-squared over degrees of freedom of what solutions of independent captures are off by.
TEST(CameraCovariance, IsWhatSolutionsScatterBy) {
  double squares = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    TrueScene s = small_scene(seed);
    const BundleOptions options;
    ASSERT_TRUE(solve(s.scene, options).converged) << seed;
    const MatrixXd m = camera_covariance(s.scene, options);
    for (std::size_t c = 1; c < 3; ++c) {
      const Index at = kCameraParameters * static_cast<Index>(c);
      const SceneCamera& camera = s.scene.cameras[c];
      const Rigid3& truth = s.truth.cameras[c].cam_from_world;
      const Eigen::Vector3d turned =
          vector_from_rotation(camera.cam_from_world.rotation * truth.rotation.conjugate());
      for (Index k = 0; k < 3; ++k, ++count)
        squares += turned[k] * turned[k] / m(at + kIntrinsics + k, at + kIntrinsics + k);
      const double focal = camera.intrinsics[0] - s.truth.cameras[c].model.fx;
      squares += focal * focal / m(at, at);
      ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), 1, 0.2) << count << " numbers";
}

TEST(Redundancy, CountsRowsAndUnknowns) {
  const TrueScene s = small_scene(1);
  double rows = 0;
  for (const SceneView& v : s.scene.views) rows += 2.0 * static_cast<double>(v.points.size());
  const Redundancy r = redundancy(s.scene, {});
  EXPECT_EQ(r.rows, rows);
  // Three cameras' intrinsics without denominator and skew, the poses of two, and six numbers a board.
  EXPECT_EQ(r.unknowns, 3.0 * (kIntrinsics - 4) + 2 * 6 + 6.0 * static_cast<double>(s.scene.boards.size()));
  EXPECT_DOUBLE_EQ(r.share(), (r.rows - r.unknowns) / r.rows);
  EXPECT_EQ((Redundancy{.rows = 3, .unknowns = 5}.share()), 0) << "too little to solve";
}

}  // namespace
}  // namespace floatstage::calib::solver
