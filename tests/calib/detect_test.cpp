#include "calib/detect.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/calib/detections.h"
#include "tests/support/board_picture.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

using test::before_camera;
using test::board_picture;
using test::simple_camera;

constexpr const char* kChessboard = "chessboard columns=8 rows=5 square=60mm";
constexpr const char* kCharuco = "charuco columns=5 rows=7 square=50mm marker=37.5mm dictionary=4x4_100";
constexpr const char* kInverted =
    "charuco columns=4 rows=5 square=54mm marker=40.5mm dictionary=4x4_1000 inverted";
constexpr const char* kTags = "apriltags columns=4 rows=3 tag=66mm gap=19.8mm";
constexpr const char* kTwoSided =
    "two-sided columns=5 rows=6 square=50mm marker=37mm dictionary=5x5_100 thickness=5mm";

const CameraModel kCamera =
    simple_camera(1280, 720, 60, BrownConrady{.k1 = -0.2, .k2 = 0.05, .p1 = 0.001, .p2 = -0.0005});

struct Pose {
  double distance;
  Eigen::Vector3d degrees;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();
};
const Pose kPoses[] = {{0.9, {0, 0, 0}},
                       {0.9, {30, 0, 0}, {0.05, 0, 0}},
                       {1.1, {-20, 35, 10}, {0.1, 0.02, 0}},
                       {0.8, {10, -30, 95}},
                       {1.3, {-35, -15, 200}, {-0.3, 0.1, 0}}};

class EveryBoard : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Detect, EveryBoard,
                         testing::Values(kChessboard, kCharuco, kInverted, kTags, kTwoSided));

TEST_P(EveryBoard, IsFoundWhereItIsWithoutBias) {
  const TargetDesign design = target(GetParam());
  Errors all;
  std::size_t seen = 0, visible = 0;
  for (const Pose& pose : kPoses) {
    const Rigid3 at = before_camera(design, pose.distance, pose.degrees, pose.shift);
    const Image picture = board_picture(design, kCamera, at, {.samples = 6, .blur = 0.7, .noise = 2});
    const Detection found = detect(design, picture);
    EXPECT_EQ(found.failure, DetectionFailure::None)
        << GetParam() << " at " << pose.degrees.transpose() << ": " << found.reason;
    add_errors(all, found, test::true_pixels(design, kCamera, at));
    seen += found.points.size();
    visible += points_in_view(design, kCamera, at, 12);
  }
  EXPECT_GE(seen, 0.97 * static_cast<double>(visible)) << "points in view are found";
  EXPECT_LE(std::abs(all.mean().x()), 0.05);
  EXPECT_LE(std::abs(all.mean().y()), 0.05);
  EXPECT_LE(all.rms(), 0.1);
  EXPECT_LE(all.largest, 0.5);
}

TEST_P(EveryBoard, IsFoundAgainInAPictureThatSearchingLeavesAsItWas) {
  const TargetDesign design = target(GetParam());
  const Image picture =
      board_picture(design, kCamera, before_camera(design, 0.9, {20, 15, 5}), {.blur = 0.7, .noise = 2});
  const Image before = picture;
  const Detection first = detect(design, picture);
  EXPECT_EQ(picture, before);
  EXPECT_EQ(detect(design, picture), first);
}

TEST(Detect, PutsTheFirstPixelsCentreAtOneHalf) {
  // A crossing drawn by hand: edges between pixels 39|40 and 29|30 meet at the corner (40, 30).
  const TargetDesign design = target("chessboard columns=4 rows=3 square=10mm");
  Image picture(120, 100, 1, 220);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x)
      if ((x / 20 + y / 20) % 2 == 0) *picture.at(x + 20, y + 10) = 30;
  const Detection found = detect(design, picture);
  ASSERT_EQ(found.points.size(), 6u) << found.reason;
  EXPECT_EQ(found.points[0].id, 0);
  EXPECT_NEAR(found.points[0].pixel.x(), 40, 0.02);
  EXPECT_NEAR(found.points[0].pixel.y(), 30, 0.02);
  EXPECT_NEAR(found.points[5].pixel.x(), 80, 0.02);
  EXPECT_NEAR(found.points[5].pixel.y(), 50, 0.02);
}

TEST(Detect, NumbersAChessboardTheSameWayInEveryTurn) {
  const TargetDesign design = target(kChessboard);
  for (int degrees = 0; degrees < 360; degrees += 15) {
    const Rigid3 at = before_camera(design, 0.8, {15, 10, static_cast<double>(degrees)});
    const Detection found = detect(design, board_picture(design, kCamera, at));
    Errors errors;
    add_errors(errors, found, test::true_pixels(design, kCamera, at));
    EXPECT_EQ(errors.count, 28u) << degrees;
    EXPECT_LE(errors.largest, 0.3) << degrees;
  }
}

