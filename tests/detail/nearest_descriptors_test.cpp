#include "detail/nearest_descriptors.h"

#include <gtest/gtest.h>
#include <opencv2/features2d.hpp>

#include "core/random.h"

namespace floatstage::detail {
namespace {

PhotoFeatures noise(int count, std::uint64_t seed) {
  Random random(seed);
  PhotoFeatures f;
  for (int i = 0; i < count; ++i) f.points.emplace_back(i, i);
  for (int i = 0; i < count * PhotoFeatures::kLength; ++i)
    f.descriptors.push_back(static_cast<std::uint8_t>(random.next() % 256));
  return f;
}

cv::Mat matrix_of(const PhotoFeatures& f) {
  cv::Mat out;
  cv::Mat(f.count(), PhotoFeatures::kLength, CV_8U, const_cast<std::uint8_t*>(f.descriptors.data()))
      .convertTo(out, CV_32F);
  return out;
}

void expect_as_by_brute_force(const std::vector<Nearest>& found, const PhotoFeatures& a,
                              const PhotoFeatures& b) {
  std::vector<std::vector<cv::DMatch>> truth;
  cv::BFMatcher(cv::NORM_L2SQR).knnMatch(matrix_of(a), matrix_of(b), truth, 2);
  ASSERT_EQ(found.size(), truth.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].index, truth[i][0].trainIdx) << i;
    EXPECT_EQ(found[i].first, truth[i][0].distance) << i;
    EXPECT_EQ(found[i].second, truth[i].size() > 1 ? truth[i][1].distance : Nearest::kNone) << i;
  }
}

TEST(NearestDescriptors, AreThoseOfBruteForceInBothDirectionsWhateverTheCounts) {
  for (const auto& [m, n] : {std::pair(1, 1), {1, 2}, {5, 1}, {6, 32}, {7, 33}, {100, 61}, {251, 300}}) {
    const PhotoFeatures a = noise(m, 1), b = noise(n, 2);
    const NearestBothWays nearest = nearest_both_ways(a, b);
    expect_as_by_brute_force(nearest.of_a, a, b);
    expect_as_by_brute_force(nearest.of_b, b, a);
  }
}

TEST(NearestDescriptors, OfEqualsTakeTheFirstAndSayThatTheNextIsAsNear) {
  PhotoFeatures a = noise(3, 1), b = noise(40, 2);
  for (const int copy : {7, 35})
    std::copy_n(a.descriptor(1), PhotoFeatures::kLength,
                b.descriptors.begin() + copy * PhotoFeatures::kLength);
  const Nearest nearest = nearest_both_ways(a, b).of_a[1];
  EXPECT_EQ(nearest.index, 7);
  EXPECT_EQ(nearest.first, 0);
  EXPECT_EQ(nearest.second, 0);
}

TEST(NearestDescriptors, StayExactAtTheLargestDistanceThatThereIs) {
  PhotoFeatures black = noise(2, 1), white = noise(2, 2);
  std::fill(black.descriptors.begin(), black.descriptors.end(), 0);
  std::fill(white.descriptors.begin(), white.descriptors.end(), 255);
  white.descriptors[0] = 254;
  const Nearest nearest = nearest_both_ways(black, white).of_a[0];
  EXPECT_EQ(nearest.index, 0);
  EXPECT_EQ(nearest.first, 127 * 255.0F * 255 + 254 * 254);
  EXPECT_EQ(nearest.second, 128 * 255.0F * 255);
}

TEST(NearestDescriptors, OfAPhotographWithoutFeaturesAreNone) {
  const PhotoFeatures none, some = noise(3, 1);
  const NearestBothWays nearest = nearest_both_ways(some, none);
  EXPECT_EQ(nearest.of_a.size(), 3u);
  EXPECT_EQ(nearest.of_a[0].index, -1);
  EXPECT_TRUE(nearest.of_b.empty());
}

}  // namespace
}  // namespace floatstage::detail
