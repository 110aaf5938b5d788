// Cameras placed by a scene without a target and without a known lens.

#include <cstdio>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "calib/formats/format_files.h"
#include "calib/markerless.h"
#include "calib/scene_features.h"
#include "core/png.h"
#include "tests/calib/pebble_scene.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

// How far camera centres are off after the best similarity, percent of the rig's radius.
struct Off {
  double mean = 0, worst = 0;
};

Off centers_off(const Rig& rig, const Rig& truth) {
  const Eigen::Index n = static_cast<Eigen::Index>(rig.cameras.size());
  Eigen::Matrix3Xd a(3, n), b(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    a.col(i) = rig.cameras[static_cast<std::size_t>(i)].cam_from_world.center();
    b.col(i) = truth.cameras[static_cast<std::size_t>(i)].cam_from_world.center();
  }
  const Eigen::Matrix4d similarity = Eigen::umeyama(a, b);
  const Eigen::Matrix3Xd moved =
      (similarity.topLeftCorner<3, 3>() * a).colwise() + Eigen::Vector3d(similarity.topRightCorner<3, 1>());
  const double radius = (b.colwise() - focus_point(truth)).colwise().norm().mean();
  const Eigen::VectorXd errors = (moved - b).colwise().norm();
  return {100 * errors.mean() / radius, 100 * errors.maxCoeff() / radius};
}

double focal_percent(const Rig& rig, const Rig& truth) {
  return 100 * (rig.cameras[0].model.fx / truth.cameras[0].model.fx - 1);
}

class MarkerlessLens : public testing::TestWithParam<std::tuple<PebbleRig, int>> {};
INSTANTIATE_TEST_SUITE_P(Seeds, MarkerlessLens,
                         testing::Combine(testing::Values(PebbleRig::Ring, PebbleRig::Dome),
                                          testing::Values(1, 2, 3, 4, 5)),
                         [](const auto& given) {
                           return std::string(std::get<0>(given.param) == PebbleRig::Ring ? "Ring" : "Dome") +
                                  std::to_string(std::get<1>(given.param));
                         });

TEST_P(MarkerlessLens, OfASharedUnknownLensFocalLengthAndPlacesAreFound) {
  const auto [shape, seed] = GetParam();
  FLOATSTAGE_LONG_FORM(seed > 1);
  const TempFolder folder;
  const PebbleScene scene = pebble_scene(shape, static_cast<std::uint64_t>(seed), folder.path());
  const Result<MarkerlessResult> found = calibrate_markerless(scene.pictures, folder / "colmap");
  ASSERT_THAT(found, IsOk());
  const Off off = centers_off(found->rig, scene.truth);
  const double focal = focal_percent(found->rig, scene.truth);
  std::printf("focal length %.3f %%, centres mean %.3f %%, worst %.3f %% of the radius, %zu points\n", focal,
              off.mean, off.worst, found->features.size());
  EXPECT_LE(std::abs(focal), 0.5);
  EXPECT_LE(off.mean, 0.3);
  EXPECT_LE(off.worst, 0.8);
  for (const RigCamera& c : found->rig.cameras) EXPECT_EQ(c.model, found->rig.cameras[0].model) << "one lens";
}

// The temple's ring, its lens as it is published or as it is said to be.
struct TempleRing {
  Rig truth;
  std::vector<MarkerlessPicture> pictures;
};

TempleRing temple_ring(const std::filesystem::path& folder) {
  TempleRing set;
  const Result<ForeignRig> foreign = read_middlebury(folder / "templeR_par.txt");
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

TEST(MarkerlessLensTemple, RingIsPlacedAndItsLensFoundFromThePicturesAlone) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-ring"));
  TempleRing set = temple_ring(real_data("middlebury-temple-ring"));
  ASSERT_EQ(set.pictures.size(), 19u);
  for (std::size_t i = 0; i < set.pictures.size(); ++i) {
    MarkerlessPicture& p = set.pictures[i];
    p.lens = Prior::Unknown;
    p.model = {
        .width = 640, .height = 480, .fx = 640, .fy = 640, .cx = 320, .cy = 240, .lens = BrownConrady{}};
    if (i > 0) p.same_lens_as = 0;
  }
  const TempFolder work;
  const Result<MarkerlessResult> found = calibrate_markerless(set.pictures, work / "colmap");
  ASSERT_THAT(found, IsOk());
  const Off off = centers_off(found->rig, set.truth);
  const CameraModel& lens = found->rig.cameras[0].model;
  std::printf(
      "focal length %.1f px, %.3f %%; principal point %.1f %.1f; centres mean %.3f %%, worst %.3f %%\n",
      lens.fx, focal_percent(found->rig, set.truth), lens.cx, lens.cy, off.mean, off.worst);
  EXPECT_LE(std::abs(focal_percent(found->rig, set.truth)), 2);
  EXPECT_LE(off.mean, 0.5);
}

TEST(MarkerlessLensTemple, AWrongFocalLengthIsTheNamedSuspect) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-ring"));
  TempleRing set = temple_ring(real_data("middlebury-temple-ring"));
  for (MarkerlessPicture& p : set.pictures) p.model.fx *= 1.15, p.model.fy *= 1.15;
  const TempFolder work;
  const Result<MarkerlessResult> found = calibrate_markerless(set.pictures, work / "colmap");
  if (!found) std::printf("%s\n", found.error().message.c_str());
  EXPECT_THAT(found, FailsWith(ErrorCode::BadData, "the suspect is the focal length given for camera"));
}

}  // namespace
}  // namespace floatstage::calib
