#include "calib/silhouettes/silhouette_times.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "core/synthetic/synthetic_studio.h"
#include "recon/outline.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

using testing::HasSubstr;

constexpr int kCameras = 5, kFrames = 20, kLate = 2;
constexpr int kParts = 100;  // of a frame, that the studio can be asked for
constexpr double kRate = 30;

Rig ring() {
  return synthetic_rig({.shape = RigShape::Ring, .cameras = kCameras, .width = 480, .height = 360});
}

using Frames = std::vector<std::vector<Silhouette>>;

/// The performer's silhouettes in cameras that run freely, one of which is 37 hundredths of a frame ahead.
const Frames& performed() {
  static const Frames rendered = [] {
    const Rig rig = ring();
    const Result<SyntheticStudio> studio =
        SyntheticStudio::create(rig, {.seed = 5, .frame_rate = kParts * kRate, .samples = 9});
    Frames frames(kFrames, std::vector<Silhouette>(rig.cameras.size()));
    parallel_for(frames.size(), 0, [&](std::size_t k) {
      for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
        const int at = kParts * static_cast<int>(k) + (c == kLate ? 37 : 0);
        frames[k][c] = recon::outline_of(studio->shoot(static_cast<int>(c), at).matte, rig.cameras[c].model,
                                         {.tolerance = 0});
      }
    });
    return frames;
  }();
  return rendered;
}

TEST(SilhouetteTimes, FindThirtySevenHundredthsOfAFrame) {
  const Result<TimeOffsets> found = measure_time_offsets(ring(), performed());
  ASSERT_THAT(found, IsOk());
  EXPECT_EQ(found->reference, 0);
  for (int c = 0; c < kCameras; ++c) {
    const TimeOffset& one = found->cameras[static_cast<std::size_t>(c)];
    ASSERT_TRUE(one.measured) << c << ": " << one.not_measured;
    EXPECT_NEAR(one.frames, c == kLate ? 0.37 : 0, 0.05) << c << ", sigma " << one.sigma_frames;
    EXPECT_LT(one.sigma_frames, 0.1) << c;
  }
}

TEST(SilhouetteTimes, AreNotMeasuredWhenNothingMoves) {
  const Frames still(kFrames, performed()[0]);
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
