#include "core/statistics.h"

#include <array>
#include <cstdint>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>

namespace floatstage {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<double> one_to(int n) {
  std::vector<double> values(static_cast<std::size_t>(n));
  std::iota(values.rbegin(), values.rend(), 1.0);
  return values;
}

TEST(Median, IsTheMiddleOfAnOddNumber) {
  EXPECT_EQ(median<double>({7}), 7);
  EXPECT_EQ(median<double>({3, 9, 1}), 3);
  EXPECT_EQ(median<double>({5, 1, 4, 2, 3}), 3);
}

TEST(Median, IsTheLowerOfTheMiddleTwoOfAnEvenNumber) {
  EXPECT_EQ(median<double>({2, 1}), 1);
  EXPECT_EQ(median<double>({40, 10, 30, 20}), 20);
}

TEST(Median, IsAValueAlsoWhereThatIsNoDouble) {
  EXPECT_EQ(median<std::uint8_t>({255, 0}), 0);
  EXPECT_EQ(median<std::int64_t>({3'000'000'000'000'000'001, 3'000'000'000'000'000'003}),
            3'000'000'000'000'000'001);
}

TEST(Median, LivesWithInfiniteValues) {
  EXPECT_EQ(median<double>({kInfinity, 1, kInfinity}), kInfinity);
  EXPECT_EQ(median<double>({kInfinity, 1, 2}), 2);
}

TEST(Percentile, IsTheSmallestValueThatTheShareIsNotAbove) {
  EXPECT_EQ(percentile(one_to(100), 0.95), 95);
  EXPECT_EQ(percentile(one_to(20), 0.95), 19);
  EXPECT_EQ(percentile(one_to(10), 0.95), 10);
  EXPECT_EQ(percentile(one_to(10), 0.25), 3);
  EXPECT_EQ(percentile(one_to(100), 0.07), 7) << "although 0.07 × 100 is rounded up";
}

TEST(Percentile, BeginsWithTheSmallestAndEndsWithTheLargest) {
  EXPECT_EQ(percentile(one_to(9), 0), 1);
  EXPECT_EQ(percentile(one_to(9), 1e-3), 1);
  EXPECT_EQ(percentile(one_to(9), 1), 9);
}

TEST(Percentile, OrdersABufferThatIsUsedAgainWithoutLosingAValue) {
  std::array<int, 5> buffer = {5, 1, 4, 2, 3};
  EXPECT_EQ(percentile_in_place(std::span<int>(buffer), 0.5), 3);
  EXPECT_EQ(std::accumulate(buffer.begin(), buffer.end(), 0), 15);
}

TEST(Percentile, OfNothingIsABug) {
  EXPECT_THROW(percentile<double>({}, 0.5), CheckFailure);
  EXPECT_THROW(median<double>({}), CheckFailure);
}

}  // namespace
}  // namespace floatstage
