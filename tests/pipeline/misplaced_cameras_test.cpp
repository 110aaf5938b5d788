#include "pipeline/silhouettes/misplaced_cameras.h"

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/camera.h"
#include "core/parallel.h"
#include "core/synthetic/synthetic_studio.h"
#include "pipeline/silhouettes/silhouette_check.h"
#include "tests/support/matchers.h"

namespace floatstage::pipeline {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr std::size_t kCameras = 8;

/// Two instants of a performer as eight cameras see it.
struct Seen {
  Rig rig;
  std::vector<InstantMattes> instants = std::vector<InstantMattes>(2, InstantMattes(kCameras));
  explicit Seen(Rig of = synthetic_rig({.cameras = kCameras, .width = 240, .height = 180}))
      : rig(std::move(of)) {
    const Result<SyntheticStudio> studio =
        SyntheticStudio::create(rig, {.seed = 4, .frame_rate = 25, .samples = 4});
    parallel_for(2 * kCameras, 0, [&](std::size_t i) {
      instants[i / kCameras][i % kCameras] =
          studio->shoot(static_cast<int>(i % kCameras), 9 * static_cast<int>(i / kCameras)).matte;
    });
  }
  std::vector<MisplacedCamera> misplaced() const { return misplaced_cameras(rig, instants, 2); }
  void flip(std::size_t camera, bool in_x, bool in_y) {
    for (InstantMattes& mattes : instants) {
      const Image as_taken = to_image(mattes[camera]);
      Image out = as_taken;
      for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x)
          *out.at(x, y) = *as_taken.at(in_x ? out.width - 1 - x : x, in_y ? out.height - 1 - y : y);
      mattes[camera] = make_matte(mattes[camera].source, out);
    }
  }
};

const Seen& seen() {
  static const Seen made;
  return made;
}

TEST(MisplacedCameras, NobodyIsWhereAllStandWhereTheRigSays) { EXPECT_THAT(seen().misplaced(), IsEmpty()); }

TEST(MisplacedCameras, TwoThatAreTakenForOneAnotherAreNamedAndPutInPlace) {
  for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>(3, 4), {0, 4}, {1, 6}}) {
    SCOPED_TRACE(a);
    Seen swapped = seen();
    for (InstantMattes& mattes : swapped.instants) std::swap(mattes[a], mattes[b]);
    const std::vector<MisplacedCamera> found = swapped.misplaced();
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].camera, a);
    EXPECT_EQ(found[0].place, b);
    EXPECT_EQ(found[1].camera, b);
    EXPECT_EQ(found[1].place, a);
    EXPECT_GT(found[0].iou_there, found[0].iou);
    EXPECT_THAT(sentence(swapped.rig, found[0]),
                HasSubstr("' shows what camera '" + swapped.rig.cameras[b].serial + "' should see"));
    const std::optional<Rig> rig = with_cameras_in_place(swapped.rig, found);
    ASSERT_TRUE(rig);
    EXPECT_EQ(rig->cameras[a].serial, swapped.rig.cameras[a].serial) << "its pictures are still its own";
    EXPECT_TRUE(rig->cameras[a].cam_from_world.translation ==
                swapped.rig.cameras[b].cam_from_world.translation);
    EXPECT_THAT(misplaced_cameras(*rig, swapped.instants, 2), IsEmpty());
  }
}