TEST(Detect, FindsTheBackOfATwoSidedBoardAtItsPlaceBehindTheFront) {
  const TargetDesign design = target(kTwoSided);
  const Rigid3 at = before_camera(design, 0.9, {10, 180, 0});
  const Detection found = detect(design, board_picture(design, kCamera, at, {.blur = 0.7}));
  ASSERT_GE(found.points.size(), 15u) << found.reason;
  EXPECT_GE(found.points.front().id, 20) << "points of the back follow the front's 20";
  Errors errors;
  add_errors(errors, found, test::true_pixels(design, kCamera, at));
  EXPECT_LE(errors.rms(), 0.1);
}

TEST(Detect, FindsABoardThroughAFisheye) {
  CameraModel camera{.width = 1280,
                     .height = 960,
                     .fx = 420,
                     .fy = 420,
                     .cx = 640,
                     .cy = 480,
                     .lens = KannalaBrandt{.k1 = 0.02, .k2 = -0.01, .k3 = 0.002, .k4 = 0}};
  for (const char* line : {kCharuco, kTags, kChessboard}) {
    const TargetDesign design = target(line);
    const Rigid3 at = before_camera(design, 0.45, {15, -20, 5}, {0.2, 0.05, 0});
    const Detection found =
        detect(design, board_picture(design, camera, at, {.samples = 6, .blur = 0.6, .noise = 2}));
    EXPECT_EQ(found.failure, DetectionFailure::None) << line << ": " << found.reason;
    Errors errors;
    add_errors(errors, found, test::true_pixels(design, camera, at));
    EXPECT_LE(errors.rms(), 0.15) << line;
  }
}

TEST(Detect, ReadsColourPicturesLikeGreyOnes) {
  const TargetDesign design = target(kCharuco);
  const Image grey = board_picture(design, kCamera, before_camera(design, 0.9, {20, 10, 0}));
  Image rgb(grey.width, grey.height, 3);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i)
    rgb.pixels[3 * i] = rgb.pixels[3 * i + 1] = rgb.pixels[3 * i + 2] = grey.pixels[i];
  EXPECT_EQ(detect(design, rgb), detect(design, grey));
}

TEST(Detect, FindsMoreThanHalfOfABoardThatIsCutOff) {
  const TargetDesign design = target(kCharuco);
  const Rigid3 at = before_camera(design, 0.7, {0, 20, 0}, {0.35, 0, 0});
  const Detection found = detect(design, board_picture(design, kCamera, at));
  EXPECT_EQ(found.failure, DetectionFailure::None) << found.reason;
  EXPECT_GE(found.points.size(), points_in_view(design, kCamera, at, 40));
  EXPECT_LT(found.points.size(), 24u);
}

TEST(Wand, BallsAreToldApartByTheirDistances) {
  const TargetDesign design = target("wand positions=0mm,150mm,450mm ball=25mm");
  for (int degrees = 0; degrees < 360; degrees += 30) {
    const Rigid3 at =
        before_camera(design, 2.0, {0, degrees % 60 == 0 ? 30.0 : -20.0, static_cast<double>(degrees)});
    const Detection found = detect(design, board_picture(design, kCamera, at, {.blur = 0.8, .noise = 2}));
    ASSERT_EQ(found.points.size(), 3u) << degrees << ": " << found.reason;
    Errors errors;
    add_errors(errors, found, test::true_pixels(design, kCamera, at));
    EXPECT_LE(errors.largest, 0.1) << degrees;
  }
}

TEST(Wand, SphereSeenAsideHasItsCentroidFurtherOutAsTheHeaderSays) {
  const TargetDesign design = target("wand positions=0mm,150mm,450mm ball=60mm");
  const CameraModel camera = simple_camera(1280, 720, 80);
  const Rigid3 at = before_camera(design, 1.0, {0, 0, 0}, {0.3, 0, 0});
  const Detection found = detect(design, board_picture(design, camera, at, {.samples = 8}));
  ASSERT_EQ(found.points.size(), 3u) << found.reason;
  const Eigen::Vector3d center = at * target_points(design)[2];
  const double off = found.points[2].pixel.x() - project(camera, center)->x();
  const double predicted = center.x() / center.z() * std::pow(0.03 / center.z(), 2) * camera.fx;
  EXPECT_GT(predicted, 0.2);
  EXPECT_NEAR(off, predicted, 0.05);
}

TEST(Wand, TagsAreFoundAtTheirCentres) {
  const TargetDesign design = target("wand positions=0mm,250mm tag=100mm dictionary=apriltag_36h11 first=2");
  const Rigid3 at = before_camera(design, 0.8, {25, 20, 40});
  const Detection found = detect(design, board_picture(design, kCamera, at, {.blur = 0.7, .noise = 2}));
  ASSERT_EQ(found.points.size(), 2u) << found.reason;
  Errors errors;
  add_errors(errors, found, test::true_pixels(design, kCamera, at));
  EXPECT_LE(errors.largest, 0.3);
}

}  // namespace
}  // namespace floatstage::calib
