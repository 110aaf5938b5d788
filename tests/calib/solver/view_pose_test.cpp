// Where one camera's view of one target puts it, and what must come back as nothing.

#include "calib/solver/view_pose.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "calib/solver/scene.h"
#include "core/random.h"

namespace floatstage::calib::solver {
namespace {

using Eigen::Vector3d;

constexpr double kRadians = std::numbers::pi / 180;
constexpr int kWidth = 640, kHeight = 480;

Intrinsics intrinsics_of(LensKind lens) {
  Intrinsics in = Intrinsics::Zero();
  in.head<4>() << 800, 790, 320, 240;
  auto coefficients = in.segment<kLensRows>(kLensRow);
  if (lens == LensKind::BrownConrady) coefficients.head<5>() << -0.1, 0.03, 0.002, -0.003, 0.01;
  if (lens == LensKind::KannalaBrandt) coefficients.head<4>() << -0.02, 0.01, -0.003, 0.0004;
  return in;
}

std::vector<Vector3d> grid(int columns, int rows, double pitch) {
  std::vector<Vector3d> points;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c)
      points.emplace_back(pitch * (c - 0.5 * (columns - 1)), pitch * (r - 0.5 * (rows - 1)), 0);
  return points;
}

std::vector<Vector3d> box(double side) {
  std::vector<Vector3d> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(side * (i & 1), 0.8 * side * ((i >> 1) & 1), 1.3 * side * ((i >> 2) & 1));
  return corners;
}

Rigid3 pose(double about_x, double about_y, const Vector3d& place) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(about_x * kRadians, Vector3d::UnitX()) *
                             Eigen::AngleAxisd(about_y * kRadians, Vector3d::UnitY()) *
                             Eigen::AngleAxisd(0.3, Vector3d::UnitZ())),
          place};
}

std::vector<Correspondence> seen(const std::vector<Vector3d>& points, const Rigid3& cam_from_target,
                                 LensKind lens = LensKind::None, double noise = 0) {
  Random random(5);
  std::vector<Correspondence> out;
  for (const Vector3d& p : points) {
    Projected projected;
    EXPECT_TRUE(project(intrinsics_of(lens), lens, cam_from_target * p, projected));
    out.push_back({p, projected.pixel + noise * Eigen::Vector2d(random.normal(), random.normal())});
  }
  return out;
}

std::optional<ViewPose> found(const std::vector<Correspondence>& points, LensKind lens = LensKind::None) {
  return view_pose(intrinsics_of(lens), lens, kWidth, kHeight, points);
}

void expect_there(const std::optional<ViewPose>& pose, const Rigid3& truth, double metres, double degrees) {
  ASSERT_TRUE(pose);
  EXPECT_LT((pose->cam_from_target.translation - truth.translation).norm(), metres);
  EXPECT_LT(angle_between(pose->cam_from_target.rotation, truth.rotation) / kRadians, degrees);
}

class EveryLensPose : public testing::TestWithParam<LensKind> {};
INSTANTIATE_TEST_SUITE_P(Lenses, EveryLensPose,
                         testing::Values(LensKind::None, LensKind::BrownConrady, LensKind::KannalaBrandt));

TEST_P(EveryLensPose, FindsAFlatBoard) {
  const Rigid3 truth = pose(25, -30, {0.1, -0.05, 1.6});
  expect_there(found(seen(grid(7, 5, 0.08), truth, GetParam()), GetParam()), truth, 1e-6, 1e-4);
}

TEST_P(EveryLensPose, FindsASolidTarget) {
  const Rigid3 truth = pose(40, 20, {-0.1, -0.1, 1.5});
  expect_there(found(seen(box(0.25), truth, GetParam()), GetParam()), truth, 1e-6, 1e-4);
}

TEST(ViewPose, NeedsFourCoplanarPoints) {
  const Rigid3 truth = pose(30, 10, {0, 0, 1.2});
  const std::vector<Correspondence> four = seen(grid(2, 2, 0.2), truth);
  expect_there(found(four), truth, 1e-6, 1e-4);
  EXPECT_FALSE(found({four.begin(), four.begin() + 3}));
  EXPECT_FALSE(found({}));
}

TEST(ViewPose, NeedsSixPointsThatAreNotCoplanar) {
  const std::vector<Correspondence> corners = seen(box(0.25), pose(40, 20, {-0.1, -0.1, 1.5}));
  EXPECT_TRUE(found({corners.begin(), corners.begin() + 6}));
  EXPECT_FALSE(found({corners.begin(), corners.begin() + 5}));
}

TEST(ViewPose, KnowsNothingFromPointsOnALine) {
  const Rigid3 truth = pose(20, 20, {0, 0, 1.5});
  EXPECT_FALSE(found(seen(grid(8, 1, 0.06), truth))) << "along a line";
  std::vector<Vector3d> nearly = grid(8, 1, 0.06);
  for (std::size_t i = 0; i < nearly.size(); ++i) nearly[i].y() = i % 2 ? 5e-4 : 0;
  EXPECT_FALSE(found(seen(nearly, truth))) << "a strip a hundred times longer than wide";
  EXPECT_FALSE(found(seen(std::vector<Vector3d>(6, Vector3d(0.1, 0, 0)), truth))) << "one point six times";
}

