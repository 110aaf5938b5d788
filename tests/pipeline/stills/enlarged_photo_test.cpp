#include "pipeline/stills/enlarged_photo.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"
#include "pipeline/metrics/metrics.h"
#include "tests/support/matchers.h"

namespace floatstage::pipeline {
namespace {

constexpr int kScale = 3, kSide = 64;

/// Blots of all sizes, grey with a cast, seen from `shift` px beside.
Image blots(int side, std::uint64_t seed, double shift_x = 0, double shift_y = 0) {
  struct Blot {
    double x, y, radius, strength;
  };
  Random random(seed);
  std::vector<Blot> all;
  for (int i = 0; i < 900; ++i) {
    const double x = random.uniform() * side, y = random.uniform() * side;
    all.push_back({x, y, 1.2 + 8 * random.uniform() * random.uniform(), 90 * (random.uniform() - 0.5)});
  }
  Image picture(side, side, 3);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      double value = 120;
      for (const Blot& b : all) {
        const double dx = x + 0.5 + shift_x - b.x, dy = y + 0.5 + shift_y - b.y,
                     d = (dx * dx + dy * dy) / (b.radius * b.radius);
        if (d < 9) value += b.strength * std::exp(-d);
      }
      for (int k = 0; k < 3; ++k)
        picture.at(x, y)[k] = static_cast<std::uint8_t>(std::clamp(value - 10 * k, 0.0, 255.0));
    }
  return picture;
}

Image means(const Image& fine) {
  Image coarse(fine.width / kScale, fine.height / kScale, 3);
  for (int y = 0; y < coarse.height; ++y)
    for (int x = 0; x < coarse.width; ++x)
      for (int k = 0; k < 3; ++k) {
        int sum = 0;
        for (int j = 0; j < kScale; ++j)
          for (int i = 0; i < kScale; ++i) sum += fine.at(x * kScale + i, y * kScale + j)[k];
        coarse.at(x, y)[k] = static_cast<std::uint8_t>((sum + kScale * kScale / 2) / (kScale * kScale));
      }
  return coarse;
}

/// As if the still lay straight over the photograph.
StillMap straight_map() {
  StillMap map(kSide, kSide);
  for (int y = 1; y + 1 < kSide; ++y)
    for (int x = 1; x + 1 < kSide; ++x)
      map(x, y) = {static_cast<float>((x + 0.5) * kScale), static_cast<float>((y + 0.5) * kScale)};
  return map;
}

Image inside() {
  Image mask(kSide * kScale, kSide * kScale, 1);
  for (int y = 8 * kScale; y < (kSide - 8) * kScale; ++y)
    for (int x = 8 * kScale; x < (kSide - 8) * kScale; ++x) *mask.at(x, y) = 255;
  return mask;
}

TEST(EnlargedPhoto, GetsWhatABentStillShowsFiner) {
  const Image truth = blots(kSide * kScale, 1), photo = means(truth);
  const Image still = blots(kSide * kScale, 1, 4.2, -2.7);  // 1.4 and 0.9 px of the photograph beside
  const Image plain = enlarged_picture(photo, kScale, 1), none;
  EnlargedPhoto enlarged(photo, none, kScale, 1);
  const auto carried = enlarged.carry(still, kScale, straight_map(), detail::Provenance::Real);
  ASSERT_THAT(carried, IsOk());
  EXPECT_EQ(carried->why_not, "");
  EXPECT_GT(carried->used, 0.5);
  EXPECT_NEAR(carried->moved, std::hypot(1.4, 0.9), 0.15);
  EXPECT_GT(psnr(enlarged.picture(), truth, inside()), psnr(plain, truth, inside()) + 3);
  const Image mask(kSide, kSide, 1, 255);
  EXPECT_GT(psnr(means(enlarged.picture()), photo, mask), 40) << "means are the photograph's";
}

TEST(EnlargedPhoto, TakesNothingFromAStillOfSomethingElse) {
  const Image photo = means(blots(kSide * kScale, 1)), other = blots(kSide * kScale, 2), none;
  EnlargedPhoto enlarged(photo, none, kScale, 1);
  const auto carried = enlarged.carry(other, kScale, straight_map(), detail::Provenance::Real);
  ASSERT_THAT(carried, IsOk());
  EXPECT_LT(carried->used, 0.01);
  EXPECT_NE(carried->why_not + (carried->used < 0.01 ? "little" : ""), "");
  const Image mask(kSide * kScale, kSide * kScale, 1, 255);
  EXPECT_GT(psnr(enlarged.picture(), enlarged_picture(photo, kScale, 1), mask), 40);
}

TEST(EnlargedPhoto, GivesTheSameBytesAtAnyNumberOfThreads) {
  const Image photo = means(blots(kSide * kScale, 1)), still = blots(kSide * kScale, 1, 2, 1), none;
  Image pictures[2];
  for (int i = 0; i < 2; ++i) {
    EnlargedPhoto enlarged(photo, none, kScale, 1 + 2 * i);
    ASSERT_THAT(enlarged.carry(still, kScale, straight_map(), detail::Provenance::Real), IsOk());
    pictures[i] = enlarged.picture();
  }
  EXPECT_EQ(pictures[0], pictures[1]);
}

TEST(EnlargedPhoto, LeavesWhatIsNotTheSubjectAlone) {
  const Image photo = means(blots(kSide * kScale, 1)), still = blots(kSide * kScale, 1);
  Image matte(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide / 2; ++x) *matte.at(x, y) = 255;
  EnlargedPhoto enlarged(photo, matte, kScale, 1);
  ASSERT_THAT(enlarged.carry(still, kScale, straight_map(), detail::Provenance::Real), IsOk());
  const Image plain = enlarged_picture(photo, kScale, 1);
  for (int y = 0; y < plain.height; ++y)
    for (int x = (kSide / 2 + 2) * kScale; x < plain.width; ++x)
      ASSERT_EQ(enlarged.picture().at(x, y)[1], plain.at(x, y)[1]) << x << ", " << y;
}

TEST(EnlargedPhoto, RefusesAStillThatCoversNextToNothing) {
  const Image photo = means(blots(kSide * kScale, 1)), still = blots(kSide * kScale, 1), none;
  StillMap map(kSide, kSide);
  map(20, 20) = {60, 60};
  EnlargedPhoto enlarged(photo, none, kScale, 1);
  const auto carried = enlarged.carry(still, kScale, map, detail::Provenance::Real);
  ASSERT_THAT(carried, IsOk());
  EXPECT_THAT(carried->why_not, testing::HasSubstr("too little"));
}

}  // namespace
}  // namespace floatstage::pipeline
