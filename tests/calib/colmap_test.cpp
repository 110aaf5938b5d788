#include "calib/formats/parsers.h"
#include "core/file.h"
#include "tests/calib/format_support.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

const std::string kCameras =
    "# Camera list with one line of data per camera:\n"
    "1 PINHOLE 2 2 3 4 1 1\n"
    "7 OPENCV 640 480 800 810 322.5 241.5 0.1 -0.2 0.001 0.002\n";
// The second image's points are there, the first one's line is empty.
const std::string kImages =
    "# Image list with two lines of data per image:\n"
    "3 1 0 0 0 0.5 -0.5 2 1 left.png\n"
    "\n"
    "4 0.5 0.5 0.5 0.5 0 0 1 7 right/first shot.png\n"
    "12.5 13.5 -1 100 200 17\n";

Result<ForeignRig> parse(std::string_view cameras, std::string_view images) {
  return parse_colmap(cameras, images, "cameras.txt", "images.txt");
}

std::string one_camera(const std::string& model) { return "1 " + model + "\n"; }
const std::string kOneImage = "1 1 0 0 0 0 0 0 1 a.png\n\n";

TEST(Colmap, KeepsTheCentreOfATwoByTwoImageAtOneOne) {
  const Result<ForeignRig> rig = parse(kCameras, kImages);
  ASSERT_TRUE(rig.has_value()) << rig.error().message;
  const CameraModel& m = rig->rig.cameras[0].model;
  EXPECT_EQ(m.width, 2);
  EXPECT_EQ(m.height, 2);
  EXPECT_EQ(m.cx, 1.0);
  EXPECT_EQ(m.cy, 1.0);
  EXPECT_EQ(m.fy, 4.0);
}

TEST(Colmap, ReadsPosesAsCameraFromWorldWithTheRealPartFirst) {
  const Result<ForeignRig> rig = parse(kCameras, kImages);
  ASSERT_TRUE(rig.has_value());
  EXPECT_TRUE(rig->rig.cameras[0].cam_from_world.center().isApprox(Eigen::Vector3d(-0.5, 0.5, -2)));
  // (½,½,½,½) takes x to y, y to z and z to x.
  const Eigen::Vector3d x = rig->rig.cameras[1].cam_from_world * Eigen::Vector3d(1, 2, 3);
  EXPECT_TRUE(x.isApprox(Eigen::Vector3d(3, 1, 3))) << x;
}

TEST(Colmap, TakesTheWholeRestOfTheLineAsTheImagesName) {
  const Result<ForeignRig> rig = parse(kCameras, kImages);
  ASSERT_TRUE(rig.has_value());
  EXPECT_EQ(rig->image_names[1], "right/first shot.png");
  EXPECT_EQ(rig->rig.cameras[1].serial, "right_first_shot");
}

TEST(Colmap, KnowsEveryLensItCanHold) {
  const auto lens = [](const std::string& model) -> Lens {
    const Result<ForeignRig> rig = parse(one_camera(model), kOneImage);
    EXPECT_TRUE(rig.has_value()) << rig.error().message;
    return rig->rig.cameras[0].model.lens;
  };
  EXPECT_EQ(lens("SIMPLE_PINHOLE 4 4 3 2 2"), Lens(std::monostate{}));
  EXPECT_EQ(lens("SIMPLE_RADIAL 4 4 3 2 2 0.1"), Lens(BrownConrady{.k1 = 0.1}));
  EXPECT_EQ(lens("RADIAL 4 4 3 2 2 0.1 0.2"), Lens(BrownConrady{.k1 = 0.1, .k2 = 0.2}));
  EXPECT_EQ(lens("OPENCV 4 4 3 3 2 2 1 2 3 4"), Lens(BrownConrady{1, 2, 3, 4}));
  EXPECT_EQ(lens("FULL_OPENCV 4 4 3 3 2 2 1 2 3 4 5 0 0 0"), Lens(BrownConrady{1, 2, 3, 4, 5}));
  EXPECT_EQ(lens("FULL_OPENCV 4 4 3 3 2 2 1 2 3 4 5 6 7 8"), Lens(BrownConrady{1, 2, 3, 4, 5, 6, 7, 8}));
  EXPECT_EQ(lens("OPENCV_FISHEYE 4 4 3 3 2 2 1 2 3 4"), Lens(KannalaBrandt{1, 2, 3, 4}));
}

