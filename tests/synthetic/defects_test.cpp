#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <gmock/gmock.h>

#include "core/synthetic/calibration_error.h"
#include "core/synthetic/sensor.h"
#include "tests/synthetic/studios.h"

namespace floatstage {
namespace {

struct Spread {
  double sum = 0, squares = 0;
  long count = 0;
  void add(double v) {
    sum += v;
    squares += v * v;
    ++count;
  }
  double mean() const { return sum / static_cast<double>(count); }
  double deviation() const { return std::sqrt(squares / static_cast<double>(count) - mean() * mean()); }
};

TEST(Defects, NoiseHasItsStandardDeviation) {
  const Rig rig = small_rig(2);
  const Image clean = rgb_of(studio_with(rig, quick_options()).shoot(1, 0));
  for (double noise : {1.0, 4.0}) {
    const Image noisy = rgb_of(studio_with(rig, quick_options({.noise = noise})).shoot(1, 0));
    Spread difference;
    for (std::size_t i = 0; i < clean.pixels.size(); ++i)
      if (clean.pixels[i] > 20 && clean.pixels[i] < 235) difference.add(noisy.pixels[i] - clean.pixels[i]);
    // Rounding both pictures to 8 bits adds a little (a twelfth of a square step each).
    EXPECT_NEAR(difference.deviation(), std::sqrt(noise * noise + 1.0 / 12), 0.05 * noise);
    EXPECT_NEAR(difference.mean(), 0, 0.05);
  }
}

TEST(Defects, NoiseIsNewInEveryFrameAndLeavesTheTruthAlone) {
  const Rig rig = small_rig(2);
  const SyntheticStudio clean = studio_with(rig, quick_options()),
                        noisy = studio_with(rig, quick_options({.noise = 3}));
  EXPECT_EQ(to_image(clean.shoot(0, 1).matte), to_image(noisy.shoot(0, 1).matte));
  EXPECT_EQ(clean.plate(0), noisy.plate(0)) << "the plate is the mean of many pictures";
  const Image a = rgb_of(noisy.shoot(0, 1)), b = rgb_of(noisy.shoot(0, 2)), plate = noisy.plate(0);
  Spread together;  // in the top rows, where there is only cloth
  for (std::size_t i = 0; i < 160 * 3 * 5; ++i)
    together.add((a.pixels[i] - plate.pixels[i]) * (b.pixels[i] - plate.pixels[i]));
  EXPECT_NEAR(together.mean(), 0, 1.0) << "correlated; 9 would be the same noise twice";
}

TEST(Defects, ColourGainScalesEachCamerasChannels) {
  const Rig rig = small_rig(12);
  const SyntheticStudio even = studio_with(rig, quick_options()),
                        uneven = studio_with(rig, quick_options({.color_gain = 0.06}));
  Spread gains;
  for (int camera = 0; camera < 12; ++camera) {
    const Image before = even.plate(camera), after = uneven.plate(camera);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      double sum_before = 0, sum_after = 0;
      for (std::size_t i = channel; i < before.pixels.size(); i += 3) {
        sum_before += before.pixels[i];
        sum_after += after.pixels[i];
      }
      gains.add(sum_after / sum_before);
    }
  }
  EXPECT_NEAR(gains.mean(), 1, 0.03);
  EXPECT_NEAR(gains.deviation(), 0.06, 0.02);  // of 36 numbers
}

TEST(Defects, ALensBendsTheProjectionAndTheRigSaysSo) {
  const SyntheticStudio studio = studio_with(small_rig(), quick_options({.lens_k1 = -0.2}));
  const auto* lens = std::get_if<BrownConrady>(&studio.true_rig().cameras[0].model.lens);
  ASSERT_NE(lens, nullptr);
  EXPECT_DOUBLE_EQ(lens->k1, -0.2);
  EXPECT_DOUBLE_EQ(lens->k2, 0.05);
  // The mesh, projected with the lens, lies on the performer's pixels (but for vertices that only graze a
  // pixel's corner); projected without the lens it does not.
  const SyntheticShot shot = studio.shoot(0, 0);
  const RigCamera& camera = studio.true_rig().cameras[0];
  const std::vector<Eigen::Vector3f> vertices = studio.performer(0).positions;
  auto outside = [&](const CameraModel& model) {
    return std::count_if(vertices.begin(), vertices.end(), [&](const Eigen::Vector3f& p) {
      const Eigen::Vector2d pixel = *project(model, camera.cam_from_world * p.cast<double>());
      return !inside(model, pixel) ||
             shot.matte.row(static_cast<int>(pixel.y()))[static_cast<int>(pixel.x())] == 0;
    });
  };
  EXPECT_LT(outside(camera.model), static_cast<long>(vertices.size() / 100));
  EXPECT_GT(outside(pinhole(camera.model)), 3 * outside(camera.model));
}

class CalibrationError : public testing::TestWithParam<double> {};

TEST_P(CalibrationError, MovesThePublishedProjectionsByItsPixels) {
  const SyntheticStudio studio = studio_with(small_rig(8), quick_options({.calibration_error = GetParam()}));
  Spread error;
  for (std::size_t i = 0; i < 8; ++i) {
    const RigCamera &truth = studio.true_rig().cameras[i], &published = studio.published_rig().cameras[i];
    for (const Eigen::Vector3f& p : studio.performer(0).positions) {
      const Eigen::Vector3d world = p.cast<double>();
      const Eigen::Vector2d d = *project(published.model, published.cam_from_world * world) -
                                *project(truth.model, truth.cam_from_world * world);
      error.add(d.x());
      error.add(d.y());
    }
  }
  EXPECT_NEAR(std::sqrt(error.squares / static_cast<double>(error.count)), GetParam(), 0.25 * GetParam());
  EXPECT_TRUE(check(studio.published_rig()));
}

INSTANTIATE_TEST_SUITE_P(Pixels, CalibrationError, testing::Values(0.3, 1.0, 4.0));

TEST(Defects, NoCalibrationErrorPublishesTheTrueRig) {
  const SyntheticStudio studio = studio_with(small_rig(3), quick_options());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(studio.published_rig().cameras[i].model, studio.true_rig().cameras[i].model);
    EXPECT_EQ(studio.published_rig().cameras[i].cam_from_world.matrix(),
              studio.true_rig().cameras[i].cam_from_world.matrix());
  }
}

