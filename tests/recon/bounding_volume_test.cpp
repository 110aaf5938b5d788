#include "recon/bounding_volume.h"

#include <gtest/gtest.h>

#include "tests/support/analytic_shapes.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

TEST(BoundingVolume, IsTightAroundABoxSeenAlongTheAxes) {
  // From far away pyramids are almost parallel.
  Rig rig;
  for (const Vector3d& eye : {Vector3d(100, 0, 0), Vector3d(0, -100, 0)}) {
    RigCamera c = shapes::ring_rig({.cameras = 1, .focal = 5000}).cameras[0];
    c.serial = std::to_string(rig.cameras.size());
    c.cam_from_world = look_at(eye, {0, 0, 0}, {0, 0, 1});
    rig.cameras.push_back(c);
  }
  const auto mattes = shapes::render_mattes(rig, shapes::box({0.1, -0.2, 0.3}, {1, 0.8, 0.6}));
  const auto box = bounding_volume(rig, mattes);
  ASSERT_TRUE(box);
  const double pixel = 100.0 / 5000;
  EXPECT_LT((box->min() - Vector3d(-0.4, -0.6, 0)).cwiseAbs().maxCoeff(), 2 * pixel);
  EXPECT_LT((box->max() - Vector3d(0.6, 0.2, 0.6)).cwiseAbs().maxCoeff(), 2 * pixel);
}

TEST(BoundingVolume, ContainsTheSubjectThroughStrongLenses) {
  for (const Lens& lens : {Lens{BrownConrady{-0.3, 0.1, 1e-3, 0, 0}}, Lens{BrownConrady{0.3, 0.1, 0, 0, 0}},
                           Lens{KannalaBrandt{0.05, 0.01, 0, 0}}}) {
    const Rig rig = shapes::ring_rig({.cameras = 5, .distance = 1.6, .focal = 100, .lens = lens});
    const auto box = bounding_volume(rig, shapes::render_mattes(rig, shapes::sphere({0.1, 0.2, 0}, 0.5)));
    ASSERT_TRUE(box);
    EXPECT_TRUE(box->contains(Eigen::AlignedBox3d(Vector3d(-0.4, -0.3, -0.5), Vector3d(0.6, 0.7, 0.5))));
  }
}

TEST(BoundingVolume, DoesNotCutASubjectThatOneImageCuts) {
  Rig rig = shapes::ring_rig({.cameras = 6});
  rig.cameras[0].model.cy = 20;  // the upper part of the sphere is above its image
  const auto mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.6));
  ASSERT_EQ(subject_rectangle(mattes[0]).min().y(), 0);
  const auto box = bounding_volume(rig, mattes);
  ASSERT_TRUE(box);
  EXPECT_TRUE(box->contains(Eigen::AlignedBox3d(Vector3d(-0.6, -0.6, -0.6), Vector3d(0.6, 0.6, 0.6))));
}

TEST(BoundingVolume, GivesUpWhatIsOutsideTheImagesWhenNothingElseBounds) {
  Rig rig = shapes::ring_rig({.cameras = 3});
  for (RigCamera& c : rig.cameras) c.model.cy = 100;  // the lower part is outside every image
  const auto mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.6));
  for (const Matte& m : mattes) ASSERT_EQ(subject_rectangle(m).max().y(), m.height - 1);
  const auto box = bounding_volume(rig, mattes);
  ASSERT_TRUE(box);
  EXPECT_TRUE(box->contains(Eigen::AlignedBox3d(Vector3d(-0.6, -0.6, 0), Vector3d(0.6, 0.6, 0.6))));
  EXPECT_LT(box->sizes().maxCoeff(), 10);
}

TEST(BoundingVolume, IsAbsentWhenTheSubjectFillsEveryImage) {
  const Rig rig = shapes::ring_rig({.cameras = 4});
  std::vector<Matte> mattes;
  for (const RigCamera& c : rig.cameras) mattes.push_back(shapes::uniform_matte(c, 255));
  EXPECT_FALSE(bounding_volume(rig, mattes));
}

TEST(BoundingVolume, IsAbsentForASingleCamera) {
  const Rig rig = shapes::ring_rig({.cameras = 1});
  EXPECT_FALSE(bounding_volume(rig, shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.5))));
}

TEST(BoundingVolume, IsEmptyWhenTwoCamerasSeeDifferentThings) {
  const Rig rig = shapes::ring_rig({.cameras = 2}, 0);  // face to face
  const std::vector<Matte> mattes = {shapes::render_matte(rig.cameras[0], shapes::sphere({0, 0, 0.7}, 0.2)),
                                     shapes::render_matte(rig.cameras[1], shapes::sphere({0, 0, -0.7}, 0.2))};
  const auto box = bounding_volume(rig, mattes);
  ASSERT_TRUE(box);
  EXPECT_TRUE(box->isEmpty());
}

TEST(SubjectRectangle, HoldsExactlyTheSubjectPixels) {
  Image alpha(10, 8, 1);
  *alpha.at(3, 2) = 128;
  *alpha.at(6, 5) = 255;
  *alpha.at(9, 7) = 127;  // not subject
  const Eigen::AlignedBox2i r = subject_rectangle(make_matte({}, alpha));
  EXPECT_EQ(r.min(), Eigen::Vector2i(3, 2));
  EXPECT_EQ(r.max(), Eigen::Vector2i(6, 5));
  EXPECT_TRUE(subject_rectangle({}).isEmpty());
}

}  // namespace
}  // namespace floatstage::recon
