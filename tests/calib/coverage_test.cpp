#include "calib/coverage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/calib/synthetic_capture.h"

namespace floatstage::calib {
namespace {

using testing::HasSubstr;

Observations ring_capture(int frames) {
  const CaptureOptions options{
      .frames = frames, .noise_px = 0, .outliers = 0, .extent = 0.9, .frame_seconds = 0.2};
  return capture(ring_rig(4), two_sided_board(10, 8, 0.1, 0.006), wandering(options), options);
}

Observations only(const Observations& all, const std::function<bool(const TargetView&)>& keep) {
  Observations out = all;
  std::erase_if(out.views, [&](const TargetView& v) { return !keep(v); });
  return out;
}

TEST(Coverage, GrowsWithEveryViewAndNeverFalls) {
  const Observations all = ring_capture(120);
  double before = -1;
  for (const int frames : {0, 1, 5, 20, 60, 120}) {
    const Coverage c = coverage_of(only(all, [&](const TargetView& v) { return v.frame < frames; }));
    const double now = completeness(c);
    EXPECT_GE(now, before) << frames;
    before = now;
  }
  EXPECT_GT(before, 0.9);
  const Coverage whole = coverage_of(all);
  for (const CameraCoverage& c : whole.cameras) {
    EXPECT_GT(c.covered, 0.5) << c.serial;
    EXPECT_GT(c.depth_ratio(), 1.5) << c.serial;
    EXPECT_GT(c.turned, 3) << c.serial;
    EXPECT_GT(c.leaned, 3) << c.serial;
  }
  EXPECT_EQ(whole.common[0][1], whole.common[1][0]);
}

TEST(Advice, BeginsWithTheCameraThatHasSeenNothing) {
  const Observations all = ring_capture(60);
  std::vector<Advice> advice = advise(coverage_of(only(all, [](const TargetView&) { return false; })));
  ASSERT_EQ(advice.size(), 4u);
  for (const Advice& a : advice) EXPECT_EQ(a.kind, AdviceKind::NeverSeen);
  advice = advise(coverage_of(only(all, [](const TargetView& v) { return v.camera != 2; })));
  EXPECT_EQ(advice.front().kind, AdviceKind::NeverSeen);
  EXPECT_EQ(advice.front().camera, all.cameras[2].serial);
}

TEST(Advice, NamesThePairThatNothingJoins) {
  const Observations all = ring_capture(120);
  // Cameras 0 and 1 see even frames, 2 and 3 odd ones: two halves of a rig.
  const Coverage halves =
      coverage_of(only(all, [](const TargetView& v) { return (v.camera < 2) == (v.frame % 2 == 0); }));
  EXPECT_EQ(halves.group[0], halves.group[1]);
  EXPECT_EQ(halves.group[2], halves.group[3]);
  EXPECT_NE(halves.group[0], halves.group[2]);
  const Advice first = advise(halves).front();
  EXPECT_EQ(first.kind, AdviceKind::NoCommonView);
  EXPECT_EQ(first.camera, all.cameras[2].serial);
  EXPECT_EQ(first.other, all.cameras[1].serial);
  EXPECT_THAT(first.sentence, HasSubstr("at once"));
  const std::vector<Advice> joined = advise(coverage_of(all));
  for (const Advice& a : joined) EXPECT_NE(a.kind, AdviceKind::NoCommonView) << a.sentence;
}

TEST(Advice, NamesTheEmptyPartOfAPicture) {
  const Observations all = ring_capture(200);
  Observations half = all;  // camera 1 has points in the left half only
  for (TargetView& v : half.views)
    if (v.camera == 1)
      std::erase_if(v.points, [&](const SeenPoint& p) { return p.pixel.x() > 0.5 * half.cameras[1].width; });
  std::erase_if(half.views, [](const TargetView& v) { return v.points.size() < 6; });
  const std::vector<Advice> advice = advise(coverage_of(half));
  const auto found = std::find_if(advice.begin(), advice.end(), [&](const Advice& a) {
    return a.kind == AdviceKind::Region && a.camera == half.cameras[1].serial;
  });
  ASSERT_NE(found, advice.end());
  EXPECT_THAT(found->sentence, HasSubstr("right"));
}

// A board before one camera at these distances (metres), turned and leaned by these degrees.
Observations poses(const std::vector<Eigen::Vector3d>& distance_turn_lean) {
  Observations o;
  const CameraModel model{
      .width = 640, .height = 480, .fx = 600, .fy = 600, .cx = 320, .cy = 240, .lens = {}};
  o.cameras.push_back({.serial = "a", .width = 640, .height = 480, .model = {}, .cam_from_world = {}});
  o.targets.push_back(grid_board(6, 5, 0.1));
  int frame = 0;
  for (const Eigen::Vector3d& p : distance_turn_lean) {
    const Eigen::Quaterniond turn = Eigen::AngleAxisd(p[1] * 0.0174533, Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(p[2] * 0.0174533, Eigen::Vector3d::UnitX());
    TargetView view{.camera = 0, .target = 0, .frame = frame++, .time = {}, .points = {}};
    for (const TargetPoint& t : o.targets[0].points)
      view.points.push_back(
          {t.id,
           *project(model, turn * (t.position - Eigen::Vector3d(0.25, 0.2, 0)) + Eigen::Vector3d(0, 0, p[0])),
           0.2});
    o.views.push_back(std::move(view));
  }
  return o;
}

TEST(Coverage, TellsDistancesAndTiltsWithoutASolution) {
  const CameraCoverage c =
      coverage_of(poses({{2, 0, 0}, {4, 5, 5}, {3, 35, 0}, {3, -40, 5}, {3, 0, 40}})).cameras[0];
  EXPECT_NEAR(c.depth_ratio(), 2, 0.1);
  EXPECT_EQ(c.facing, 2);
  EXPECT_EQ(c.turned, 2);
  EXPECT_EQ(c.leaned, 1);
}

TEST(Advice, AsksForDepthAndTiltWhereTheyAreMissing) {
  const auto kinds = [](const std::vector<Advice>& advice) {
    std::vector<AdviceKind> out;
    for (const Advice& a : advice) out.push_back(a.kind);
    return out;
  };
  std::vector<Eigen::Vector3d> flat(20, {4, 0, 0}), lively;
  for (int i = 0; i < 20; ++i)
    lively.push_back({1.5 + 0.15 * i, i % 3 == 0 ? 35.0 : 0, i % 3 == 1 ? 35.0 : 0});
  EXPECT_THAT(kinds(advise(coverage_of(poses(flat)))),
              testing::IsSupersetOf({AdviceKind::Nearer, AdviceKind::Turn, AdviceKind::Lean}));
  EXPECT_THAT(kinds(advise(coverage_of(poses(std::vector<Eigen::Vector3d>(20, {0.8, 0, 0}))))),
              testing::Contains(AdviceKind::Farther));
  const std::vector<AdviceKind> after = kinds(advise(coverage_of(poses(lively))));
  EXPECT_THAT(after, testing::Not(testing::Contains(
                         testing::AnyOf(AdviceKind::Nearer, AdviceKind::Turn, AdviceKind::Lean))));
}

}  // namespace
}  // namespace floatstage::calib
