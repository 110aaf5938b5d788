#include <cmath>
#include <set>

#include "tests/synthetic/studios.h"

namespace floatstage {
namespace {

class EveryShape : public testing::TestWithParam<std::tuple<RigShape, int>> {
 protected:
  SyntheticRigOptions options() const {
    return {.shape = std::get<0>(GetParam()), .cameras = std::get<1>(GetParam())};
  }
};

TEST_P(EveryShape, IsARigThatPassesItsChecks) {
  const Rig rig = synthetic_rig(options());
  EXPECT_EQ(rig.cameras.size(), static_cast<std::size_t>(options().cameras));
  const Result<void> ok = check(rig);
  EXPECT_TRUE(ok) << ok.error().message;
}

TEST_P(EveryShape, StandsApartAroundThePerformerAtTheDistanceAskedFor) {
  const Rig rig = synthetic_rig(options());
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) {
    const Eigen::Vector3d center = rig.cameras[i].cam_from_world.center();
    EXPECT_NEAR((center - Eigen::Vector3d(0, 0, center.z() > 2 ? 1 : center.z())).norm(), options().distance,
                0.35);
    EXPECT_GT(center.z(), 0);
    for (std::size_t j = 0; j < i; ++j)
      EXPECT_GT((center - rig.cameras[j].cam_from_world.center()).norm(), 0.1) << i << " and " << j;
  }
}

TEST_P(EveryShape, ShowsThePerformerWholeInEveryPictureAllTheTime) {
  const Rig rig = synthetic_rig(options());
  const SyntheticStudio studio = studio_with(rig, quick_options());
  for (int frame : {0, 7, 15, 24, 33}) {
    for (const Eigen::Vector3f& p : studio.performer(frame).positions) {
      for (const RigCamera& c : rig.cameras) {
        const auto pixel = project(c.model, c.cam_from_world * p.cast<double>());
        ASSERT_TRUE(pixel && inside(c.model, *pixel))
            << c.serial << " misses " << p.transpose() << " of frame " << frame;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Shapes, EveryShape,
                         testing::Combine(testing::Values(RigShape::Ring, RigShape::QuarterDome),
                                          testing::Values(1, 2, 5, 8, 12)));

TEST(SyntheticRig, SpreadsARingEvenlyStartingInFront) {
  const Rig rig = synthetic_rig({.cameras = 8});
  EXPECT_GT(rig.cameras[0].cam_from_world.center().y(), 2.9) << "camera 0 faces the performer, who faces +y";
  for (std::size_t i = 0; i < 8; ++i) {
    const Eigen::Vector3d a = rig.cameras[i].cam_from_world.center(),
                          b = rig.cameras[(i + 1) % 8].cam_from_world.center();
    EXPECT_NEAR((a - b).norm(), 2 * 3.0 * std::sin(M_PI / 8), 1e-9);
  }
}

}  // namespace
}  // namespace floatstage
