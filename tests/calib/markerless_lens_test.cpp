// Cameras placed by a scene without a target and without a known lens.

#include <cstdio>

#include <gtest/gtest.h>

#include "calib/markerless.h"
#include "calib/scene_features.h"
#include "core/png.h"
#include "tests/calib/pebble_scene.h"
#include "tests/calib/temple_scene.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

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
  FLOATSTAGE_LONG_FORM(seed != 2);  // of the five rings the one whose points fewest pictures show
  const TempFolder folder;
  const PebbleScene scene = pebble_scene(shape, static_cast<std::uint64_t>(seed), folder.path());
  const Result<MarkerlessResult> found = calibrate_markerless(scene.pictures, folder / "colmap");
  ASSERT_THAT(found, IsOk());
  const CenterErrors off = center_errors(found->rig, scene.truth);
  const double focal = focal_percent(found->rig, scene.truth);
  std::printf(
      "focal length %.3f %%, centres mean %.3f %%, worst %.3f %% of the radius, %zu points, each in %.2f "
      "pictures\n",
      focal, off.mean, off.worst, found->features.size(), found->mean_track);
  EXPECT_LE(std::abs(focal), 0.5);
  EXPECT_LE(off.mean, 0.3);
  EXPECT_LE(off.worst, 0.8);
  for (const RigCamera& c : found->rig.cameras) EXPECT_EQ(c.model, found->rig.cameras[0].model) << "one lens";
}

TEST(MarkerlessLensTemple, RingIsPlacedAndItsLensFoundFromThePicturesAlone) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-ring"));
  TempleScene set = temple_scene(real_data("middlebury-temple-ring"), "templeR_par.txt");
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
  const CenterErrors off = center_errors(found->rig, set.truth);
  const CameraModel& lens = found->rig.cameras[0].model;
  std::printf(
      "focal length %.1f px, %.3f %%; principal point %.1f %.1f; centres mean %.3f %%, worst %.3f %%\n",
      lens.fx, focal_percent(found->rig, set.truth), lens.cx, lens.cy, off.mean, off.worst);
  EXPECT_LE(std::abs(focal_percent(found->rig, set.truth)), 2);
  EXPECT_LE(off.mean, 0.5);
}

TEST(MarkerlessLensTemple, AWrongFocalLengthIsTheNamedSuspect) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-ring"));
  TempleScene set = temple_scene(real_data("middlebury-temple-ring"), "templeR_par.txt");
  for (MarkerlessPicture& p : set.pictures) p.model.fx *= 1.15, p.model.fy *= 1.15;
  const TempFolder work;
  const Result<MarkerlessResult> found = calibrate_markerless(set.pictures, work / "colmap");
  if (!found) std::printf("%s\n", found.error().message.c_str());
  EXPECT_THAT(found, FailsWith(ErrorCode::BadData, "the suspect is the focal length given for camera"));
}

}  // namespace
}  // namespace floatstage::calib
