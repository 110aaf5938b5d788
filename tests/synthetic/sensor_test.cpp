#include "core/synthetic/sensor.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

namespace floatstage::synthetic {
namespace {

Exposure flat(float value, int width = 64, int height = 64) {
  const std::size_t n = static_cast<std::size_t>(width * height);
  return {width, height, std::vector<Eigen::Vector3f>(n, Eigen::Vector3f::Constant(value)),
          std::vector<std::uint8_t>(n), std::vector<float>(n)};
}

TEST(Key, DiffersWithEachOfItsParts) {
  std::set<std::uint64_t> keys;
  int made = 0;
  for (std::uint64_t seed : {0, 1, 2})
    for (std::uint64_t purpose : {1, 2})
      for (int camera = 0; camera < 20; ++camera)
        for (int frame = -1; frame < 20; ++frame, ++made) keys.insert(key(seed, purpose, camera, frame));
  EXPECT_EQ(keys.size(), static_cast<std::size_t>(made));
}

TEST(Develop, RoundsToTheNearestOf256Steps) {
  for (int step : {0, 1, 127, 254, 255}) {
    const Image image = develop(flat((static_cast<float>(step) + 0.3f) / 255), Eigen::Vector3f::Ones(), 0, 0);
    EXPECT_EQ(image.pixels.front(), std::min(step, 255)) << step;
    EXPECT_EQ(std::set(image.pixels.begin(), image.pixels.end()).size(), 1u);
  }
}

TEST(Develop, ClipsWhatIsTooBrightOrTooDark) {
  EXPECT_EQ(develop(flat(1.4f), Eigen::Vector3f::Ones(), 0, 0).pixels.front(), 255);
  EXPECT_EQ(develop(flat(-0.2f), Eigen::Vector3f::Ones(), 0, 0).pixels.front(), 0);
  EXPECT_EQ(develop(flat(0.9f), {1.2f, 1, 0.5f}, 0, 0).pixels[0], 255);
}

TEST(Develop, MakesNoiseThatIsNormalAndIndependent) {
  const Image image = develop(flat(0.5f), Eigen::Vector3f::Ones(), 5, 77);
  double sum = 0, squares = 0, neighbours = 0, fourth = 0;
  const std::size_t n = image.pixels.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double v = image.pixels[i] - 127.5;
    sum += v;
    squares += v * v;
    fourth += v * v * v * v;
    if (i > 0) neighbours += v * (image.pixels[i - 1] - 127.5);
  }
  const double count = static_cast<double>(n), variance = squares / count;
  EXPECT_NEAR(sum / count, 0, 0.2);
  EXPECT_NEAR(std::sqrt(variance), 5, 0.15);
  EXPECT_NEAR(fourth / count / (variance * variance), 3, 0.25) << "the kurtosis of a normal distribution";
  EXPECT_NEAR(neighbours / count, 0, 0.8) << "channels and pixels do not share their noise";
}

TEST(Develop, RepeatsItsNoiseForItsSeedOnly) {
  EXPECT_EQ(develop(flat(0.5f), Eigen::Vector3f::Ones(), 3, 1),
            develop(flat(0.5f), Eigen::Vector3f::Ones(), 3, 1));
  EXPECT_FALSE(develop(flat(0.5f), Eigen::Vector3f::Ones(), 3, 1) ==
               develop(flat(0.5f), Eigen::Vector3f::Ones(), 3, 2));
}

TEST(WithGain, DoesWhatDevelopDoesToTheSamePicture) {
  Image plate(16, 16, 3);
  for (std::size_t i = 0; i < plate.pixels.size(); ++i) plate.pixels[i] = static_cast<std::uint8_t>(i % 256);
  Exposure same = flat(0, 16, 16);
  for (std::size_t i = 0; i < same.color.size(); ++i)
    for (int c = 0; c < 3; ++c)
      same.color[i][c] = static_cast<float>(plate.pixels[3 * i + static_cast<std::size_t>(c)]) / 255.0f;
  const Eigen::Vector3f gain(0.93f, 1.07f, 1.001f);
  EXPECT_EQ(with_gain(plate, gain), develop(same, gain, 0, 0));
}

TEST(SensorDefects, LeaveAPerfectSensorAlone) {
  const SensorDefects perfect;
  for (int i = 0; i < 50; ++i) {
    EXPECT_EQ(perfect.gain(i), Eigen::Vector3f(1, 1, 1));
    EXPECT_FALSE(perfect.dropped(i, i));
    EXPECT_EQ(perfect.exposure_start(i, i).ns, i * 40'000'000) << "25 frames a second";
  }
}

TEST(SensorDefects, NeverExposeBeforeTheClockBegins) {
  const SensorDefects hasty{.seed = 1, .defects = {.time_jitter = 0.02}};
  for (int camera = 0; camera < 50; ++camera) EXPECT_GE(hasty.exposure_start(camera, 0).ns, 0);
}

}  // namespace
}  // namespace floatstage::synthetic
