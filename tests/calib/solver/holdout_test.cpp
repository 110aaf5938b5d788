// Errors in frames that had no part in the solution.

#include "calib/solver/holdout.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/solver/quality.h"
#include "calib/solver/stages.h"
#include "tests/calib/solver/solver_scenes.h"

namespace floatstage::calib::solver {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

constexpr double kNoise = 0.2;

TrueScene solved_scene(int frames, const CalibrationOptions& options) {
  TrueScene s = true_scene(3, {.frames = frames, .noise_px = kNoise, .outliers = 0.01, .frame_seconds = 0.4});
  solve_in_stages(s.scene, options);
  return s;
}

TEST(Holdout, IsTheNoiseAndALittleMoreForASoundCapture) {
  const TrueScene s = solved_scene(40, {});
  const std::vector<Measured> held = holdout_errors(s.scene, s.seen, {});
  const std::vector<PointError> errors = point_errors(s.scene, s.seen);
  ASSERT_THAT(held, SizeIs(3));
  for (int c = 0; c < 3; ++c) {
    const double rms = *rms_of(errors, c);
    EXPECT_GT(held[static_cast<std::size_t>(c)], 0.95 * rms) << "what was solved with fits better";
    EXPECT_LT(held[static_cast<std::size_t>(c)], 1.25 * rms);
  }
}

TEST(Holdout, GrowsWhereALensIsHeldAtAWrongFocalLength) {
  TrueScene s = solved_scene(24, {});
  const std::vector<Measured> sound = holdout_errors(s.scene, s.seen, {});
  SceneCamera& camera = s.scene.cameras[1];
  camera.intrinsics.head<2>() *= 1.06;
  camera.intrinsics_fixed = true;
  const std::vector<Measured> wrong = holdout_errors(s.scene, s.seen, {});
  ASSERT_THAT(sound, SizeIs(3));
  ASSERT_THAT(wrong, SizeIs(3));
  EXPECT_GT(wrong[1], 2 * *sound[1]);
}

TEST(Holdout, SaysThatNothingWasHeldOutAndNever0) {
  const TrueScene s = solved_scene(20, {});
  for (const int every : {0, 1})
    for (const Measured& m : holdout_errors(s.scene, s.seen, {.holdout_every = every})) {
      EXPECT_FALSE(m);
      EXPECT_THAT(m.because(), HasSubstr("holdout_every"));
    }
}

TEST(Holdout, SaysThatThereWereTooFewFrames) {
  const TrueScene s = solved_scene(14, {});
  const std::vector<Measured> held = holdout_errors(s.scene, s.seen, {});
  ASSERT_THAT(held, SizeIs(3));
  EXPECT_EQ(to_words(held[0], 3, " px"),
            "not measured, because only 14 frames show what moves; 15 are needed to hold some out");
}

TEST(Holdout, IsTheSameForEveryNumberOfThreads) {
  const TrueScene s = solved_scene(16, {.threads = 1});
  EXPECT_EQ(holdout_errors(s.scene, s.seen, {.threads = 1}), holdout_errors(s.scene, s.seen, {.threads = 3}));
}

}  // namespace
}  // namespace floatstage::calib::solver
