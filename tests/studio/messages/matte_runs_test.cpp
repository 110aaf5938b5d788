#include "studio/messages/matte_runs.h"

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/support/matchers.h"

namespace floatstage::studio::wire {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(MatteRuns, GiveBackEveryByte) {
  Bytes bytes(5, 0);
  for (std::size_t run : {1u, 2u, 3u, 62u, 63u, 64u, 127u, 128u, 129u, 16382u, 16383u, 16384u, 40000u})
    bytes.insert(bytes.end(), run, static_cast<std::uint8_t>(bytes.size() * 7));
  for (int i = 0; i < 1000; ++i) bytes.push_back(static_cast<std::uint8_t>(i * i >> 3));
  EXPECT_THAT(decode_runs(encode_runs(bytes), bytes.size()), IsOkAnd(testing::Eq(bytes)));
  EXPECT_THAT(decode_runs(encode_runs({}), 0), IsOkAnd(testing::Eq(Bytes{})));
}

TEST(MatteRuns, GiveBackNoise) {
  Random random(5);
  for (int trial = 0; trial < 50; ++trial) {
    Bytes bytes(static_cast<std::size_t>(trial) * 13);
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(random.uniform(0, trial % 5 + 1));
    EXPECT_THAT(decode_runs(encode_runs(bytes), bytes.size()), IsOkAnd(testing::Eq(bytes))) << trial;
  }
}

TEST(MatteRuns, TakeTheFlatPartsOfAMatteForNearlyNothing) {
  EXPECT_LT(encode_runs(Bytes(512 * 1024, 255)).size(), 110u);
}

TEST(MatteRuns, NeverGrowByMoreThanOneByteIn127) {
  Bytes noise(127 * 8);
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<std::uint8_t>(i * 37);
  EXPECT_EQ(encode_runs(noise).size(), noise.size() + 8);
}

TEST(MatteRuns, OfAnotherSizeAreRefused) {
  const std::string code = encode_runs(Bytes(100, 255));
  EXPECT_THAT(decode_runs(code, 99), FailsWith(ErrorCode::BadData, "another size"));
  EXPECT_THAT(decode_runs(code, 101), FailsWith(ErrorCode::BadData, "another size"));
  EXPECT_THAT(decode_runs(code + '\x05', 100), FailsWith(ErrorCode::BadData, "another size"));
  EXPECT_THAT(decode_runs(code.substr(0, 2), 100), FailsWith(ErrorCode::BadData, "another size"));
}

}  // namespace
}  // namespace floatstage::studio::wire
