#include "calib/formats/parsers.h"
#include "core/file.h"
#include "tests/calib/format_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

// As Kalibr writes it: rows wrapped where its YAML library wraps them.
const std::string kTwoKalibrCameras =
    "cam0:\n"
    "  cam_overlaps: [1]\n"
    "  camera_model: pinhole\n"
    "  distortion_coeffs: [-0.25, 0.05, 0.001, -0.002]\n"
    "  distortion_model: radtan\n"
    "  intrinsics: [3, 4, 0.5, 0.5]\n"
    "  resolution: [2, 2]\n"
    "  rostopic: /cam0/image_raw\n"
    "cam1:\n"
    "  T_cn_cnm1:\n"
    "  - [0.0, 1.0, 0.0, -0.11]\n"
    "  - [-1.0, 0.0,\n"
    "    0.0, 0.25]\n"
    "  - [0.0, 0.0, 1.0, 0.5]\n"
    "  - [0.0, 0.0, 0.0, 1.0]\n"
    "  cam_overlaps: [0]\n"
    "  camera_model: pinhole\n"
    "  distortion_coeffs: [0.1, 0.2, 0.3, 0.4]\n"
    "  distortion_model: equidistant\n"
    "  intrinsics: [5, 6, 319.5, 239.5]\n"
    "  resolution: [640, 480]\n"
    "  rostopic: /right/image_raw\n";

Result<ForeignRig> kalibr(std::string_view yaml) { return parse_kalibr(yaml, "camchain.yaml"); }

TEST(Kalibr, PutsTheCentreOfATwoByTwoImageAtOneOne) {
  const Result<ForeignRig> rig = kalibr(kTwoKalibrCameras);
  ASSERT_THAT(rig, IsOk());
  const CameraModel& m = rig->rig.cameras[0].model;
  EXPECT_EQ(m.width, 2);
  EXPECT_EQ(m.cx, 1.0);
  EXPECT_EQ(m.cy, 1.0);
  EXPECT_EQ(m.fy, 4.0);
}