// A flat board's picture fits two tilts nearly alike, mirrored at the line of sight.
TEST(ViewPose, TakesTheTiltThatFitsOfTheTwoThatAFlatBoardCanHave) {
  for (const double about_x : {-35.0, 35.0})
    for (const double about_y : {-25.0, 25.0}) {
      const Rigid3 truth = pose(about_x, about_y, {0.05, 0.02, 1.5});
      expect_there(found(seen(grid(7, 5, 0.05), truth, LensKind::None, 0.1)), truth, 0.01, 1);
    }
}

TEST(ViewPose, SaysOfBothTiltsTheBetterErrorWhereNoiseHidesTheDifference) {
  const Rigid3 truth = pose(0, 40, {0, 0, 6});  // a hand's breadth at six metres
  const std::vector<Correspondence> points = seen(grid(4, 4, 0.03), truth, LensKind::None, 0.3);
  const std::optional<ViewPose> best = found(points);
  ASSERT_TRUE(best);
  for (const double about_y : {40.0, -40.0}) {
    const ViewPose one =
        refine_pose(intrinsics_of(LensKind::None), LensKind::None, points, pose(0, about_y, {0, 0, 6}));
    EXPECT_LE(best->error, one.error + 0.01) << "from " << about_y << "°";
  }
}

// What lines of sight through the back of the camera would show of a target behind it.
std::vector<Correspondence> behind(const std::vector<Vector3d>& points, const Rigid3& cam_from_target) {
  const Intrinsics in = intrinsics_of(LensKind::None);
  std::vector<Correspondence> out;
  for (const Vector3d& p : points) {
    const Vector3d x = cam_from_target * p;
    EXPECT_LT(x.z(), 0);
    out.push_back({p, {in[0] * x.x() / x.z() + in[2], in[1] * x.y() / x.z() + in[3]}});
  }
  return out;
}

TEST(ViewPose, PutsAFlatBoardThatIsBehindTheCameraBeforeIt) {
  const std::optional<ViewPose> flat = found(behind(grid(7, 5, 0.08), pose(25, -30, {0.1, -0.05, -1.6})));
  ASSERT_TRUE(flat) << "a plane is its own mirror image: there is such a board in front";
  EXPECT_LT(flat->error, 1e-3);
  for (const Vector3d& p : grid(7, 5, 0.08)) EXPECT_GT((flat->cam_from_target * p).z(), 0);
}

TEST(ViewPose, FitsNoSolidTargetThatIsBehindTheCamera) {
  const std::optional<ViewPose> mirrored = found(behind(box(0.25), pose(40, 20, {-0.1, -0.1, -1.5})));
  EXPECT_TRUE(!mirrored || mirrored->error > 2) << mirrored->error << " px";
}

TEST(ViewPose, TakesNoHarmFromAFewWrongPoints) {
  const Rigid3 truth = pose(25, -30, {0.1, -0.05, 1.6});
  std::vector<Correspondence> points = seen(grid(7, 5, 0.08), truth, LensKind::None, 0.1);
  for (const std::size_t wrong : {3u, 11u, 20u, 33u}) points[wrong].pixel += Eigen::Vector2d(40, -25);
  expect_there(found(points), truth, 0.005, 0.5);
}

TEST(RefinePose, IsInfinitelyOffWhereNothingIsInFront) {
  const std::vector<Correspondence> points = seen(grid(7, 5, 0.08), pose(0, 0, {0, 0, 1.6}));
  const ViewPose behind =
      refine_pose(intrinsics_of(LensKind::None), LensKind::None, points, pose(0, 0, {0, 0, -1.6}));
  EXPECT_EQ(behind.error, std::numeric_limits<double>::infinity());
}

TEST(HomographyError, IsNothingForAFlatBoardAndNeedsNoIntrinsics) {
  EXPECT_LT(homography_error(seen(grid(7, 5, 0.08), pose(25, -30, {0.1, -0.05, 1.6}))), 1e-6);
}

TEST(HomographyError, TellsAWrongLayout) {
  const Rigid3 truth = pose(25, -30, {0.1, -0.05, 1.6});
  std::vector<Correspondence> points = seen(grid(7, 5, 0.08), truth);
  const std::vector<Vector3d> exchanged = grid(5, 7, 0.08);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].position = exchanged[i];
  EXPECT_GT(homography_error(points), 5);
}

TEST(HomographyError, IsInfiniteForWhatAlwaysFits) {
  EXPECT_TRUE(std::isinf(homography_error(seen(grid(2, 2, 0.2), pose(25, -30, {0, 0, 1.6})))));
}

}  // namespace
}  // namespace floatstage::calib::solver
