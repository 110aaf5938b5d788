#include "calib/silhouettes/silhouette_times.h"

#include <array>
#include <cmath>
#include <numbers>
#include <span>

#include <Eigen/Geometry>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "core/synthetic/synthetic_studio.h"
#include "recon/outline.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

using testing::HasSubstr;

constexpr int kCameras = 5, kFrames = 30;  // a second
constexpr int kSure = 45;                  // frames that suffice for 0.05 of one
constexpr int kParts = 100;                // of a frame, that the studio can be asked for
constexpr int kLate[] = {0, 37, -21, 0, 50, 12, -44, 28};
constexpr double kRate = 30;

Rig ring(int cameras = kCameras) {
  return synthetic_rig({.shape = RigShape::Ring, .cameras = cameras, .width = 480, .height = 360});
}

using Frames = std::vector<std::vector<Silhouette>>;

/// The performer's silhouettes in cameras that run freely, each late by its parts of a frame.
Frames performed(int frames, int cameras = kCameras, std::uint64_t seed = 5) {
  const Rig rig = ring(cameras);
  const Result<SyntheticStudio> studio =
      SyntheticStudio::create(rig, {.seed = seed, .frame_rate = kParts * kRate, .samples = 4});
  Frames out(static_cast<std::size_t>(frames), std::vector<Silhouette>(rig.cameras.size()));
  parallel_for(out.size(), 0, [&](std::size_t k) {
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      const int at = kParts * (static_cast<int>(k) + 1) + kLate[c];
      out[k][c] = recon::outline_of(studio->shoot(static_cast<int>(c), at).matte, rig.cameras[c].model,
                                    {.tolerance = 0});
    }
  });
  return out;
}

const Frames& a_second() {
  static const Frames frames = performed(kFrames);
  return frames;
}

/// Errors by their stated sigmas: about 1 where sigmas are honest.
struct Honesty {
  double squares = 0;
  int count = 0;
  double usual() const { return std::sqrt(squares / count); }
};

void expect_right(const TimeOffsets& found, Honesty& honesty) {
  ASSERT_EQ(found.reference, 0);
  for (std::size_t c = 1; c < found.cameras.size(); ++c) {
    const TimeOffset& one = found.cameras[c];
    ASSERT_TRUE(one.measured) << c << ": " << one.not_measured;
    const double error = one.frames - 0.01 * kLate[c];
    EXPECT_LT(std::abs(error), 0.05) << c << ", sigma " << one.sigma_frames;
    EXPECT_LT(one.sigma_frames, 0.1) << c;
    honesty.squares += error * error / (one.sigma_frames * one.sigma_frames);
    ++honesty.count;
  }
}

TEST(SilhouetteTimes, FindThirtySevenHundredthsOfAFrame) {
  const Result<TimeOffsets> found = measure_time_offsets(ring(), a_second());
  ASSERT_THAT(found, IsOk());
  Honesty honesty;
  expect_right(*found, honesty);
  EXPECT_LT(honesty.usual(), 2.5);
}

// A second and a half of it, begun every sixth of a second, of two rings and two dancers.
TEST(SilhouetteTimes, FindThemInEveryWindowWithAnHonestSigma) {
  FLOATSTAGE_LONG_FORM(true);
  for (const int cameras : {5, 8}) {
    SCOPED_TRACE(cameras);
    const Frames all = performed(100, cameras, cameras == 5 ? 5 : 11);
    Honesty honesty;
    for (std::size_t begin = 0; begin + kSure <= all.size(); begin += 5) {
      SCOPED_TRACE(begin);
      const auto found = measure_time_offsets(ring(cameras), std::span(all).subspan(begin, kSure));
      ASSERT_THAT(found, IsOk());
      expect_right(*found, honesty);
    }
    EXPECT_GT(honesty.usual(), 0.7);
    EXPECT_LT(honesty.usual(), 1.4);
  }
}

