#include <algorithm>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "calib/formats/format_files.h"
#include "calib/markerless.h"
#include "core/png.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

struct Temple {
  Rig truth;
  std::vector<MarkerlessPicture> pictures;
};

Temple temple(const std::filesystem::path& folder, const char* par) {
  Temple set;
  Result<ForeignRig> foreign = read_middlebury(folder / par);
  EXPECT_THAT(foreign, IsOk());
  for (std::size_t i = 0; i < foreign->rig.cameras.size(); ++i) {
    RigCamera camera = foreign->rig.cameras[i];
    const std::filesystem::path file = folder / foreign->image_names[i];
    if (!std::filesystem::exists(file)) continue;
    camera.model.width = 640, camera.model.height = 480;
    camera.serial = file.stem().string();
    Result<Image> pixels = load_png(file);
    EXPECT_THAT(pixels, IsOk());
    set.pictures.push_back({camera.serial, file, camera.model, *std::move(pixels)});
    set.truth.cameras.push_back(std::move(camera));
  }
  return set;
}

// The largest distance of a camera's centre from the truth after the best similarity, as a share of the rig's
// radius.
double worst_center(const Rig& rig, const Rig& truth) {
  const Eigen::Index n = static_cast<Eigen::Index>(rig.cameras.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.col(i) = rig.cameras[static_cast<std::size_t>(i)].cam_from_world.center();
    b.col(i) = truth.cameras[static_cast<std::size_t>(i)].cam_from_world.center();
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(a, b);
  const Eigen::Matrix3Xd off =
      (similarity.topLeftCorner<3, 3>() * a).colwise() + Eigen::Vector3d(similarity.topRightCorner<3, 1>());
  const double radius = (b.colwise() - focus_point(truth)).colwise().norm().mean();
  const Eigen::VectorXd errors = (off - b).colwise().norm();
  std::printf("camera centres: rms %.3f %%, worst %.3f %% of the radius of %.3f m\n",
              100 * std::sqrt(errors.squaredNorm() / static_cast<double>(n)) / radius,
              100 * errors.maxCoeff() / radius, radius);
  return errors.maxCoeff() / radius;
}

TEST(MarkerlessTemple, RingIsPlacedToThreeThousandthsOfItsRadius) {
  const auto folder = real_data("middlebury-temple-ring");
  FLOATSTAGE_NEEDS_DATA(folder);
  const Temple set = temple(folder, "templeR_par.txt");
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
  Temple set = temple(folder, "templeR_par.txt");
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
  const Temple set = temple(folder, "templeSR_par.txt");
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