TEST(MisplacedCameras, PicturesThatAreUpsideDownHaveARig) {
  Rig upright = seen().rig;
  upright.cameras[2].model.cx += 11.5;
  upright.cameras[2].model.lens = BrownConrady{.k1 = -0.1, .p1 = 0.004, .p2 = -0.003};
  Seen turned(upright);
  turned.flip(2, true, true);
  const std::vector<MisplacedCamera> found = turned.misplaced();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].camera, 2u);
  EXPECT_EQ(found[0].place, 2u);
  EXPECT_EQ(found[0].flip, PictureFlip::UpsideDown);
  EXPECT_THAT(sentence(turned.rig, found[0]), HasSubstr("upside down"));
  const std::optional<Rig> rig = with_cameras_in_place(turned.rig, found);
  ASSERT_TRUE(rig);
  const RigCamera &was = upright.cameras[2], &now = rig->cameras[2];
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(0.3, -0.2, 1.4), {-0.4, 0.3, 0.2}, {0, 0, 1}}) {
    const auto before = project(was.model, was.cam_from_world * point),
               after = project(now.model, now.cam_from_world * point);
    ASSERT_TRUE(before && after);
    EXPECT_NEAR(after->x(), was.model.width - before->x(), 1e-9);
    EXPECT_NEAR(after->y(), was.model.height - before->y(), 1e-9);
  }
}

TEST(MisplacedCameras, MirroredPicturesHaveNone) {
  for (const bool in_x : {true, false}) {
    Seen mirrored = seen();
    mirrored.flip(5, in_x, !in_x);
    const std::vector<MisplacedCamera> found = mirrored.misplaced();
    ASSERT_EQ(found.size(), 1u) << in_x;
    EXPECT_EQ(found[0].camera, 5u);
    EXPECT_EQ(found[0].flip, in_x ? PictureFlip::Mirrored : PictureFlip::MirroredUpsideDown);
    EXPECT_FALSE(with_cameras_in_place(mirrored.rig, found));
    // Poses are asked of the others.
    const Result<SilhouetteCheck> check = check_silhouettes(mirrored.rig, mirrored.instants, {});
    ASSERT_THAT(check, IsOk());
    EXPECT_EQ(check->misplaced.size(), 1u);
    EXPECT_TRUE(
        std::none_of(check->cameras.begin(), check->cameras.end(), [](const auto& c) { return c.named; }));
  }
}

TEST(MisplacedCameras, TheCheckOfPosesBeginsWithThem) {
  Seen swapped = seen();
  for (InstantMattes& mattes : swapped.instants) std::swap(mattes[1], mattes[2]);
  const Result<SilhouetteCheck> check = check_silhouettes(swapped.rig, swapped.instants, {});
  ASSERT_THAT(check, IsOk());
  ASSERT_EQ(sentences(*check).size(), 2u);
  EXPECT_THAT(sentences(*check)[0], HasSubstr("should see"));
  EXPECT_THAT(misplaced_cameras(check->corrected, swapped.instants, 2), IsEmpty());
}

TEST(MisplacedCameras, ATurnedCameraALateOneAndAnEmptyMatteAreNone) {
  Seen others = seen();
  others.instants[0][3] = others.instants[1][3];  // nine frames late
  others.instants[0][6] = Matte{};
  Rigid3& pose = others.rig.cameras[1].cam_from_world;
  pose =
      Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(0.02, Eigen::Vector3d::UnitY())), Eigen::Vector3d::Zero()} *
      pose;
  EXPECT_THAT(others.misplaced(), IsEmpty());
}

TEST(MisplacedCameras, FourCamerasTellNothing) {
  Seen four = seen();
  four.rig.cameras.resize(4);
  for (InstantMattes& mattes : four.instants) mattes.resize(4), std::swap(mattes[0], mattes[1]);
  EXPECT_THAT(four.misplaced(), IsEmpty());
  EXPECT_THAT(misplaced_cameras(seen().rig, {}, 2), IsEmpty());
}

TEST(MisplacedCameras, TheSameAtAnyNumberOfThreads) {
  Seen swapped = seen();
  for (InstantMattes& mattes : swapped.instants) std::swap(mattes[1], mattes[5]);
  const auto one = misplaced_cameras(swapped.rig, swapped.instants, 1),
             four = misplaced_cameras(swapped.rig, swapped.instants, 4);
  ASSERT_EQ(one.size(), four.size());
  for (std::size_t i = 0; i < one.size(); ++i) EXPECT_EQ(one[i].iou_there, four[i].iou_there);
}

}  // namespace
}  // namespace floatstage::pipeline
