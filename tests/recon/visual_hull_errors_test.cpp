#include <limits>

#include <gtest/gtest.h>

#include "core/text.h"
#include "recon/visual_hull.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/matchers.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

class VisualHullErrors : public testing::TestWithParam<HullMethod> {
 protected:
  Rig rig = shapes::ring_rig({.cameras = 4});
  std::vector<Matte> mattes = shapes::render_mattes(rig, shapes::sphere({0, 0, 0}, 0.5));
  HullOptions options = [] {
    HullOptions o;
    o.method = GetParam();
    o.resolution = 32;
    o.threads = 1;
    return o;
  }();
};

INSTANTIATE_TEST_SUITE_P(Methods, VisualHullErrors, testing::Values(HullMethod::Exact, HullMethod::Octree),
                         [](const auto& method) {
                           return method.param == HullMethod::Exact ? "Exact" : "Octree";
                         });

TEST_P(VisualHullErrors, RefusesAnotherNumberOfMattes) {
  mattes.pop_back();
  EXPECT_THAT(visual_hull(rig, mattes, options),
              FailsWith(ErrorCode::InvalidArgument, "3 mattes for 4 cameras"));
}

TEST_P(VisualHullErrors, RefusesAMatteOfAnotherSizeAndNamesItsCamera) {
  mattes[2] = make_matte({}, Image(159, 120, 1));
  EXPECT_THAT(visual_hull(rig, mattes, options),
              FailsWith(ErrorCode::InvalidArgument, "camera 'c2': its matte is 159x120"));
}

TEST_P(VisualHullErrors, RefusesARigThatIsNotFinite) {
  rig.cameras[1].cam_from_world.translation.y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(visual_hull(rig, mattes, options), FailsWith(ErrorCode::BadData, "camera 'c1'"));
  rig = shapes::ring_rig({.cameras = 4});
  rig.cameras[3].model.fx = std::numeric_limits<double>::infinity();
  EXPECT_THAT(visual_hull(rig, mattes, options), FailsWith(ErrorCode::BadData, "camera 'c3'"));
}

TEST_P(VisualHullErrors, RefusesARigWithoutCameras) {
  EXPECT_THAT(visual_hull({}, std::span<const Matte>{}, options), FailsWith(ErrorCode::BadData, "no camera"));
}

TEST_P(VisualHullErrors, SaysSoWhenNoCameraShowsASubject) {
  for (std::size_t i = 0; i < mattes.size(); ++i) mattes[i] = shapes::uniform_matte(rig.cameras[i], 0);
  EXPECT_THAT(visual_hull(rig, mattes, options), FailsWith(ErrorCode::BadData, "empty silhouette"));
  for (Matte& matte : mattes) matte = {};
  EXPECT_THAT(visual_hull(rig, mattes, options), FailsWith(ErrorCode::BadData, "empty silhouette"));
}

TEST_P(VisualHullErrors, SaysSoWhenTheSilhouettesBoundNothing) {
  for (std::size_t i = 0; i < mattes.size(); ++i) mattes[i] = shapes::uniform_matte(rig.cameras[i], 255);
  EXPECT_THAT(visual_hull(rig, mattes, options), FailsWith(ErrorCode::BadData, "give the volume to search"));
}

TEST_P(VisualHullErrors, RefusesMoreVotesThanThereAreCameras) {
  options.voting = HullVoting::MofN;
  options.votes = static_cast<int>(rig.cameras.size()) + 1;
  EXPECT_THAT(visual_hull(rig, mattes, options), FailsWith(ErrorCode::InvalidArgument, "cannot agree"));
}

TEST_P(VisualHullErrors, SaysThatOneCameraAloneBoundsNothing) {
  for (std::size_t i = 1; i < mattes.size(); ++i) mattes[i] = {};
  EXPECT_THAT(
      visual_hull(rig, mattes, options),
      FailsWith(ErrorCode::BadData, text("only camera '", rig.cameras[0].serial, "' shows a silhouette")));
  options.volume = Eigen::AlignedBox3d(Vector3d(-1, -1, -1), Vector3d(1, 1, 1));
  const Result<HullReport> cone = visual_hull(rig, mattes, options);
  ASSERT_THAT(cone, IsOk());
  EXPECT_GT(cone->volume, 0);
}

TEST_P(VisualHullErrors, RefusesOptionsOutOfRange) {
  const auto refuses = [&](const HullOptions& bad, const char* words) {
    EXPECT_THAT(visual_hull(rig, mattes, bad), FailsWith(ErrorCode::InvalidArgument, words));
  };
  HullOptions bad = options;
  bad.resolution = 7;
  refuses(bad, "resolution of 7");
  bad.resolution = 100000;
  refuses(bad, "resolution of 100000");
  bad = options;
  bad.smoothing = -0.1;
  refuses(bad, "smoothing");
  bad.smoothing = std::numeric_limits<double>::quiet_NaN();
  refuses(bad, "smoothing");
  bad = options;
  bad.volume = Eigen::AlignedBox3d(Vector3d(0, 0, 0), Vector3d(1, 0, 1));
  refuses(bad, "positive sides");
  bad.volume =
      Eigen::AlignedBox3d(Vector3d(0, 0, 0), Vector3d(1, std::numeric_limits<double>::infinity(), 1));
  refuses(bad, "finite corners");
}

}  // namespace
}  // namespace floatstage::recon
