#include "studio/live/live_quality.h"

#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace floatstage::studio {
namespace {

using testing::Eq;
using testing::Optional;

Timestamp at(double s) { return {static_cast<std::int64_t>(s * 1e9)}; }

/// Judges windows of a second from `begin` on until the level changes, and says after how many; 0: not within
/// `most`.
int windows_until_change(QualityControl& control, double begin, double fps, double busy, int most = 400) {
  for (int i = 1; i <= most; ++i)
    if (control.judge(at(begin + i), fps, 25, busy)) return i;
  return 0;
}

TEST(LiveQualities, ArePossibleAndOrderedFromTheBestToTheFastest) {
  ASSERT_GE(live_qualities().size(), 3U);
  for (std::size_t i = 0; i < live_qualities().size(); ++i) {
    const LiveQuality& q = live_qualities()[i];
    render::RendererOptions renderer;
    renderer.flow = q.flow;
    EXPECT_THAT(check(q.node), IsOk()) << q.name;
    EXPECT_THAT(check(renderer), IsOk()) << q.name;
    EXPECT_THAT(render::make_flow_estimator(q.flow), IsOk()) << q.name;
    EXPECT_THAT(describe(q), testing::HasSubstr(q.name));
    if (i == 0) continue;
    const LiveQuality& better = live_qualities()[i - 1];
    EXPECT_GE(q.node.shrink, better.node.shrink);
    EXPECT_GE(q.node.tolerance, better.node.tolerance);
    EXPECT_GE(q.flow.finest_scale, better.flow.finest_scale);
    EXPECT_LE(q.flow.iterations, better.flow.iterations);
    if (q.method == better.method) {
      EXPECT_GE(q.output, better.output);
    }
    EXPECT_NE(describe(q), describe(better));
  }
}

TEST(LiveQualities, GiveUpWarpsThenTheFlowsResolutionThenOutlinesThenPixelsThenTheFlow) {
  const std::vector<LiveQuality>& q = live_qualities();
  ASSERT_EQ(q.size(), 6U);
  EXPECT_EQ(q[0].node.shrink, 1) << "whole pictures are keyed";
  EXPECT_EQ(q[0].flow.finest_scale, 0);
  EXPECT_LT(q[1].flow.iterations, q[0].flow.iterations);
  EXPECT_GT(q[2].flow.finest_scale, q[1].flow.finest_scale);
  EXPECT_GT(q[3].node.tolerance, q[2].node.tolerance);
  EXPECT_GT(q[4].output, q[3].output);
  EXPECT_EQ(q[4].method, "floating");
  EXPECT_EQ(q[5].method, "linear");
}

TEST(QualityControl, GoesDownWhenTwoWindowsWereTooSlow) {
  QualityControl control(12, 1);
  EXPECT_EQ(control.judge(at(1), 9, 25, 1), std::nullopt) << "one may be an accident";
  EXPECT_THAT(control.judge(at(2), 9, 25, 1), Optional(Eq(2U)));
  EXPECT_EQ(control.level(), 2U);
}

TEST(QualityControl, ForgetsOneSlowWindow) {
  QualityControl control(12, 1);
  EXPECT_EQ(control.judge(at(1), 9, 25, 1), std::nullopt);
  EXPECT_EQ(control.judge(at(2), 12, 25, 1), std::nullopt);
  EXPECT_EQ(control.judge(at(3), 9, 25, 1), std::nullopt);
}

TEST(QualityControl, AsksNoMoreThanTheCamerasDeliver) {
  QualityControl control(12, 1);
  for (int i = 1; i < 20; ++i)
    EXPECT_EQ(control.judge(at(i), 5, 5, 0.9), std::nullopt) << "the cameras run at 5 a second";
}

TEST(QualityControl, EndsAtTheFastest) {
  QualityControl control(12, live_qualities().size() - 1);
  EXPECT_EQ(windows_until_change(control, 0, 3, 1), 0);
}

TEST(QualityControl, GoesUpAfterAWhileOfEaseAndNeverWhileAtWork) {
  QualityControl control(12, 2);
  EXPECT_EQ(windows_until_change(control, 0, 13, 0.9), 0) << "fast enough, and no faster";
  EXPECT_GT(windows_until_change(control, 1000, 20, 0.9), 5) << "much faster than wanted";
  EXPECT_EQ(control.level(), 1U);
}

TEST(QualityControl, StaysWhileNothingComes) {
  QualityControl control(12, 2);
  for (int second = 0; second < 60; ++second)
    EXPECT_EQ(control.judge(at(second), 0, 0, 0), std::nullopt) << "no node was switched on yet";
  EXPECT_EQ(control.level(), 2U);
}

TEST(QualityControl, GoesUpWhenEveryInstantIsShownWithoutEffort) {
  QualityControl idle(25, 2), busy(25, 2);
  EXPECT_GT(windows_until_change(idle, 0, 25, 0.3), 5);
  EXPECT_EQ(windows_until_change(busy, 0, 25, 0.9), 0);
}

TEST(QualityControl, TriesABetterQualityLessOftenWhenItDidNotLast) {
  QualityControl control(12, 2);
  const int first = windows_until_change(control, 0, 20, 0.9);
  ASSERT_GT(first, 0);
  ASSERT_EQ(windows_until_change(control, first, 8, 1), 2);
  const int second = windows_until_change(control, first + 2, 20, 0.9);
  EXPECT_GT(second, first + first / 2);
}

TEST(QualityControl, LeavesAQualityThatWasAskedForAlone) {
  QualityControl control(0, 0);
  EXPECT_EQ(windows_until_change(control, 0, 1, 1), 0);
}

}  // namespace
}  // namespace floatstage::studio
