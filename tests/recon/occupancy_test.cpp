#include "recon/occupancy.h"

#include <gtest/gtest.h>

#include "recon/shared_view.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/matchers.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

Rig ring(int cameras) { return shapes::ring_rig({.cameras = cameras}); }

// Cameras side by side that look the same way.
Rig parallel_rig() {
  Rig rig;
  for (int i = 0; i < 4; ++i) {
    RigCamera c = ring(1).cameras[0];
    c.serial = std::to_string(i);
    c.cam_from_world = look_at({0.1 * i, -3, 1}, {0.1 * i, 0, 1}, {0, 0, 1});
    rig.cameras.push_back(c);
  }
  return rig;
}

TEST(SharedView, OfARingIsAroundItsMiddleAndSeenByAll) {
  const Rig rig = ring(8);
  const Result<SharedView> view = shared_view(rig, 1);
  ASSERT_THAT(view, IsOk());
  EXPECT_LT((view->fixation - focus_point(rig)).norm(), 1e-9);
  EXPECT_EQ(view->seen_by, 8);
  EXPECT_GT(view->radius, 0);
  EXPECT_TRUE(view->box.contains(view->fixation));
  EXPECT_TRUE(view->astray.empty());
}

TEST(SharedView, NamesACameraThatLooksElsewhere) {
  Rig rig = ring(8);
  const Vector3d eye = rig.cameras[3].cam_from_world.center(), middle = focus_point(rig);
  rig.cameras[3].cam_from_world = look_at(eye, 2 * eye - middle, {0, 0, 1});
  const Result<SharedView> view = shared_view(rig);
  ASSERT_THAT(view, IsOk());
  EXPECT_EQ(view->astray, std::vector<int>{3});
}

TEST(SharedView, OfParallelCamerasLiesBeforeThem) {
  const Result<SharedView> view = shared_view(parallel_rig(), 1);
  ASSERT_THAT(view, IsOk());
  EXPECT_GT(view->fixation.y(), -3);
  EXPECT_GT(view->radius, 0);
}

TEST(SharedView, NeedsTwoCamerasThatSeeSomethingTogether) {
  EXPECT_THAT(shared_view(ring(1)), FailsWith(ErrorCode::InvalidArgument, "one camera"));
  Rig apart = ring(2);
  for (std::size_t i = 0; i < 2; ++i) {
    const double side = i ? 100 : -100;
    apart.cameras[i].cam_from_world = look_at({side, 0, 0}, {2 * side, 0, 0}, {0, 0, 1});
  }
  EXPECT_THAT(shared_view(apart, 1), FailsWith(ErrorCode::BadData, "no space"));
  EXPECT_THAT(shared_view(ring(3), 2), FailsWith(ErrorCode::InvalidArgument, "share"));
}

struct Seen {
  Rig rig = ring(8);
  std::vector<Matte> mattes;
  std::vector<Eigen::Vector2i> sizes;
  std::vector<OddsPicture> odds;
  Eigen::AlignedBox3d box;
};

// A ball in the middle of a ring; every camera is sure of what it sees.
Seen ball_in_a_ring() {
  Seen s;
  const Vector3d middle = focus_point(s.rig);
  const double r = 0.15 * (s.rig.cameras[0].cam_from_world.center() - middle).norm();
  s.mattes = shapes::render_mattes(s.rig, shapes::sphere(middle, r));
  s.box = Eigen::AlignedBox3d(middle - Vector3d::Constant(1.5 * r), middle + Vector3d::Constant(1.5 * r));
  for (const Matte& m : s.mattes) {
    s.sizes.emplace_back(m.width, m.height);
    OddsPicture o{m.width, m.height, {}};
    for (int y = 0; y < m.height; ++y)
      for (int x = 0; x < m.width; ++x) o.odds.push_back(m.row(y)[x] >= 128 ? 4.0f : -4.0f);
    s.odds.push_back(std::move(o));
  }
  return s;
}

double iou_with(const std::vector<float>& said, const Matte& matte) {
  Image silhouette(matte.width, matte.height, 1);
  for (std::size_t p = 0; p < said.size(); ++p) silhouette.pixels[p] = said[p] > 0 ? 255 : 0;
  return iou(make_matte({}, silhouette), matte);
}

