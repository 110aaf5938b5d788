#include "calib/formats/parsers.h"
#include "core/file.h"
#include "tests/calib/format_support.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

const std::string kIntri =
    "%YAML:1.0\n---\nnames:\n   - \"01\"\n   - right\n"
    "K_01: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 3., 0., 0.5, 0., 4., 0.5, 0., 0., "
    "1. ]\n"
    "dist_01: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ 0.1, -0.2, 0.001, 0.002, 0.05 ]\n"
    "K_right: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 800., 0., 320., 0., 800., 240., "
    "0., 0.,\n       1. ]\n"
    "H_right: 480\nW_right: 640\n";
const std::string kExtri =
    "%YAML:1.0\n---\nnames:\n   - \"01\"\n   - right\n"
    "R_01: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ 0., 0., 1.5707963267948966 ]\n"
    "T_01: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ 1., 2., 3. ]\n"
    "R_right: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ 0., 0., 0. ]\n"
    "Rot_right: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [ 0., -1., 0., 1., 0., 0., 0., "
    "0., 1. ]\n"
    "T_right: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n   data: [ 0., 0., 2. ]\n";

Result<ForeignRig> easymocap(std::string_view intri, std::string_view extri) {
  return parse_easymocap(intri, extri, "intri.yml", "extri.yml");
}

TEST(EasyMocap, PutsTheCentreOfATwoByTwoImageAtOneOne) {
  const Result<ForeignRig> rig = easymocap(kIntri, kExtri);
  ASSERT_TRUE(rig.has_value()) << rig.error().message;
  EXPECT_EQ(rig->rig.cameras[0].model.cx, 1.0);
  EXPECT_EQ(rig->rig.cameras[0].model.cy, 1.0);
  EXPECT_EQ(rig->rig.cameras[0].model.fy, 4.0);
}

TEST(EasyMocap, ReadsSizesOnlyWhereTheyAreStated) {
  const Result<ForeignRig> rig = easymocap(kIntri, kExtri);
  ASSERT_TRUE(rig.has_value());
  EXPECT_EQ(rig->rig.cameras[0].model.width, 0);
  EXPECT_EQ(rig->rig.cameras[1].model.width, 640);
  EXPECT_EQ(rig->rig.cameras[1].model.height, 480);
}

TEST(EasyMocap, ReadsDistortionInOpenCvsOrderAndNoneWhereThereIsNone) {
  const Result<ForeignRig> rig = easymocap(kIntri, kExtri);
  ASSERT_TRUE(rig.has_value());
  EXPECT_EQ(rig->rig.cameras[0].model.lens, Lens(BrownConrady{0.1, -0.2, 0.001, 0.002, 0.05}));
  EXPECT_EQ(rig->rig.cameras[1].model.lens, Lens(std::monostate{}));
}

TEST(EasyMocap, ReadsRotationVectorsAndPrefersTheMatrix) {
  const Result<ForeignRig> rig = easymocap(kIntri, kExtri);
  ASSERT_TRUE(rig.has_value());
  const Eigen::Vector3d a = rig->rig.cameras[0].cam_from_world * Eigen::Vector3d(1, 0, 0);
  EXPECT_TRUE(a.isApprox(Eigen::Vector3d(1, 3, 3))) << a;
  const Eigen::Vector3d b = rig->rig.cameras[1].cam_from_world * Eigen::Vector3d(1, 0, 0);
  EXPECT_TRUE(b.isApprox(Eigen::Vector3d(0, 1, 2))) << b;
}

TEST(EasyMocap, NamesTheEntryThatIsMissingOrWrong) {
  expect_error(easymocap(replaced(kIntri, "K_01", "X_01"), kExtri), ErrorCode::BadData,
               {"intri.yml", "K_01", "missing"});
  expect_error(easymocap(kIntri, replaced(kExtri, "T_right", "X_right")), ErrorCode::BadData,
               {"extri.yml", "T_right", "missing"});
  expect_error(easymocap(kIntri, replaced(kExtri, "R_01", "X_01")), ErrorCode::BadData,
               {"extri.yml", "R_01", "missing"});
  expect_error(easymocap(replaced(kIntri, "names", "nomes"), kExtri), ErrorCode::BadData,
               {"intri.yml", "names"});
  expect_error(easymocap(replaced(kIntri, "rows: 3", "rows: 4"), kExtri), ErrorCode::BadData,
               {"line 6", "K_01", "rows times its cols"});
  expect_error(easymocap(replaced(kIntri, "3., 0., 0.5", ".nan, 0., 0.5"), kExtri), ErrorCode::BadData,
               {"intri.yml: line 6", "K_01", "finite"});
  expect_error(easymocap(kIntri, replaced(kExtri, "1., 2., 3.", "1., .inf, 3.")), ErrorCode::BadData,
               {"extri.yml: line 11", "T_01", "finite"});
  expect_error(easymocap(kIntri, replaced(kExtri, "0., -1., 0., 1.", "0., 1., 0., 1.")), ErrorCode::BadData,
               {"Rot_right", "mirror"});
}

