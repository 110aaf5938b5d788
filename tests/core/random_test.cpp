#include "core/random.h"

#include <algorithm>
#include <set>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace floatstage {
namespace {

TEST(Random, GivesSplitMix64sPublishedSequence) {
  Random random(0);
  std::vector<std::uint64_t> first;
  for (int i = 0; i < 5; ++i) first.push_back(random.next());
  EXPECT_THAT(first, testing::ElementsAre(0xE220A8397B1DCDAFu, 0x6E789E6AA1B965F4u, 0x06C45D188009454Fu,
                                          0xF88BB8A8724C81ECu, 0x1B39896A51A8749Bu));
}

TEST(Random, IsUniformInItsInterval) {
  Random random(1);
  double sum = 0, least = 1, most = 0;
  constexpr int kDraws = 100'000;
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.uniform();
    sum += u;
    least = std::min(least, u);
    most = std::max(most, u);
  }
  EXPECT_GE(least, 0);
  EXPECT_LT(most, 1);
  EXPECT_LT(least, 1e-3);
  EXPECT_GT(most, 1 - 1e-3);
  EXPECT_NEAR(sum / kDraws, 0.5, 0.005);
}

TEST(Random, StretchesToTheAskedInterval) {
  Random a(5), b(5);
  for (int i = 0; i < 100; ++i) EXPECT_DOUBLE_EQ(a.uniform(-2, 6), -2 + 8 * b.uniform());
}

TEST(Random, NormalHasMeanZeroAndUnitVariance) {
  Random random(2);
  constexpr int kDraws = 100'000;
  double sum = 0, squares = 0;
  int beyond_two = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double n = random.normal();
    sum += n;
    squares += n * n;
    beyond_two += n > 2 || n < -2;
  }
  EXPECT_NEAR(sum / kDraws, 0, 0.02);
  EXPECT_NEAR(squares / kDraws, 1, 0.02);
  EXPECT_NEAR(static_cast<double>(beyond_two) / kDraws, 0.0455, 0.003);
}

TEST(Mix, SpreadsNeighboursOverAllBits) {
  std::set<std::uint64_t> low_bytes, high_bytes;
  for (std::uint64_t i = 0; i < 4096; ++i) {
    low_bytes.insert(mix(i) & 0xff);
    high_bytes.insert(mix(i) >> 56);
  }
  EXPECT_EQ(low_bytes.size(), 256u);
  EXPECT_EQ(high_bytes.size(), 256u);
}

}  // namespace
}  // namespace floatstage
