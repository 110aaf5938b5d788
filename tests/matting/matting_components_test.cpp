#include <cmath>

#include <Eigen/LU>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "matting/spectral/k_means.h"
#include "matting/spectral/sparse_components.h"
#include "matting/spectral/spectral_matting.h"
#include "tests/matting/small_scenes.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

constexpr int kWidth = 90, kHeight = 60;

EigenPairs pairs_of(const Image& picture, const EigenPairs* previous = nullptr) {
  auto solver = EigenSolver::create(picture.width, picture.height);
  EXPECT_THAT(solver, IsOk());
  auto pairs = solver->solve(picture, previous);
  EXPECT_THAT(pairs, IsOk());
  return pairs ? *pairs : EigenPairs{};
}

MattingComponents components_of(const Image& picture, const SpectralOptions& options = {},
                                const MattingComponents* previous = nullptr) {
  auto components = matting_components(pairs_of(picture), options, previous);
  EXPECT_THAT(components, IsOk());
  return components ? *components : MattingComponents{};
}

Image oracle_matte(const MattingComponents& components, const Image& truth) {
  const auto selection = select_components(components, {{{truth, {}}, 1}});
  EXPECT_THAT(selection, IsOk());
  return matte_of(components, selection->chosen);
}

TEST(KMeans, FindsBlobsWhateverTheSeed) {
  Random noise(3);
  Eigen::MatrixXf points(2, 300);
  for (int i = 0; i < 300; ++i)
    points.col(i) << static_cast<float>(10 * (i % 3) + noise.normal()), static_cast<float>(noise.normal());
  for (std::uint64_t seed : {1, 2, 3, 4}) {
    Random random(seed);
    const Clusters found = k_means(points, 3, 4, random);
    for (int i = 3; i < 300; ++i) EXPECT_EQ(found.labels[i], found.labels[i % 3]);
    EXPECT_NE(found.labels[0], found.labels[1]);
    EXPECT_NE(found.labels[1], found.labels[2]);
  }
}

TEST(KMeans, GivesACentreWithoutPointsTheFarthestOne) {
  Eigen::MatrixXf points(1, 4), centres(1, 3);
  points << 0, 1, 2, 50;
  centres << 0, 1, 900;
  const Clusters found = refine_clusters(points, centres, 10);
  EXPECT_EQ(found.labels, (std::vector<int>{0, 0, 1, 2}));
  EXPECT_NEAR(found.error, 0.5, 1e-6);
}

TEST(SparseComponents, PullsMixturesOfStepsApart) {
  // Three eigenvectors that mix three indicators; the start is a poor guess.
  Eigen::MatrixXf indicators = Eigen::MatrixXf::Zero(3, 120);
  for (int i = 0; i < 120; ++i) indicators(i / 40, i) = 1;
  Eigen::Matrix3f mix;
  mix << 1, 1, 1, 1, -1, 0.5f, 0.3f, 1, -1;
  const Eigen::MatrixXf samples = mix * indicators;
  Eigen::MatrixXd start = mix.cast<double>().inverse().transpose();
  start.col(0) += 0.3 * start.col(1);
  start.col(1) *= 0.7;
  const Eigen::VectorXd ones = mix.cast<double>().inverse().transpose() * Eigen::Vector3d::Ones();
  const Eigen::MatrixXd y = sparse_components(samples, start, ones, {0.9, 40});
  const Eigen::MatrixXd alpha = y.transpose() * samples.cast<double>();
  EXPECT_LT((alpha - indicators.cast<double>()).cwiseAbs().maxCoeff(), 0.01);
}

TEST(MattingComponents, SumToOneAndAreMostlyZeroOrOne) {
  const MattingComponents components = components_of(disc_picture(kWidth, kHeight).rgb);
  ASSERT_EQ(components.count(), 10);
  EXPECT_LT((components.alpha.rowwise().sum().array() - 1).abs().maxCoeff(), 2e-3f);
  const auto decided =
      (components.alpha.array().abs() < 0.05f || (components.alpha.array() - 1).abs() < 0.05f);
  EXPECT_GT(static_cast<double>(decided.count()), 0.85 * static_cast<double>(components.alpha.size()));
}

TEST(MattingComponents, ContainTheSubjectWithItsSoftEdge) {
  const DiscPicture scene = disc_picture(kWidth, kHeight);
  EXPECT_LT(mean_square(oracle_matte(components_of(scene.rgb), scene.alpha), scene.alpha), 2e-3);
}

TEST(MattingComponents, LoseLittleWhenEverySecondPixelCounts) {
  const DiscPicture scene = disc_picture(kWidth, kHeight);
  const Image fast = oracle_matte(components_of(scene.rgb), scene.alpha);
  const Image reference = oracle_matte(components_of(scene.rgb, {.newton_stride = 1}), scene.alpha);
  EXPECT_LT(mean_square(fast, scene.alpha), mean_square(reference, scene.alpha) + 5e-4);
}

TEST(MattingComponents, ContinueThoseOfThePreviousFrame) {
  const DiscPicture before = disc_picture(kWidth, kHeight), after = disc_picture(kWidth, kHeight, 2);
  const MattingComponents first = components_of(before.rgb), second = components_of(after.rgb, {}, &first);
  const auto chosen = select_components(first, {{{before.alpha, {}}, 1}});
  ASSERT_THAT(chosen, IsOk());
  EXPECT_LT(mean_square(matte_of(second, chosen->chosen), after.alpha), 4e-3) << "one choice lasts";
}

TEST(MattingComponents, SayWhatDoesNotFit) {
  const EigenPairs pairs = pairs_of(disc_picture(kWidth, kHeight).rgb);
  EXPECT_THAT(matting_components(pairs, {.eigenvectors = 100}), FailsWith(ErrorCode::InvalidArgument, "100"));
  EXPECT_THAT(matting_components(pairs, {.sparsity = 1}), FailsWith(ErrorCode::InvalidArgument, "sparsity"));
  const auto ten = matting_components(pairs);
  ASSERT_THAT(ten, IsOk());
  EXPECT_THAT(matting_components(pairs, {.components = 6}, &*ten),
              FailsWith(ErrorCode::InvalidArgument, "10 components"));
}

}  // namespace
}  // namespace floatstage::matting
