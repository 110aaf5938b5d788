// What is known of a sphere's hull beforehand: through pixels, contours and lens-free cameras.

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "recon/mesh/mesh_check.h"
#include "recon/visual_hull.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/matchers.h"

namespace floatstage::recon {
namespace {

constexpr double kRadius = 0.6;
constexpr double kVolume = 4.0 / 3 * std::numbers::pi * kRadius * kRadius * kRadius;

class SphereFromThirtyTwoViews : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    rig_ = shapes::sphere_rig({.cameras = 32, .distance = 4, .width = 320, .height = 320, .focal = 800});
    mattes_ = shapes::render_mattes(rig_, shapes::sphere({0, 0, 0}, kRadius));
  }

  static HullReport hull_of(const Rig& rig, const std::vector<Matte>& mattes, double tolerance) {
    HullOptions options;
    options.contour_tolerance = tolerance;
    Result<HullReport> hull = visual_hull(rig, mattes, options);
    EXPECT_THAT(hull, IsOk());
    return hull ? std::move(*hull) : HullReport{};
  }

  static inline Rig rig_;
  static inline std::vector<Matte> mattes_;
};

TEST_F(SphereFromThirtyTwoViews, HasItsVolumeWithinThreePerMille) {
  for (const double tolerance : {0.0, 0.1, 0.5}) {
    const HullReport hull = hull_of(rig_, mattes_, tolerance);
    EXPECT_NEAR(hull.volume / kVolume, 1, 0.003) << tolerance << " px";
    const MeshCheck check = check_mesh(hull.mesh);
    EXPECT_TRUE(check.watertight && check.manifold && check.oriented && check.outward) << check.summary();
    EXPECT_EQ(check.shells, 1);
    EXPECT_EQ(check.genus, 0);
  }
}

TEST_F(SphereFromThirtyTwoViews, FillsEverySilhouette) {
  for (const double tolerance : {0.1, 0.5}) {
    for (const double iou : hull_of(rig_, mattes_, tolerance).silhouette_iou)
      EXPECT_GE(iou, 0.999) << tolerance << " px";
  }
}

TEST_F(SphereFromThirtyTwoViews, LosesVolumeWithEveryCameraThatIsAdded) {
  double last = 1e9;
  // Nested sets: each holds the one before it, in an order that keeps the cameras spread out.
  Rig rig;
  std::vector<Matte> mattes;
  for (std::size_t k = 0; k < 32; ++k) {
    const std::size_t camera = 13 * k % 32;
    rig.cameras.push_back(rig_.cameras[camera]);
    mattes.push_back(mattes_[camera]);
    if (k < 2) continue;
    const HullReport hull = hull_of(rig, mattes, 0.5);
    EXPECT_LT(hull.volume / kVolume, last) << k + 1 << " cameras";
    last = hull.volume / kVolume;
  }
  EXPECT_NEAR(last, 1, 0.003);
}

}  // namespace
}  // namespace floatstage::recon