// Share of the matte that is said to be subject.
double kept_of(const std::vector<float>& said, const Matte& matte) {
  int all = 0, kept = 0;
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      if (matte.row(y)[x] < 128) continue;
      ++all;
      kept += said[static_cast<std::size_t>(y) * static_cast<std::size_t>(matte.width) +
                   static_cast<std::size_t>(x)] > 0;
    }
  return static_cast<double>(kept) / all;
}

// Seven cameras in one plane leave the ball's hull taller than the ball, so the others' silhouette holds
// all of it and more.
TEST(Occupancy, SaysOfAPictureWhatTheOthersSee) {
  const Seen s = ball_in_a_ring();
  OccupancyGrid grid(s.rig, s.box, 200'000, s.sizes, 8, 1);
  grid.fuse(s.odds, {});
  for (int i = 0; i < 8; ++i) {
    const Matte& truth = s.mattes[static_cast<std::size_t>(i)];
    EXPECT_GT(iou_with(grid.said_by_others(i), truth), 0.75) << i;
    EXPECT_GT(kept_of(grid.said_by_others(i), truth), 0.97) << i;
  }
  EXPECT_GT(grid.occupied(), 0u);
  EXPECT_TRUE(s.box.contains(grid.subject_box()));
}

TEST(Occupancy, SurvivesACameraThatSeesNothing) {
  Seen s = ball_in_a_ring();
  for (float& o : s.odds[2].odds) o = -4;
  OccupancyGrid grid(s.rig, s.box, 200'000, s.sizes, 8, 1);
  grid.fuse(s.odds, {});
  EXPECT_GT(iou_with(grid.said_by_others(2), s.mattes[2]), 0.75);
  EXPECT_GT(kept_of(grid.said_by_others(2), s.mattes[2]), 0.97);
  EXPECT_GT(iou_with(grid.said_by_others(6), s.mattes[6]), 0.7);  // outvoted
}

TEST(Occupancy, AsksNobodyWithoutAPictureAndLeavesOutWhatTooFewSee) {
  Seen s = ball_in_a_ring();
  s.sizes[0] = {0, 0};
  s.odds[0] = {};
  OccupancyGrid seven(s.rig, s.box, 50'000, s.sizes, 7, 1), eight(s.rig, s.box, 50'000, s.sizes, 8, 1);
  seven.fuse(s.odds, {});
  eight.fuse(s.odds, {});
  EXPECT_GT(seven.occupied(), 0u);
  EXPECT_EQ(eight.occupied(), 0u);
  EXPECT_TRUE(eight.subject_box().isEmpty());
}

TEST(Occupancy, AsksOnlyBeforeAPlane) {
  const Seen s = ball_in_a_ring();
  OccupancyGrid grid(s.rig, s.box, 50'000, s.sizes, 8, 1);
  grid.fuse(s.odds, {});
  const Eigen::AlignedBox3d ball = grid.subject_box();
  const auto above = [&](double height) {
    return kept_of(grid.said_by_others_before(1, {{{Vector3d::UnitZ(), -height}}}), s.mattes[1]);
  };
  EXPECT_EQ(above(ball.min().z() - 1), kept_of(grid.said_by_others(1), s.mattes[1]));
  EXPECT_NEAR(above(ball.center().z()), 0.5, 0.25);
  EXPECT_EQ(above(ball.max().z()), 0);
}

TEST(Occupancy, IsTheSameAtAnyNumberOfThreads) {
  const Seen s = ball_in_a_ring();
  OccupancyGrid one(s.rig, s.box, 50'000, s.sizes, 6, 1), four(s.rig, s.box, 50'000, s.sizes, 6, 4);
  one.fuse(s.odds, {});
  four.fuse(s.odds, {});
  EXPECT_EQ(one.said_by_others(5), four.said_by_others(5));
  EXPECT_EQ(one.said_by_all(1), four.said_by_all(1));
}

}  // namespace
}  // namespace floatstage::recon
