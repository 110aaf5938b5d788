#include <vector>

#include <gmock/gmock.h>

#include "core/parallel.h"
#include "tests/synthetic/studios.h"

namespace floatstage {
namespace {

const Defects kEverything{.noise = 2,
                          .lens_k1 = -0.1,
                          .color_gain = 0.05,
                          .calibration_error = 1,
                          .green_spill = 0.5,
                          .dropped_frames = 0.2,
                          .time_jitter = 0.004};

// Six shots: three cameras, two frames.
std::vector<SyntheticShot> shoot_all(const SyntheticStudio& studio, int threads, bool backwards) {
  std::vector<SyntheticShot> shots(6);
  parallel_for(shots.size(), threads, [&](std::size_t i) {
    const std::size_t k = backwards ? shots.size() - 1 - i : i;
    shots[k] = studio.shoot(static_cast<int>(k % 3), static_cast<int>(k / 3));
  });
  return shots;
}

TEST(SyntheticStudio, GivesTheSameBytesForTheSameSeed) {
  const auto first = shoot_all(studio_with(small_rig(), quick_options(kEverything)), 1, false);
  const auto second = shoot_all(studio_with(small_rig(), quick_options(kEverything)), 1, false);
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_TRUE(same_shot(first[i], second[i])) << i;
}

TEST(SyntheticStudio, GivesTheSameBytesInAnyOrderAndAtAnyThreadCount) {
  const SyntheticStudio studio = studio_with(small_rig(), quick_options(kEverything));
  const auto expected = shoot_all(studio, 1, false);
  for (const auto& shots : {shoot_all(studio, 1, true), shoot_all(studio, 5, false)})
    for (std::size_t i = 0; i < shots.size(); ++i) EXPECT_TRUE(same_shot(expected[i], shots[i])) << i;
}

TEST(SyntheticStudio, GivesAnotherPerformanceForAnotherSeed) {
  SyntheticStudioOptions other = quick_options();
  other.seed = 8;
  const SyntheticStudio a = studio_with(small_rig(), quick_options()), b = studio_with(small_rig(), other);
  EXPECT_FALSE(same_shot(a.shoot(0, 0), b.shoot(0, 0)));
  EXPECT_FALSE(a.plate(0) == b.plate(0));
}

TEST(SyntheticStudio, SurvivesBeingMoved) {
  SyntheticStudio studio = studio_with(small_rig(), quick_options());
  const SyntheticShot before = studio.shoot(1, 2);
  const SyntheticStudio elsewhere = std::move(studio);
  EXPECT_TRUE(same_shot(before, elsewhere.shoot(1, 2)));
}

TEST(SyntheticStudio, RefusesImpossibleOptionsByName) {
  auto message = [](SyntheticStudioOptions options) {
    const auto studio = SyntheticStudio::create(small_rig(), options);
    return studio ? std::string() : studio.error().message;
  };
  EXPECT_THAT(message({.samples = 5}), testing::HasSubstr("samples"));
  EXPECT_THAT(message({.frame_rate = 0}), testing::HasSubstr("frame_rate"));
  EXPECT_THAT(message({.defects = {.noise = -1}}), testing::HasSubstr("noise"));
  EXPECT_THAT(message({.defects = {.dropped_frames = 1.5}}), testing::HasSubstr("dropped_frames"));
  EXPECT_FALSE(SyntheticStudio::create(Rig{}, {}));
}

}  // namespace
}  // namespace floatstage
