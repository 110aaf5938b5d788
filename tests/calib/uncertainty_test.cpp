// Are stated sigmas true, and do they do what an operator expects of them?

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/uncertainty/picture_advice.h"
#include "calib/uncertainty/working_volume.h"
#include "tests/calib/halves.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

using testing::HasSubstr;

Observations waved(int frames, std::uint64_t seed, double extent = 0.6) {
  const CaptureOptions options{.frames = frames, .seed = seed, .extent = extent, .frame_seconds = 0.4};
  return capture(ring_rig(3), two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
}

double worst_sigma(const Calibration& c, const WorkingVolume& volume) {
  const ProjectionUncertainty uncertainty(c, volume.points);
  double worst = 0;
  for (int i = 0; i < static_cast<int>(c.rig.cameras.size()); ++i)
    if (const Measured s = projection_sigma(c, uncertainty, i, volume)) worst = std::max(worst, *s);
  return worst;
}

TEST(ProjectionSigma, IsHowFarHalvesOfACaptureAreApart) {
  double apart = 0, stated = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const HalvesRatio r = halves_ratio(waved(48, seed), 3, 24, seed);
    EXPECT_EQ(r.splits, 3);
    std::printf("seed %d: %.3f (%.3f px apart, %.3f px stated)\n", static_cast<int>(seed), r.ratio,
                r.apart_px, r.stated_px);
    apart += r.apart_px * r.apart_px;
    stated += r.stated_px * r.stated_px;
  }
  EXPECT_GE(std::sqrt(apart / stated), 0.8);
  EXPECT_LE(std::sqrt(apart / stated), 1.25);
}

TEST(ProjectionSigma, OfOneVolumeNeverRisesWithMoreViews) {
  const Observations all = waved(48, 4);
  const WorkingVolume volume = box_volume({-0.6, -0.6, 0.4}, {0.6, 0.6, 1.6});
  double before = 1e9;
  for (const int count : {12, 24, 48}) {
    std::vector<int> frames = frames_of(all);
    frames.resize(static_cast<std::size_t>(count));
    const Result<Calibration> solved = calibrate(only_frames(all, frames), {.holdout_every = 0});
    ASSERT_THAT(solved, IsOk());
    // The box is of the truth's world: brought to the solution's by its first camera.
    const Rig truth = ring_rig(3);
    WorkingVolume here = volume;
    for (Eigen::Vector3d& x : here.points)
      x = solved->rig.cameras[0].cam_from_world.inverse() * (truth.cameras[0].cam_from_world * x);
    const double sigma = worst_sigma(*solved, here);
    std::printf("%d frames: %.4f px\n", count, sigma);
    EXPECT_LT(sigma, before);
    before = sigma;
  }
}

TEST(WorkingVolume, IsTheHullOfAllTargetsUnlessItIsGiven) {
  const Result<Calibration> solved = calibrate(waved(20, 5), {.holdout_every = 0});
  ASSERT_THAT(solved, IsOk());
  const WorkingVolume hull = hull_of_targets(*solved);
  EXPECT_THAT(hull.how, HasSubstr("the convex hull of all targets"));
  EXPECT_GT(hull.points.size(), 40u);
  EXPECT_LT(hull.points.size(), 200u) << "a hull has no corners of its box";
  EXPECT_THAT(box_volume({0, 0, 0}, {1, 2, 3}).how, HasSubstr("the given box, 1.00 x 2.00 x 3.00 m"));
}

TEST(PicturesToAdd, BringACameraBelowItsBar) {
  // A board waved in a small place says little of the rest of the stage.
  const CaptureOptions narrow{.frames = 16, .seed = 6, .extent = 0.15, .frame_seconds = 0.4};
  const Observations seen =
      capture(ring_rig(3), two_sided_board(7, 5, 0.08, 0.005), wandering(narrow), narrow);
  const Result<Calibration> solved = calibrate(seen, {.holdout_every = 0});
  ASSERT_THAT(solved, IsOk());
  WorkingVolume stage = box_volume({-0.8, -0.8, 0.2}, {0.8, 0.8, 1.8});
  const Rig truth = ring_rig(3);
  for (Eigen::Vector3d& x : stage.points)
    x = solved->rig.cameras[0].cam_from_world.inverse() * (truth.cameras[0].cam_from_world * x);
  const double now = worst_sigma(*solved, stage), bar = 0.5 * now;
  const std::vector<PictureAdvice> advice = pictures_to_add(*solved, seen, stage, bar);
  ASSERT_FALSE(advice.empty());
  EXPECT_NEAR(advice[0].now_px, now, 0.05 * now);
  EXPECT_LT(advice[0].then_px, 0.7 * now);
  ASSERT_FALSE(advice[0].pictures.empty());
  EXPECT_THAT(advice[0].sentence, HasSubstr("Show the board\n    at the "));
  std::printf("%s\n", advice[0].sentence.c_str());
  EXPECT_TRUE(pictures_to_add(*solved, seen, stage, 2 * now).empty()) << "nothing is missing";
}

}  // namespace
}  // namespace floatstage::calib