// As where cameras are started by hand: two late by whole seconds' parts, one early.
TEST(SilhouetteTimes, FindCamerasThatAreManyFramesApart) {
  constexpr int kFirst = 8;  // of the frames that are left
  constexpr std::array kApart = {0, -7, 0, 5, 0};
  const Frames all = performed(kSure + 2 * kFirst);
  for (const bool quick : {false, true}) {
    Frames apart(kSure, std::vector<Silhouette>(kCameras));
    for (std::size_t k = 0; k < apart.size(); ++k)
      for (std::size_t c = 0; c < kCameras; ++c)
        apart[k][c] = all[k + static_cast<std::size_t>(kFirst + kApart[c])][c];
    const Result<TimeOffsets> found = measure_time_offsets(ring(), apart, {.quick = quick, .threads = 2});
    ASSERT_THAT(found, IsOk());
    for (std::size_t c = 0; c < kCameras; ++c) {
      ASSERT_TRUE(found->cameras[c].measured) << c << ": " << found->cameras[c].not_measured;
      EXPECT_NEAR(found->cameras[c].frames, kApart[c] + 0.01 * kLate[c], quick ? 0.2 : 0.05) << c;
    }
    EXPECT_EQ(found->reference, 0);
  }
}

TEST(SilhouetteTimes, TheSameAtAnyNumberOfThreads) {
  const Result<TimeOffsets> one = measure_time_offsets(ring(), a_second(), {.threads = 1}),
                            four = measure_time_offsets(ring(), a_second(), {.threads = 4});
  ASSERT_THAT(one, IsOk());
  ASSERT_THAT(four, IsOk());
  for (std::size_t c = 0; c < kCameras; ++c) EXPECT_EQ(one->cameras[c].frames, four->cameras[c].frames) << c;
}

// A turn is no time: it is said, and the others are measured without that camera.
TEST(SilhouetteTimes, SayThatACameraHasTurned) {
  for (const std::size_t turned : {0u, 2u}) {
    Rig rig = ring();
    Rigid3& pose = rig.cameras[turned].cam_from_world;
    const Eigen::Vector3d axis = Eigen::Vector3d(0.3, 1, 0.2).normalized();
    pose = Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(0.3 * std::numbers::pi / 180, axis)),
                  Eigen::Vector3d::Zero()} *
           pose;
    const Result<TimeOffsets> found = measure_time_offsets(rig, a_second());
    ASSERT_THAT(found, IsOk());
    for (std::size_t c = 0; c < kCameras; ++c) EXPECT_EQ(found->cameras[c].measured, c != turned) << c;
    EXPECT_THAT(found->cameras[turned].not_measured, HasSubstr("its pose is off"));
    EXPECT_EQ(found->reference, turned == 0 ? 1 : 0);
  }
}

TEST(SilhouetteTimes, AreNotMeasuredWhenNothingMoves) {
  const Frames still(kFrames, a_second()[0]);
  const Result<TimeOffsets> found = measure_time_offsets(ring(), still);
  ASSERT_THAT(found, IsOk());
  EXPECT_EQ(found->reference, -1);
  for (const TimeOffset& one : found->cameras) {
    EXPECT_FALSE(one.measured);
    EXPECT_THAT(one.not_measured, HasSubstr("nothing moves"));
  }
}

TEST(SilhouetteTimes, RefuseOneCameraAndFewFrames) {
  const Rig rig = ring();
  const std::vector<std::vector<Silhouette>> few(7, std::vector<Silhouette>(rig.cameras.size()));
  EXPECT_THAT(measure_time_offsets(rig, few), FailsWith(ErrorCode::InvalidArgument, ""));
  Rig one = rig;
  one.cameras.resize(1);
  EXPECT_THAT(measure_time_offsets(one, std::vector<std::vector<Silhouette>>(20, std::vector<Silhouette>(1))),
              FailsWith(ErrorCode::InvalidArgument, ""));
}

}  // namespace
}  // namespace floatstage::calib