TEST(Kalibr, ReadsBothLensesAndNamesFromTopics) {
  const Result<ForeignRig> rig = kalibr(kTwoKalibrCameras);
  ASSERT_THAT(rig, IsOk());
  EXPECT_EQ(rig->rig.cameras[0].model.lens, Lens(BrownConrady{-0.25, 0.05, 0.001, -0.002, 0}));
  EXPECT_EQ(rig->rig.cameras[1].model.lens, Lens(KannalaBrandt{0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(rig->rig.cameras[0].serial, "cam0");
  EXPECT_EQ(rig->rig.cameras[1].serial, "right");
}

TEST(Kalibr, ChainsTransformsFromCameraToCamera) {
  const Result<ForeignRig> rig = kalibr(kTwoKalibrCameras);
  ASSERT_THAT(rig, IsOk());
  EXPECT_EQ(rig->rig.cameras[0].cam_from_world.translation, Eigen::Vector3d::Zero());
  EXPECT_TRUE((rig->rig.cameras[1].cam_from_world * Eigen::Vector3d(1, 2, 3))
                  .isApprox(Eigen::Vector3d(1.89, -0.75, 3.5)));
}

TEST(Kalibr, SurvivesARoundTripRelativeToItsFirstCamera) {
  for (const Lens& lens : {Lens{}, Lens(BrownConrady{-0.1, 0.02, 0.001, 0.002, 0}),
                           Lens(KannalaBrandt{0.1, -0.02, 0.003, 0.004})}) {
    const TempFolder folder;
    Rig rig = sample_rig(lens);
    ASSERT_THAT(write_kalibr(rig, folder / "camchain.yaml"), IsOk());
    const Result<ForeignRig> back = read_kalibr(folder / "camchain.yaml");
    ASSERT_THAT(back, IsOk());
    const Rigid3 world_from_first = rig.cameras[0].cam_from_world.inverse();
    for (RigCamera& c : rig.cameras) c.cam_from_world = c.cam_from_world * world_from_first;
    expect_same(back->rig, rig, 1e-12);
  }
}

TEST(Kalibr, WritesTheHalfPixelBetweenTheOrigins) {
  const TempFolder folder;
  ASSERT_THAT(write_kalibr(sample_rig({}, true), folder / "c.yaml"), IsOk());
  EXPECT_THAT(*read_file(folder / "c.yaml"), testing::HasSubstr("intrinsics: [3, 3, 0.5, 0.5]"));
}

TEST(Kalibr, RefusesToWriteWhatItCannotHold) {
  const TempFolder folder;
  const std::filesystem::path kept = folder.write("c.yaml", "kept");
  expect_error(write_kalibr(sample_rig(BrownConrady{.k3 = 0.1}), kept), ErrorCode::Unsupported,
               {"cam0", "k3"});
  Rig skewed = sample_rig({});
  skewed.cameras[1].model.skew = 1;
  expect_error(write_kalibr(skewed, kept), ErrorCode::Unsupported, {"cam1", "skew"});
  EXPECT_EQ(*read_file(kept), "kept");
}

TEST(Kalibr, SaysWhichLineAndCameraIsWrong) {
  expect_error(kalibr(""), ErrorCode::BadData, {"camchain.yaml", "no camera"});
  expect_error(kalibr("left:\n  a: 1\n"), ErrorCode::BadData, {"line 1", "'left'"});
  expect_error(kalibr("  a: 1\n"), ErrorCode::BadData, {"line 1", "before this"});
  expect_error(kalibr(replaced(kTwoKalibrCameras, "[3, 4,", "[3, nan,")), ErrorCode::BadData,
               {"line 6", "cam0", "nan"});
  expect_error(kalibr(replaced(kTwoKalibrCameras, "[3, 4,", "[3,")), ErrorCode::BadData,
               {"line 6", "3 numbers"});
  expect_error(kalibr(replaced(kTwoKalibrCameras, "pinhole", "omni")), ErrorCode::Unsupported,
               {"line 3", "'omni'"});
  expect_error(kalibr(replaced(kTwoKalibrCameras, "radtan", "fov")), ErrorCode::Unsupported,
               {"line 5", "'fov'"});
  expect_error(kalibr(replaced(kTwoKalibrCameras, "[0.0, 1.0, 0.0, -0.11]", "[0.0, -1.0, 0.0, -0.11]")),
               ErrorCode::BadData, {"line 10", "mirror"});
  expect_error(kalibr(replaced(kTwoKalibrCameras, "[0.0, 0.0, 0.0, 1.0]", "[0.0, 0.0, 0.0, 2.0]")),
               ErrorCode::BadData, {"cam1", "0 0 0 1"});
  expect_error(kalibr(replaced(kTwoKalibrCameras, "T_cn_cnm1", "T_other")), ErrorCode::BadData,
               {"line 9", "T_cn_cnm1 is missing"});
  expect_error(kalibr(replaced(kTwoKalibrCameras, "[640, 480]", "[0, 480]")), ErrorCode::BadData,
               {"resolution"});
  expect_error(kalibr(replaced(kTwoKalibrCameras, "/right/", "/cam0/")), ErrorCode::BadData, {"cam0"});
}

TEST(Kalibr, RefusesTruncations) {
  // What comes last is only a name.
  expect_truncations_refused(kTwoKalibrCameras.substr(0, kTwoKalibrCameras.find("  rostopic: /right")), 2,
                             kalibr);
}

TEST(QualisysWriter, SurvivesARoundTrip) {
  for (const Lens& lens : {Lens{}, Lens(BrownConrady{-0.1, 0.02, 0.001, 0.002, 0.003})}) {
    const TempFolder folder;
    const Rig rig = sample_rig(lens);
    ASSERT_THAT(write_qualisys(rig, folder / "a.qca.txt"), IsOk());
    const Result<ForeignRig> back = read_qualisys(folder / "a.qca.txt");
    ASSERT_THAT(back, IsOk());
    expect_same(back->rig, rig, 1e-12);
  }
}

TEST(QualisysWriter, PutsTheCentreOfATwoByTwoImageHalfAPixelFromItsFirst) {
  const TempFolder folder;
  ASSERT_THAT(write_qualisys(sample_rig({}, true), folder / "a.qca.txt"), IsOk());
  EXPECT_THAT(*read_file(folder / "a.qca.txt"),
              testing::HasSubstr("centerPointU=\"32\" centerPointV=\"32\""));
}

TEST(QualisysWriter, RefusesAFisheye) {
  const TempFolder folder;
  expect_error(write_qualisys(sample_rig(KannalaBrandt{0.1, 0, 0, 0}), folder / "a.qca.txt"),
               ErrorCode::Unsupported, {"cam0", "fisheye"});
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace floatstage::calib