TEST(Defects, CalibrationErrorIsExactOverThePerformersVolumeForEachCamera) {
  const Rig rig = small_rig(5), published = synthetic::with_calibration_error(rig, 2, 9);
  for (std::size_t i = 0; i < 5; ++i) {
    Spread error;
    for (const Eigen::Vector3d& p : synthetic::performer_volume()) {
      const Eigen::Vector2d d = *project(rig.cameras[i].model, rig.cameras[i].cam_from_world * p) -
                                *project(published.cameras[i].model, published.cameras[i].cam_from_world * p);
      error.add(d.x());
      error.add(d.y());
    }
    EXPECT_NEAR(std::sqrt(error.squares / static_cast<double>(error.count)), 2, 0.02);
  }
}

// How much greener than red and blue the performer's inside is, on the average.
double greenness(const SyntheticShot& shot) {
  const Image picture = rgb_of(shot);
  Spread green;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x)
      if (shot.matte.row(y)[x] == 255)
        green.add(picture.at(x, y)[1] - 0.5 * (picture.at(x, y)[0] + picture.at(x, y)[2]));
  return green.mean();
}

TEST(Defects, GreenSpillTintsThePerformerInProportion) {
  const Rig rig = small_rig(1);
  const double none = greenness(studio_with(rig, quick_options()).shoot(0, 0));
  const double half = greenness(studio_with(rig, quick_options({.green_spill = 0.5})).shoot(0, 0)) - none;
  const double full = greenness(studio_with(rig, quick_options({.green_spill = 1})).shoot(0, 0)) - none;
  EXPECT_GT(full, 10);
  EXPECT_NEAR(half, full / 2, 0.1 * full);
}

