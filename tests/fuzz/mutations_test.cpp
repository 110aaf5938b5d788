#include "tests/fuzz/mutations.h"

#include <set>

#include <gtest/gtest.h>

namespace floatstage {
namespace {

const std::string kSeed = "{\"width\": 640, \"name\": \"left\", \"matrix\": [1.5, -2, 3e4]}";

TEST(Mutations, BeginWithATruncationAtEveryLength) {
  for (std::size_t i = 0; i < kSeed.size(); ++i) EXPECT_EQ(mutated(kSeed, i), kSeed.substr(0, i));
}

TEST(Mutations, OfALongSeedTruncateAllOverIt) {
  const std::string seed(100'000, 'x');
  EXPECT_EQ(mutation_count(seed.size()), 512u + 1024u);
  EXPECT_EQ(mutated(seed, 0).size(), 0u);
  EXPECT_GT(mutated(seed, 511).size(), 99'000u);
}

TEST(Mutations, AreTheSameEachTimeAndNearlyAllDifferent) {
  std::set<std::string> seen;
  for (std::size_t i = kSeed.size(); i < mutation_count(kSeed.size()); ++i) {
    EXPECT_EQ(mutated(kSeed, i), mutated(kSeed, i));
    seen.insert(mutated(kSeed, i));
  }
  EXPECT_GT(seen.size(), 900u);
}

TEST(Mutations, OfNothingAreNothing) { EXPECT_EQ(mutated("", 3), ""); }

}  // namespace
}  // namespace floatstage
