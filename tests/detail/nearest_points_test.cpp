#include "detail/synthesis/nearest_points.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"

namespace floatstage::detail {
namespace {

std::vector<float> noise(std::uint64_t seed, int count, int dimensions) {
  Random random(seed);
  std::vector<float> out;
  for (int i = 0; i < count * dimensions; ++i) out.push_back(static_cast<float>(random.normal()));
  return out;
}

std::vector<float> all_distances(const std::vector<float>& points, const float* place, int dimensions) {
  std::vector<float> out;
  for (std::size_t i = 0; i < points.size(); i += static_cast<std::size_t>(dimensions)) {
    float sum = 0;
    for (int k = 0; k < dimensions; ++k) {
      const float off = points[i + static_cast<std::size_t>(k)] - place[k];
      sum += off * off;
    }
    out.push_back(sum);
  }
  std::sort(out.begin(), out.end());
  return out;
}

TEST(NearestPoints, AreTheNearestThereAreWithoutSlack) {
  for (const int dimensions : {1, 3, 12, 40}) {
    const std::vector<float> points = noise(1, 3000, dimensions), places = noise(2, 50, dimensions);
    const NearestPoints tree(points, dimensions);
    for (int i = 0; i < 50; ++i) {
      const float* place = &places[static_cast<std::size_t>(i * dimensions)];
      NearestPoints::Found found[3];
      ASSERT_EQ(tree.find(place, 3, 0, found), 3);
      const std::vector<float> truth = all_distances(points, place, dimensions);
      for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found[k].distance, truth[k], 1e-4F * (1 + truth[k]));
    }
  }
}

TEST(NearestPoints, AreNearEnoughWithSlack) {
  const std::vector<float> points = noise(1, 5000, 8), places = noise(2, 200, 8);
  const NearestPoints tree(points, 8);
  for (int i = 0; i < 200; ++i) {
    NearestPoints::Found found;
    ASSERT_EQ(tree.find(&places[static_cast<std::size_t>(8 * i)], 1, 2, &found), 1);
    const float truth = all_distances(points, &places[static_cast<std::size_t>(8 * i)], 8)[0];
    EXPECT_LE(found.distance, 3 * truth * 1.0001F);
  }
}

TEST(NearestPoints, MayAllBeAtOnePlaceOrFewerThanAsked) {
  const NearestPoints same(std::vector<float>(400, 2.0F), 4);
  const float place[4] = {2, 2, 2, 3};
  NearestPoints::Found found[3];
  ASSERT_EQ(same.find(place, 3, 0, found), 3);
  EXPECT_FLOAT_EQ(found[2].distance, 1);
  const NearestPoints one(std::vector<float>{1, 2, 3, 4}, 4);
  ASSERT_EQ(one.find(place, 3, 0, found), 1);
  EXPECT_EQ(found[0].index, 0U);
  EXPECT_EQ(NearestPoints({}, 4).find(place, 3, 0, found), 0);
}

}  // namespace
}  // namespace floatstage::detail
