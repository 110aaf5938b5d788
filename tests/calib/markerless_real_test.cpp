#include <cstdio>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "calib/markerless.h"
#include "tests/calib/temple_scene.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

// The largest distance of a camera's centre from the truth, as a share of the rig's radius.
double worst_center(const Rig& rig, const Rig& truth) {
  const CenterErrors off = center_errors(rig, truth);
  std::printf("camera centres: rms %.3f %%, worst %.3f %% of the radius\n", off.rms, off.worst);
  return off.worst / 100;
}

TEST(MarkerlessTemple, RingIsPlacedToThreeThousandthsOfItsRadius) {
  const auto folder = real_data("middlebury-temple-ring");
  FLOATSTAGE_NEEDS_DATA(folder);
  const TempleScene set = temple_scene(folder, "templeR_par.txt");
  ASSERT_EQ(set.pictures.size(), 19u);
  const TempFolder work;
  const Result<MarkerlessResult> result = calibrate_markerless(set.pictures, work / "colmap");
  ASSERT_THAT(result, IsOk());
  std::printf("%zu points, %.2f pictures a point, %.3f px\n", result->features.size(), result->mean_track,
              result->rms_px);
  ASSERT_EQ(result->rig.cameras.size(), 19u);
  EXPECT_LE(worst_center(result->rig, set.truth), 0.003);
  // COLMAP draws anew, which must not show.
  const Result<MarkerlessResult> again = calibrate_markerless(set.pictures, work / "again");
  ASSERT_THAT(again, IsOk());
  EXPECT_LE(worst_center(again->rig, result->rig), 0.0005);
}

TEST(MarkerlessTemple, KnownPosesStayAndAMovedCameraIsNamed) {
  const auto folder = real_data("middlebury-temple-ring");
  FLOATSTAGE_NEEDS_DATA(folder);
  TempleScene set = temple_scene(folder, "templeR_par.txt");
  set.pictures.resize(9);
  const Result<MarkerlessResult> result = triangulate_markerless(set.pictures, set.truth);
  ASSERT_THAT(result, IsOk());
  EXPECT_EQ(result->rig.cameras[7].cam_from_world.translation,
            set.truth.cameras[7].cam_from_world.translation);
  EXPECT_GE(result->features.size(), 1000u);
  for (const SceneFeature& f : result->features) EXPECT_GE(f.seen.size(), 3u);
  Rig moved = set.truth;
  moved.cameras[7].cam_from_world =
      Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitY())), {0, 0, 0}} *
      moved.cameras[7].cam_from_world;
  EXPECT_THAT(triangulate_markerless(set.pictures, moved),
              FailsWith(ErrorCode::BadData, "camera '" + moved.cameras[7].serial + "' shows only"));
}

TEST(MarkerlessTemple, SparseRingIsRefusedWithAReasonOrAsGood) {
  const auto folder = real_data("middlebury-temple-sparse-ring");
  FLOATSTAGE_NEEDS_DATA(folder);
  const TempleScene set = temple_scene(folder, "templeSR_par.txt");
  ASSERT_EQ(set.pictures.size(), 16u);
  const TempFolder work;
  const Result<MarkerlessResult> result = calibrate_markerless(set.pictures, work / "colmap");
  if (result) {
    EXPECT_LE(worst_center(result->rig, set.truth), 0.003);
    return;
  }
  std::printf("refused: %s\n", result.error().message.c_str());
  EXPECT_THAT(result, FailsWith(ErrorCode::BadData, "too little is seen by neighbouring cameras together"));
}

}  // namespace
}  // namespace floatstage::calib
