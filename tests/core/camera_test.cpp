#include "core/camera.h"

#include <gtest/gtest.h>

namespace floatstage {
namespace {

CameraModel model_with(Lens lens) {
  return {.width = 640, .height = 480, .fx = 500, .fy = 510, .cx = 321, .cy = 239, .skew = 0.7, .lens = lens};
}

class EveryLens : public testing::TestWithParam<Lens> {};

TEST_P(EveryLens, UnprojectsWhatItProjects) {
  const CameraModel model = model_with(GetParam());
  for (double y = 0.5; y < 480; y += 60) {
    for (double x = 0.5; x < 640; x += 60) {
      const auto ray = unproject(model, {x, y});
      ASSERT_TRUE(ray) << x << ", " << y;
      const auto pixel = project(model, *ray * 3.7);
      ASSERT_TRUE(pixel);
      EXPECT_NEAR((*pixel - Eigen::Vector2d(x, y)).norm(), 0, 1e-8) << x << ", " << y;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Lenses, EveryLens,
    testing::Values(Lens{}, Lens{BrownConrady{-0.1, 0.03, 1e-3, -2e-3, 0.001}},
                    Lens{BrownConrady{0.1, -0.03, 0, 0, 0}},
                    Lens{BrownConrady{.k1 = 0.4, .k2 = 0.1, .p1 = 1e-3, .k4 = 0.6, .k5 = 0.2, .k6 = 0.02}},
                    Lens{KannalaBrandt{0.02, -0.005, 0.001, 0}}));

TEST_P(EveryLens, ProjectsManyPointsAsItProjectsEach) {
  const CameraModel model = model_with(GetParam());
  const Rigid3 cam_from_world = look_at({0.3, -0.2, -3}, {0, 0, 0}, {0, -1, 0});
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 60; ++i)
    points.emplace_back(0.01F * static_cast<float>(i * 7 % 61 - 30),
                        0.01F * static_cast<float>(i * 11 % 53 - 26), 0.02F * static_cast<float>(i * 5 % 31));
  const auto pixels = project_all(model, cam_from_world, points);
  ASSERT_TRUE(pixels);
  ASSERT_EQ(pixels->size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    EXPECT_LT(((*pixels)[i] - *project(model, cam_from_world * points[i].cast<double>())).norm(), 1e-9) << i;
  points.push_back({0.3F, -0.2F, -4});  // behind it
  EXPECT_FALSE(project_all(model, cam_from_world, points));
}

TEST(Project, SeesNothingBehindTheCamera) {
  EXPECT_FALSE(project(model_with({}), {0, 0, -1}));
  EXPECT_FALSE(project(model_with({}), {0, 0, 0}));
}

TEST(Project, DoesNotFoldBackPointsBeyondTheLensModelsReach) {
  EXPECT_FALSE(project(model_with(BrownConrady{-0.3, 0, 0, 0, 0}), {3, 0, 1}));
}

TEST(Project, DoesNotLookThroughThePoleOfARationalLens) {
  const CameraModel model = model_with(BrownConrady{.k4 = -0.25});  // the denominator is zero at r = 2
  EXPECT_TRUE(project(model, {0.5, 0, 1}));
  EXPECT_FALSE(project(model, {2.5, 0, 1}));
}

TEST(Distort, OfARationalLensIsOpenCvsFormula) {
  const BrownConrady lens{0.4, 0.1, 1e-3, -2e-3, 0.05, 0.6, 0.2, 0.02};
  const double x = 0.5, y = -0.3, r2 = x * x + y * y;
  const double radial = (1 + 0.4 * r2 + 0.1 * r2 * r2 + 0.05 * r2 * r2 * r2) /
                        (1 + 0.6 * r2 + 0.2 * r2 * r2 + 0.02 * r2 * r2 * r2);
  const auto d = distort(Lens(lens), {x, y});
  ASSERT_TRUE(d);
  EXPECT_NEAR(d->x(), x * radial + 2e-3 * x * y - 2e-3 * (r2 + 2 * x * x), 1e-15);
  EXPECT_NEAR(d->y(), y * radial + 1e-3 * (r2 + 2 * y * y) - 4e-3 * x * y, 1e-15);
}

TEST(LookAt, PutsTheTargetInFrontAndUpUpwards) {
  const Rigid3 cam_from_world = look_at({3, 0, 1}, {0, 0, 1}, {0, 0, 1});
  EXPECT_LT((cam_from_world * Eigen::Vector3d(0, 0, 1) - Eigen::Vector3d(0, 0, 3)).norm(), 1e-12);
  EXPECT_LT((cam_from_world * Eigen::Vector3d(0, 0, 2)).y(), 0) << "up is -y in the picture";
  EXPECT_GT((cam_from_world * Eigen::Vector3d(0, 1, 1)).x(), 0) << "a mirrored world";
  EXPECT_LT((cam_from_world.center() - Eigen::Vector3d(3, 0, 1)).norm(), 1e-12);
}

}  // namespace
}  // namespace floatstage