TEST(Colmap, NamesTheModelThatItCannotHold) {
  expect_error(parse(one_camera("THIN_PRISM_FISHEYE 4 4 3 3 2 2 1 2 3 4 5 6 7 8"), kOneImage),
               ErrorCode::Unsupported, {"cameras.txt: line 1", "THIN_PRISM_FISHEYE"});
}

TEST(Colmap, SaysWhichLineIsWrong) {
  expect_error(parse(replaced(kCameras, "3 4 1 1", "3 4 1"), kImages), ErrorCode::BadData,
               {"cameras.txt: line 2", "4 parameters"});
  expect_error(parse(replaced(kCameras, "-0.2", "nan"), kImages), ErrorCode::BadData, {"line 3", "nan"});
  expect_error(parse(replaced(kCameras, "640", "0"), kImages), ErrorCode::BadData, {"line 3", "size"});
  expect_error(parse(replaced(kCameras, "7 OPENCV", "1 OPENCV"), kImages), ErrorCode::BadData,
               {"line 3", "second time"});
  expect_error(parse(kCameras, replaced(kImages, "1 7 right", "1 8 right")), ErrorCode::BadData,
               {"images.txt: line 4", "camera 8", "cameras.txt"});
  expect_error(parse(kCameras, replaced(kImages, "0.5 0.5 0.5 0.5", "0.5 0.5 0.5 0.6")), ErrorCode::BadData,
               {"line 4", "length"});
  expect_error(parse(kCameras, replaced(kImages, "-0.5 2", "inf 2")), ErrorCode::BadData, {"line 2", "inf"});
}

TEST(Colmap, NoticesThatTheLinesOfPointsWereLeftOut) {
  expect_error(parse(kCameras, replaced(kImages, "left.png\n\n", "left.png\n")), ErrorCode::BadData,
               {"line 3", "points"});
}

TEST(Colmap, RefusesEveryTruncation) {
  expect_truncations_refused(replaced(kCameras, "0.002", "2"), 2,
                             [](std::string_view cut) { return parse(cut, kImages); });
  const std::string poses =
      kImages.substr(0, kImages.find("\n12.5"));  // a cut among the points loses nothing of ours
  for (std::size_t length = 0; length + 4 < poses.size(); ++length) {
    const Result<ForeignRig> rig = parse(kCameras, std::string_view(poses).substr(0, length));
    EXPECT_TRUE(!rig.has_value() || rig->rig.cameras.size() < 2 ||
                rig->image_names[1] != "right/first shot.png")
        << length;
  }
}

TEST(Colmap, ComesBackFromTheWriterUnchanged) {
  for (const Lens& lens : {Lens{}, Lens(BrownConrady{0.1, -0.2, 0.003, 0.004}),
                           Lens(BrownConrady{0.1, 0, 0, 0, 0.2}), Lens(KannalaBrandt{0.1, 0.2, 0.3, 0.4})})
    for (bool tiny : {false, true}) {
      TempFolder folder;
      const Rig rig = sample_rig(lens, tiny);
      ASSERT_TRUE(write_colmap(rig, {"cam0", "cam1", "cam2"}, folder / "sparse").has_value());
      const Result<ForeignRig> again = read_colmap(folder / "sparse");
      ASSERT_TRUE(again.has_value()) << again.error().message;
      expect_same(rig, again->rig);
      EXPECT_EQ(again->rig.cameras[0].model.width, rig.cameras[0].model.width);
    }
}

TEST(Colmap, WriterRefusesSkewAndMissingNames) {
  TempFolder folder;
  Rig rig = sample_rig(Lens{});
  expect_error(write_colmap(rig, {"a"}, folder / "s"), ErrorCode::InvalidArgument, {"1 image names for 3"});
  rig.cameras[2].model.skew = 0.1;
  expect_error(write_colmap(rig, {"a", "b", "c"}, folder / "s"), ErrorCode::Unsupported, {"cam2", "skew"});
  EXPECT_THAT(folder.names(), testing::IsEmpty());
}

TEST(Colmap, MissingFilesAreNamed) {
  TempFolder folder;
  expect_error(read_colmap(folder.path()), ErrorCode::NotFound, {"cameras.txt"});
  folder.write("cameras.txt", kCameras);
  expect_error(read_colmap(folder.path()), ErrorCode::NotFound, {"images.txt"});
}

}  // namespace
}  // namespace floatstage::calib