TEST(EasyMocap, KnowsTheEightTermsOfARationalLens) {
  const std::string eight =
      replaced(replaced(kIntri, "cols: 5", "cols: 8"), "0.05 ]", "0.05, 0.1, 0.2, 0.3 ]");
  const Result<ForeignRig> rig = easymocap(eight, kExtri);
  ASSERT_TRUE(rig.has_value()) << rig.error().message;
  const auto& lens = std::get<BrownConrady>(rig->rig.cameras[0].model.lens);
  EXPECT_EQ((std::array{lens.k3, lens.k4, lens.k5, lens.k6}), (std::array{0.05, 0.1, 0.2, 0.3}));
}

TEST(EasyMocap, RefusesALensWithMoreTermsThanOurs) {
  const std::string twelve =
      replaced(replaced(kIntri, "cols: 5", "cols: 12"), "0.05 ]", "0.05, 0., 0., 0., 0.1, 0., 0., 0. ]");
  expect_error(easymocap(twelve, kExtri), ErrorCode::Unsupported, {"intri.yml", "dist_01", "prism"});
  const std::string zeros =
      replaced(replaced(kIntri, "cols: 5", "cols: 12"), "0.05 ]", "0.05, 0., 0., 0., 0., 0., 0., 0. ]");
  EXPECT_TRUE(easymocap(zeros, kExtri).has_value());
}

TEST(EasyMocap, RefusesSizesThatTheDataDoesNotHave) {
  expect_error(easymocap(replaced(kIntri, "rows: 1\n   cols: 5", "rows: 1\n   cols: 2000000000"), kExtri),
               ErrorCode::BadData, {"dist_01"});
}

TEST(EasyMocap, RefusesWhatIsNotYaml) {
  expect_error(easymocap("hello", kExtri), ErrorCode::BadData, {"intri.yml", "%YAML"});
  expect_error(easymocap("", kExtri), ErrorCode::BadData, {"intri.yml"});
  expect_error(easymocap(std::string("%YAML:1.0\n\0x", 12), kExtri), ErrorCode::BadData, {"intri.yml"});
  expect_error(easymocap("%YAML:1.0\n---\nnames: [ a, b", kExtri), ErrorCode::BadData, {"intri.yml"});
}

TEST(EasyMocap, RefusesLinesThatBelongToNothing) {
  expect_error(easymocap(replaced(kIntri, "---\n", "---\n   stray: 1\n"), kExtri), ErrorCode::BadData,
               {"intri.yml: line 3"});
  expect_error(easymocap(replaced(kIntri, "H_right", "- right\nH_right"), kExtri), ErrorCode::BadData,
               {"intri.yml: line 22"});
  expect_error(easymocap(kIntri + "H_right: 480\n", kExtri), ErrorCode::BadData, {"H_right", "second time"});
}

TEST(EasyMocap, ReadsNamesInBracketsAndComments) {
  const Result<ForeignRig> rig = easymocap(
      replaced(kIntri, "names:\n   - \"01\"\n   - right\n", "# two\nnames: [ \"01\",\n   right ]\n"), kExtri);
  ASSERT_TRUE(rig.has_value()) << rig.error().message;
  EXPECT_THAT(rig->image_names, testing::ElementsAre("01", "right"));
}

TEST(EasyMocap, RefusesEveryTruncation) {
  const std::string intri = kIntri.substr(0, kIntri.find("H_right"));  // the sizes are optional
  expect_truncations_refused(intri, 2, [](std::string_view cut) { return easymocap(cut, kExtri); });
  expect_truncations_refused(kExtri, 2, [](std::string_view cut) { return easymocap(kIntri, cut); });
}

TEST(EasyMocap, ComesBackFromTheWriterUnchanged) {
  for (const Lens& lens : {Lens{}, Lens(BrownConrady{0.1, -0.2, 0.003, 0.004, 1e-7})})
    for (bool tiny : {false, true}) {
      TempFolder folder;
      const Rig rig = sample_rig(lens, tiny);
      ASSERT_TRUE(write_easymocap(rig, folder / "calibration").has_value());
      const Result<ForeignRig> again = read_easymocap(folder / "calibration");
      ASSERT_TRUE(again.has_value()) << again.error().message;
      expect_same(rig, again->rig);
      EXPECT_EQ(again->rig.cameras[2].model.width, rig.cameras[2].model.width);
    }
}

TEST(EasyMocap, WriterRefusesAFisheyeAndLeavesNoFile) {
  TempFolder folder;
  expect_error(write_easymocap(sample_rig(KannalaBrandt{0.1, 0, 0, 0}), folder / "c"), ErrorCode::Unsupported,
               {"cam0", "fisheye"});
  EXPECT_THAT(folder.names(), testing::IsEmpty());
}

}  // namespace
}  // namespace floatstage::calib
