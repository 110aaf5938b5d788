#include "calib/formats/parsers.h"
#include "tests/calib/format_support.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

// As OpenMVG's documentation shows its archive; the second view has no pose.
const std::string kScene = R"({
 "sfm_data_version": "0.3", "root_path": "/pictures",
 "views": [
  {"key": 0, "value": {"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 2147483649, "data":
    {"local_path": "/", "filename": "100_7100.JPG", "width": 640, "height": 480, "id_view": 0, "id_intrinsic": 0, "id_pose": 0}}}},
  {"key": 1, "value": {"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 2147483650, "data":
    {"local_path": "/", "filename": "100_7101.JPG", "width": 640, "height": 480, "id_view": 1, "id_intrinsic": 0, "id_pose": 1}}}},
  {"key": 2, "value": {"polymorphic_id": 1073741824, "ptr_wrapper": {"id": 2147483651, "data":
    {"local_path": "/", "filename": "100_7102.JPG", "width": 640, "height": 480, "id_view": 2, "id_intrinsic": 0, "id_pose": 2}}}}],
 "intrinsics": [
  {"key": 0, "value": {"polymorphic_id": 2147483649, "polymorphic_name": "pinhole_radial_k3", "ptr_wrapper": {"id": 2147483652, "data":
    {"width": 640, "height": 480, "focal_length": 700, "principal_point": [320, 240], "disto_k3": [-0.1, 0.02, 0.003]}}}}],
 "extrinsics": [
  {"key": 0, "value": {"rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "center": [0.5, -0.25, -2]}},
  {"key": 2, "value": {"rotation": [[0, 0, -1], [0, 1, 0], [1, 0, 0]], "center": [2, 0, 0]}}],
 "structure": [], "control_points": []})";

Result<ForeignRig> openmvg(std::string_view content) { return parse_openmvg(content, "sfm_data.json"); }

TEST(OpenMvg, ProjectsAsItsFormulaDoes) {
  const Result<ForeignRig> rig = openmvg(kScene);
  ASSERT_THAT(rig, IsOk());
  ASSERT_EQ(rig->rig.cameras.size(), 2u) << "a view without a pose is no camera";
  EXPECT_EQ(rig->image_names[1], "100_7102.JPG");
  EXPECT_EQ(rig->rig.cameras[1].serial, "100_7102");
  const RigCamera& c = rig->rig.cameras[0];
  const double x = (0.7 - 0.5) / 2, y = (0.15 + 0.25) / 2, r2 = x * x + y * y;
  const double radial = 1 + r2 * (-0.1 + r2 * (0.02 + r2 * 0.003));
  const Eigen::Vector2d expected(700 * x * radial + 320 + 0.5, 700 * y * radial + 240 + 0.5);
  EXPECT_LT((*project(c.model, c.cam_from_world * Eigen::Vector3d(0.7, 0.15, 0)) - expected).norm(), 1e-9);
  EXPECT_TRUE(rig->rig.cameras[1].cam_from_world.center().isApprox(Eigen::Vector3d(2, 0, 0)));
}

TEST(OpenMvg, KnowsItsCameraTypes) {
  const auto lens = [](const std::string& type, const std::string& coefficients) {
    const Result<ForeignRig> rig = openmvg(replaced(replaced(kScene, "pinhole_radial_k3", type),
                                                    R"("disto_k3": [-0.1, 0.02, 0.003])", coefficients));
    EXPECT_THAT(rig, IsOk());
    return rig ? rig->rig.cameras[0].model.lens : Lens{};
  };
  EXPECT_EQ(lens("pinhole", R"("unused": 0)"), Lens{});
  EXPECT_EQ(lens("pinhole_radial_k1", R"("disto_k1": [1])"), Lens(BrownConrady{.k1 = 1}));
  EXPECT_EQ(lens("pinhole_brown_t2", R"("disto_t2": [1, 2, 3, 4, 5])"), Lens(BrownConrady{1, 2, 4, 5, 3}));
  EXPECT_EQ(lens("fisheye", R"("fisheye": [1, 2, 3, 4])"), Lens(KannalaBrandt{1, 2, 3, 4}));
}

TEST(OpenMvg, SaysWhatIsWrong) {
  expect_error(openmvg(replaced(kScene, "pinhole_radial_k3", "spherical")), ErrorCode::Unsupported,
               {"intrinsic 0", "spherical"});
  expect_error(
      openmvg(replaced(kScene, "\"id_intrinsic\": 0, \"id_pose\": 0", "\"id_intrinsic\": 9, \"id_pose\": 0")),
      ErrorCode::BadData, {"view 0", "intrinsic 9"});
  expect_error(openmvg(replaced(kScene, "[[1, 0, 0]", "[[2, 0, 0]")), ErrorCode::BadData, {"extrinsic 0"});
  expect_error(openmvg(replaced(kScene, "\"focal_length\": 700", "\"focal_length\": 0")), ErrorCode::BadData,
               {"sfm_data"});
  expect_error(openmvg(replaced(kScene, "\"key\": 2, \"value\": {\"rotation\"",
                                "\"key\": 0, \"value\": {\"rotation\"")),
               ErrorCode::BadData, {"extrinsic 1", "twice"});
  expect_error(openmvg(replaced(kScene, "\"0.3\"", "\"9.0\"")), ErrorCode::Unsupported,
               {"sfm_data.json", "9.0", "0.3"});
  expect_error(openmvg("{}"), ErrorCode::BadData, {"sfm_data.json"});
}

TEST(OpenMvg, RefusesEveryTruncation) { expect_truncations_refused(kScene, 2, openmvg); }

}  // namespace
}  // namespace floatstage::calib
