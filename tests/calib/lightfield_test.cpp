#include "calib/formats/parsers.h"
#include "core/file.h"
#include "core/jpeg.h"
#include "core/png.h"
#include "tests/calib/format_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

const std::vector<std::string> kNames = {"shop_01_01_92.5_-185_30_36.png", "shop_01_04_92.5_0.0_30_36.png"};

TEST(Lightfield, ReadsWhereEveryPictureWasTakenFromItsName) {
  const Result<ForeignRig> rig = parse_lightfield(kNames, 960, 640, "shop");
  ASSERT_THAT(rig, IsOk());
  ASSERT_EQ(rig->rig.cameras.size(), 2u);
  const RigCamera& left = rig->rig.cameras[0];
  EXPECT_EQ(left.serial, "shop_01_01_92.5_-185_30_36");
  EXPECT_EQ(rig->image_names[1], kNames[1]);
  EXPECT_DOUBLE_EQ(left.model.fx, 800);
  EXPECT_DOUBLE_EQ(left.model.cx, 480) << "corner convention: the middle";
  EXPECT_TRUE(left.cam_from_world.center().isApprox(Eigen::Vector3d(-0.185, 0, -0.0925))) << "y goes down";
  const Eigen::Vector3d seen = left.cam_from_world * Eigen::Vector3d(0, 2, 0);
  EXPECT_TRUE(seen.isApprox(Eigen::Vector3d(0.185, -0.0925, 2))) << "what lies right and above is seen there";
}

TEST(Lightfield, PutsTheCentreOfATwoByTwoImageAtOneOne) {
  const Result<ForeignRig> rig = parse_lightfield(kNames, 2, 2, "shop");
  ASSERT_THAT(rig, IsOk());
  EXPECT_EQ(rig->rig.cameras[0].model.cx, 1.0);
  EXPECT_EQ(rig->rig.cameras[0].model.cy, 1.0);
}

TEST(Lightfield, RefusesNamesThatSayNothing) {
  for (const char* wrong : {"shop_01_01_92.5_-185_30.png", "shop_01_01_a_0_30_36.png", "_1_2_3_4_5_6.png",
                            "shop_01_01_nan_0_30_36.png", "shop_01_01_1e999_0_30_36.png", "png"})
    expect_error(parse_lightfield({wrong}, 9, 9, "shop"), ErrorCode::BadData, {"shop", wrong});
  for (const char* wrong : {"s_1_1_0_0_0_36.png", "s_1_1_0_0_30_-36.png", "s_-1_1_0_0_30_36.png"})
    expect_error(parse_lightfield({wrong}, 9, 9, "shop"), ErrorCode::BadData, {wrong, "none can be"});
  expect_error(parse_lightfield({kNames[0], kNames[0]}, 9, 9, "shop"), ErrorCode::BadData, {"shop"});
}

TEST(Lightfield, TakesThePicturesSizeFromTheirHeadersInTheFolderOrInViews) {
  for (const char* below : {"", "views"}) {
    const TempFolder folder;
    const std::filesystem::path pictures = folder.path() / below;
    std::filesystem::create_directories(pictures);
    ASSERT_THAT(save_png(Image(30, 20, 3), pictures / kNames[0]), IsOk());
    Result<ForeignRig> rig = read_rig({.path = folder.path()});
    ASSERT_THAT(rig, IsOk()) << "recognised by its names";
    EXPECT_EQ(rig->rig.cameras[0].model.width, 30);
    EXPECT_EQ(rig->rig.cameras[0].model.height, 20);
    EXPECT_TRUE(std::filesystem::equivalent(rig->pictures, pictures)) << rig->pictures;
  }
  const TempFolder folder;
  folder.write("s_1_1_0_0_30_36.jpg", encode_jpeg(Image(50, 40, 3, 99), 80));
  EXPECT_EQ(read_lightfield(folder.path())->rig.cameras[0].model.height, 40);
}

TEST(Lightfield, RefusesPicturesThatAreCutOff) {
  const std::string whole = encode_jpeg(Image(50, 40, 3, 99), 80);
  const TempFolder folder;
  for (std::size_t length = 0; length < whole.size(); length += 7) {
    folder.write("s_1_1_0_0_30_36.jpg", whole.substr(0, length));
    const Result<ForeignRig> rig = read_lightfield(folder.path());
    if (rig) {
      EXPECT_EQ(rig->rig.cameras[0].model.width, 50) << "cut after its header";
    }
    if (length < 20) {
      EXPECT_THAT(rig, FailsWith(ErrorCode::BadData, "no whole JPEG or PNG"));
    }
  }
  EXPECT_THAT(read_lightfield(folder / "nowhere"), FailsWith(ErrorCode::NotFound, "nowhere"));
}

}  // namespace
}  // namespace floatstage::calib