TEST(Defects, DropsItsFractionOfFramesInEachCameraOnItsOwn) {
  const synthetic::SensorDefects sensor{.seed = 3, .defects = {.dropped_frames = 0.25}};
  int dropped = 0, first_only = 0;
  constexpr int kFrames = 2000;
  for (int frame = 0; frame < kFrames; ++frame) {
    const bool first = sensor.dropped(0, frame), second = sensor.dropped(1, frame);
    dropped += first + second;
    first_only += first && !second;
  }
  EXPECT_NEAR(dropped / (2.0 * kFrames), 0.25, 0.02);
  EXPECT_NEAR(first_only / static_cast<double>(kFrames), 0.25 * 0.75, 0.03);
}

TEST(Defects, ADroppedFrameIsARowWithoutPicture) {
  const SyntheticStudio studio = studio_with(small_rig(1), quick_options({.dropped_frames = 1}));
  const SyntheticShot shot = studio.shoot(0, 3);
  EXPECT_EQ(shot.frame.info.status, FrameStatus::Lost);
  EXPECT_EQ(shot.frame.info.sequence, 3u);
  EXPECT_EQ(shot.frame.info.exposure_start.ns, 120'000'000) << "when it should have come";
  EXPECT_FALSE(shot.frame.info.device_time);
  EXPECT_TRUE(shot.frame.empty());
  EXPECT_TRUE(shot.matte.empty());
  EXPECT_TRUE(shot.depth.empty());
}

TEST(Defects, JitterHasItsStandardDeviationAndNeverSwapsFrames) {
  constexpr double kRate = 50;
  for (double jitter : {0.001, 0.003, 0.1}) {
    const synthetic::SensorDefects sensor{.seed = 3, .defects = {.time_jitter = jitter}, .frame_rate = kRate};
    Spread late;
    Timestamp before{-1};
    for (int frame = 1; frame < 2000; ++frame) {
      const Timestamp start = sensor.exposure_start(0, frame);
      EXPECT_GT(start, before);
      before = start;
      late.add(static_cast<double>(start.ns) * 1e-9 - frame / kRate);
    }
    EXPECT_NEAR(late.mean(), 0, 0.001);
    if (jitter < 0.01) {
      EXPECT_NEAR(late.deviation(), jitter, 0.06 * jitter);
    }
  }
}

TEST(Defects, AJitteredPictureShowsThePerformerAtItsTrueTime) {
  // The same dance at 1000 frames a second: the picture that a jittered camera took is one of those.
  const Rig rig = small_rig(1);
  const SyntheticStudio jittered = studio_with(rig, quick_options({.time_jitter = 0.008}));
  const SyntheticShot late = jittered.shoot(0, 9);
  SyntheticStudioOptions fine = quick_options();
  fine.frame_rate = 1000;
  const SyntheticStudio slow_motion = studio_with(rig, fine);
  const double milliseconds = static_cast<double>(late.frame.info.exposure_start.ns) * 1e-6;
  const Image mine = rgb_of(late),
              at_true_time = rgb_of(slow_motion.shoot(0, static_cast<int>(std::lround(milliseconds)))),
              at_nominal_time = rgb_of(slow_motion.shoot(0, 360));
  auto difference = [&](const Image& other) {
    long sum = 0;
    for (std::size_t i = 0; i < mine.pixels.size(); ++i) sum += std::abs(mine.pixels[i] - other.pixels[i]);
    return sum;
  };
  ASSERT_GT(std::abs(milliseconds - 360), 2) << "this seed does not jitter frame 9 enough to tell";
  EXPECT_LT(3 * difference(at_true_time), difference(at_nominal_time));
}

}  // namespace
}  // namespace floatstage
