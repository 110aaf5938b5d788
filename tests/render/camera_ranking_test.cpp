#include "render/camera_ranking.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "core/random.h"
#include "render/camera_choice.h"
#include "render/ray_kernels.h"
#include "tests/render/stage.h"

namespace floatstage::render {
namespace {

Eigen::Vector3d any_point(Random& random, double reach) {
  return {random.uniform(-reach, reach), random.uniform(-reach, reach), random.uniform(-reach, reach)};
}

Rig any_rig(Random& random, int count) {
  Rig rig = arc(count, 1);
  for (RigCamera& camera : rig.cameras)
    camera.cam_from_world = look_at(any_point(random, 3), any_point(random, 0.2), {0.1, 0.2, 0.9});
  return rig;
}

View any_view(Random& random) {
  View view = view_at(0);
  view.view_from_world = look_at(any_point(random, 2), any_point(random, 0.5), {0.1, 0.2, 0.9});
  return view;
}

/// The cameras by `angles` as the rule has it: to a nanoradian, then by their places in the world.
std::vector<int> order_by(const std::vector<double>& angles, const Rig& rig) {
  std::vector<int> order(angles.size());
  std::iota(order.begin(), order.end(), 0);
  auto key = [&](int i) {
    const Eigen::Vector3d center = rig.cameras[static_cast<std::size_t>(i)].cam_from_world.center();
    return std::tuple(std::llround(angles[static_cast<std::size_t>(i)] * 1e9), center.x(), center.y(),
                      center.z());
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
  return order;
}

void expect_as_the_reference(const Rig& rig, const RankingSamples& samples, const View& view,
                             CameraRanking& ranking) {
  const std::vector<double> expected = mean_angles(rig.cameras, samples, view);
  std::vector<int> order;
  for (const RankedCamera& camera : ranking.rank(view)) {
    const double angle = expected[static_cast<std::size_t>(camera.camera)];
    EXPECT_NEAR(camera.angle, angle, 1e-14) << "camera " << camera.camera;
    order.push_back(camera.camera);
  }
  EXPECT_EQ(order, order_by(expected, rig));
}

TEST(CameraRanking, IsThatOfTheReferenceForAnyNumberOfCameras) {
  Random random(1);
  const RankingSamples samples = ranking_samples(ball(0.4F, 30));
  for (int count = 0; count <= 50; ++count) {
    SCOPED_TRACE(testing::Message() << count << " cameras");
    const Rig rig = any_rig(random, count);
    CameraRanking ranking(rig.cameras, samples);
    for (int i = 0; i < 20; ++i) expect_as_the_reference(rig, samples, any_view(random), ranking);
  }
}

// Cameras at equal angles on both sides of the view, and the view where a camera is.
TEST(CameraRanking, IsThatOfTheReferenceOnARing) {
  const Rig rig = arc(24, 15);
  const RankingSamples samples = ranking_samples(ball(0.25F, 12));
  CameraRanking ranking(rig.cameras, samples);
  for (double degrees = -180; degrees < 180; degrees += 2.5)
    for (const double elevation : {0.0, 10.0, 60.0}) {
      SCOPED_TRACE(testing::Message() << degrees << " degrees, " << elevation);
      expect_as_the_reference(rig, samples, view_at(degrees, elevation), ranking);
    }
}

TEST(CameraRanking, IsThatOfTheReferenceOfTheSceneSetLast) {
  Random random(2);
  CameraRanking ranking;
  EXPECT_TRUE(ranking.rank(view_at(0)).empty());
  for (const int count : {30, 3, 17}) {
    const Rig rig = any_rig(random, count);
    const RankingSamples samples = ranking_samples(ball(0.1F * static_cast<float>(count % 4 + 1), count));
    ranking.set(rig.cameras, samples);
    for (int i = 0; i < 20; ++i) expect_as_the_reference(rig, samples, any_view(random), ranking);
  }
}

// Of a mesh without triangles nothing tells cameras apart but their places.
/// What rank_rest() says, one sample and camera after the other.
struct SlowRest {
  double lacking = 0;
  std::vector<double> angles;
};
SlowRest slow_rest(const Rig& rig, const RankingSamples& samples, const View& view,
                   const std::vector<BlendedCamera>& blended) {
  SlowRest rest{0, std::vector<double>(rig.cameras.size())};
  double all = 0, total = 0;
  for (const RankingSample& sample : samples) {
    const RankingSamples one{sample};
    const Eigen::Vector3d p = sample.point.cast<double>();
    const std::vector<double> angles = mean_angles(rig.cameras, one, view);
    const double weight = importance(view, p);
    double have = 0, fades = 0;
    for (const BlendedCamera& b : blended) {
      have += b.fade * in_picture(rig.cameras[static_cast<std::size_t>(b.camera)], p);
      fades += b.fade;
    }
    const double lack = weight * std::max(0.0, 1 - have / fades / 0.3F);
    all += weight;
    rest.lacking += lack;
    total += lack + 0.02 * weight;
    for (std::size_t i = 0; i < angles.size(); ++i)
      rest.angles[i] +=
          (lack + 0.02 * weight) * angles[i] + lack * M_PI * (1 - shows(rig.cameras[i], sample));
  }
  for (double& a : rest.angles) a /= total;
  rest.lacking /= all;
  return rest;
}

TEST(CameraRanking, OfTheRestIsThatOfTheSlowReference) {
  Random random(8);
  const RankingSamples samples = ranking_samples(ball(0.9F, 30));
  int lacking = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Rig rig = any_rig(random, 3 + trial);
    const View view = any_view(random);
    CameraRanking ranking(rig.cameras, samples);
    ranking.rank(view);
    const std::vector<BlendedCamera> blended{{0, random.uniform(0.1, 1)}, {2, random.uniform(0.1, 1)}};
    const SlowRest expected = slow_rest(rig, samples, view, blended);
    const CameraRanking::Rest rest = ranking.rank_rest(view, blended);
    EXPECT_NEAR(rest.lacking, expected.lacking, 1e-12);
    if (rest.lacking == 0) continue;
    ++lacking;
    ASSERT_THAT(rest.ranked, testing::SizeIs(rig.cameras.size()));
    for (std::size_t i = 0; i < rest.ranked.size(); ++i) {
      const RankedCamera& camera = rest.ranked[i];
      EXPECT_NEAR(camera.angle, expected.angles[static_cast<std::size_t>(camera.camera)], 1e-12);
      EXPECT_LE(i == 0 ? 0 : rest.ranked[i - 1].nanoradians, camera.nanoradians);
    }
  }
  EXPECT_GE(lacking, 5) << "all have it all";
}

TEST(CameraRanking, OfTheRestIsTheUsualOneWhereNothingIsMissing) {
  const Rig rig = arc(9, 17);
  CameraRanking ranking(rig.cameras, ranking_samples(ball(0.1F, 12)));
  const std::span<const RankedCamera> usual = ranking.rank(view_at(5));
  const std::vector<BlendedCamera> one{{usual[0].camera, 1}};
  const CameraRanking::Rest rest = ranking.rank_rest(view_at(5), one);
  EXPECT_EQ(rest.lacking, 0);
  EXPECT_EQ(rest.ranked.data(), usual.data());
}

// Beyond the border it falls, behind the camera there is nothing.
TEST(CameraRanking, KnowsWhatIsInAPicture) {
  RigCamera camera{"c", small_camera(200, 100), look_at({0, -1, 0}, {0, 0, 0}, {0, 0, 1}), {}};
  const double edge = 100 / camera.model.fx;  // metres from the axis at the picture's left and right
  EXPECT_EQ(in_picture(camera, {0, 0, 0}), 1);
  EXPECT_EQ(in_picture(camera, {0.99 * edge, 0, 0}), 1);
  EXPECT_NEAR(in_picture(camera, {1.02 * edge, 0, 0}), 0.5, 1e-6);
  EXPECT_NEAR(in_picture(camera, {-1.03 * edge, 0, 0}), 0.25, 1e-6);
  EXPECT_EQ(in_picture(camera, {1.05 * edge, 0, 0}), 0);
  EXPECT_EQ(in_picture(camera, {0, -1.5, 0}), 0);
}

TEST(CameraRanking, KnowsWhichSurfacesAPictureShows) {
  const RigCamera camera{"c", small_camera(200, 100), look_at({0, -1, 0}, {0, 0, 0}, {0, 0, 1}), {}};
  EXPECT_EQ(shows(camera, {{0, 0, 0}, {0, -1, 0}}), 1);
  EXPECT_NEAR(shows(camera, {{0, 0, 0}, Eigen::Vector3f(1, -0.1F, 0).normalized()}), 0.5, 0.01) << "along it";
  EXPECT_EQ(shows(camera, {{0, 0, 0}, {0, 1, 0}}), 0) << "from behind";
  EXPECT_EQ(shows(camera, {{2, 0, 0}, {0, -1, 0}}), 0) << "beside the picture";
}

TEST(CameraRanking, IsByPlaceWithoutSamples) {
  const Rig rig = arc(5, 20);
  CameraRanking ranking(rig.cameras, {});
  expect_as_the_reference(rig, {}, view_at(7), ranking);
}

TEST(CameraRanking, StandsACameraOnASample) {
  const Rig rig = arc(3, 20);
  const RankingSamples samples{{rig.cameras[1].cam_from_world.center().cast<float>(), {0, 0, 0}}, {}};
  Rig exact = rig;
  exact.cameras[1].cam_from_world.rotation.setIdentity();
  exact.cameras[1].cam_from_world.translation = -samples[0].point.cast<double>();
  CameraRanking ranking(exact.cameras, samples);
  expect_as_the_reference(exact, samples, view_at(7), ranking);
}

TEST(RayKernels, MeasureAnglesFromNothingToAHalfTurn) {
  std::vector<double> places(3 * kRayLanes), rays(3 * kRayLanes), sums(kRayLanes, 0.5);
  const std::vector<double> angles{0, 1e-9, 1e-3, 0.5, 1.2, M_PI / 2, 3, M_PI};
  ASSERT_EQ(angles.size(), kRayLanes);
  for (std::size_t i = 0; i < kRayLanes; ++i) {
    places[i] = 2 * std::cos(angles[i]) + 5;
    places[kRayLanes + i] = 2 * std::sin(angles[i]) + 6;
    places[2 * kRayLanes + i] = 7;
  }
  unit_rays({5, 6, 7}, places.data(), kRayLanes, rays.data());
  add_angles({1, 0, 0}, 2, rays.data(), kRayLanes, sums.data());
  for (std::size_t i = 0; i < kRayLanes; ++i) EXPECT_NEAR(sums[i] - 0.5, angles[i], 1e-14) << angles[i];
}

}  // namespace
}  // namespace floatstage::render
