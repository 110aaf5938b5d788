#include "matting/spectral/spectral_cache.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/support/matchers.h"

namespace floatstage::matting {
namespace {

EigenPairs some_pairs() {
  Random random(4);
  EigenPairs pairs{7, 5, Eigen::VectorXd(3), Eigen::MatrixXf(35, 3), 1.25e-6};
  for (Eigen::Index i = 0; i < 3; ++i) pairs.values(i) = random.uniform();
  for (Eigen::Index i = 0; i < pairs.vectors.size(); ++i)
    pairs.vectors(i) = static_cast<float>(random.uniform(-1, 1));
  pairs.vectors.col(2).setZero();
  return pairs;
}

TEST(SpectralCache, GivesBackWhatWasRounded) {
  EigenPairs pairs = some_pairs();
  const Eigen::MatrixXf exact = pairs.vectors;
  quantize(pairs.vectors);
  EXPECT_LT((pairs.vectors - exact).cwiseAbs().maxCoeff(), 1.0f / 60000);
  std::uint64_t key = 0;
  const auto back = parse_eigenpairs(to_bytes(pairs, 99), key, "file");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(key, 99u);
  EXPECT_EQ(back->width, 7);
  EXPECT_EQ(back->height, 5);
  EXPECT_EQ(back->residual, 1.25e-6);
  EXPECT_EQ(back->values, pairs.values);
  EXPECT_EQ(back->vectors, pairs.vectors) << "bit by bit";
}

TEST(SpectralCache, KeepsComponents) {
  MattingComponents components{7, 5, some_pairs().vectors};
  quantize(components.alpha);
  std::uint64_t key = 0;
  const auto back = parse_components(to_bytes(components, 5), key, "file");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->alpha, components.alpha);
}

TEST(SpectralCache, RefusesEveryTruncation) {
  const std::string bytes = to_bytes(some_pairs(), 1);
  std::uint64_t key = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size)
    ASSERT_THAT(parse_eigenpairs(std::string_view(bytes).substr(0, size), key, "a.eigen"),
                FailsWith(ErrorCode::BadData, "a.eigen"));
  EXPECT_THAT(parse_eigenpairs(bytes + "x", key, "a.eigen"), FailsWith(ErrorCode::BadData, "cut off"));
}

TEST(SpectralCache, RefusesEveryFlippedBit) {
  const std::string bytes = to_bytes(some_pairs(), 1);
  std::uint64_t key = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = static_cast<char>(damaged[i] ^ 16);
    ASSERT_FALSE(parse_eigenpairs(damaged, key, "file")) << "byte " << i;
  }
}

TEST(SpectralCache, TellsKindsApart) {
  std::uint64_t key = 0;
  EXPECT_THAT(parse_components(to_bytes(some_pairs(), 1), key, "file"),
              FailsWith(ErrorCode::BadData, "kind"));
}

}  // namespace
}  // namespace floatstage::matting
