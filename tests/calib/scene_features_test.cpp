#include "calib/scene_features.h"

#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/calibrate.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

// Points in the stage's volume that neighbouring cameras see, 0.3 px off.
std::vector<SceneFeature> features_of(const Rig& truth, int count) {
  Random random(5);
  std::vector<SceneFeature> features;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d x(random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8), random.uniform(0.2, 1.8));
    SceneFeature f{.position = x, .seen = {}};
    const int first = i % static_cast<int>(truth.cameras.size());
    for (int k = 0; k < 3; ++k) {
      const auto c = static_cast<std::size_t>((first + k) % static_cast<int>(truth.cameras.size()));
      const std::optional<Eigen::Vector2d> p =
          project(truth.cameras[c].model, truth.cameras[c].cam_from_world * x);
      if (p)
        f.seen.emplace_back(static_cast<int>(c),
                            *p + 0.3 * Eigen::Vector2d(random.normal(), random.normal()));
    }
    features.push_back(std::move(f));
  }
  return features;
}

// The rig in another world and unit, each camera a little off: what COLMAP might give.
Rig elsewhere(const Rig& truth, double scale, double off_degrees) {
  Rig rig = truth;
  const Rigid3 motion{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())),
                      {3, -1, 2}};
  Random random(9);
  for (RigCamera& c : rig.cameras) {
    const Eigen::Vector3d axis(random.normal(), random.normal(), random.normal());
    c.cam_from_world =
        Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(off_degrees / kDegrees, axis.normalized())), {0, 0, 0}} *
        c.cam_from_world * motion;
    c.cam_from_world.translation *= scale;
  }
  return rig;
}

Observations observe(const Rig& truth) {
  Observations o;
  for (const RigCamera& c : truth.cameras)
    o.cameras.push_back({.serial = c.serial,
                         .width = c.model.width,
                         .height = c.model.height,
                         .lens = static_cast<LensKind>(c.model.lens.index()),
                         .terms = {},
                         .intrinsics = Prior::Fixed,
                         .pose = Prior::Unknown,
                         .model = c.model,
                         .cam_from_world = {}});
  return o;
}

std::vector<int> one_to_one(const Rig& rig) {
  std::vector<int> all;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i) all.push_back(static_cast<int>(i));
  return all;
}

double distance(const Rig& rig, std::size_t a, std::size_t b) {
  return (rig.cameras[a].cam_from_world.center() - rig.cameras[b].cam_from_world.center()).norm();
}

TEST(SceneFeatures, PlaceARigWhoseScaleIsOneKnownDistance) {
  const Rig truth = ring_rig(8);
  Observations o = observe(truth);
  const Rig start = elsewhere(truth, 1.02, 0.5);  // scaled by a rough measure already
  for (std::size_t c = 0; c < 8; ++c) o.cameras[c].found = start.cameras[c].cam_from_world;
  add_features(o, features_of(truth, 800), one_to_one(truth));
  o.distances = {{0, 4, distance(truth, 0, 4), 1e-4}};
  const Result<Calibration> solved = calibrate(o);
  ASSERT_THAT(solved, IsOk());
  EXPECT_NEAR(distance(solved->rig, 0, 4), distance(truth, 0, 4), 2e-4);
  const Result<RigAgreement> a = agreement(solved->rig, truth);
  ASSERT_TRUE(a);
  EXPECT_NEAR(a->scale, 1, 5e-4);
  EXPECT_LT(a->worst_percent, 0.1);
  EXPECT_LT(a->worst_turn_degrees, 0.05);
  for (const CameraQuality& q : solved->cameras) {
    EXPECT_NEAR(*q.rms_px, 0.3, 0.1) << q.serial << ": of six numbers a point, three go into its place";
    EXPECT_FALSE(q.moved_mm) << "where it was found is not where it was";
    if (q.serial == "cam0")
      EXPECT_THAT(q.position_sigma_mm.because(), testing::HasSubstr("relative to this camera"));
    else
      EXPECT_LT(q.position_sigma_mm, 10) << q.serial;
  }
}

TEST(SceneFeatures, AndBoardsAreSolvedForTogetherAndTheBoardIsTheScale) {
  const Rig truth = ring_rig(6);
  const CaptureOptions options{.frames = 40, .frame_seconds = 0.2};
  Observations o = capture(truth, two_sided_board(8, 6, 0.1, 0.006), wandering(options), options);
  for (std::size_t c = 0; c < 6; ++c) {
    o.cameras[c].intrinsics = Prior::Fixed;
    o.cameras[c].model = truth.cameras[c].model;
  }
  Rig found = elsewhere(truth, 1.0 / 3, 0.05);
  const std::optional<double> metres = metres_per_unit(o, found);
  ASSERT_TRUE(metres);
  EXPECT_NEAR(*metres, 3, 0.05);
  for (std::size_t c = 0; c < 6; ++c) {
    found.cameras[c].cam_from_world.translation *= *metres;
    o.cameras[c].found = found.cameras[c].cam_from_world;
  }
  add_features(o, features_of(truth, 400), one_to_one(truth));
  const Result<Calibration> solved = calibrate(o);
  ASSERT_THAT(solved, IsOk());
  EXPECT_THAT(solved->failures, testing::IsEmpty());
  const Result<RigAgreement> a = agreement(solved->rig, truth);
  EXPECT_NEAR(a->scale, 1, 5e-4);
  EXPECT_LT(a->worst_percent, 0.05);
}

TEST(SceneFeatures, OfYesterdaysRigNameTheCameraThatMoved) {
  const Rig yesterday = ring_rig(8);
  Rig today = yesterday;
  today.cameras[3].cam_from_world.translation += Eigen::Vector3d(0.05, 0, 0);
  Observations o = observe(today);
  for (std::size_t c = 0; c < 8; ++c) {
    o.cameras[c].pose = Prior::Start;
    o.cameras[c].cam_from_world = yesterday.cameras[c].cam_from_world;
  }
  add_features(o, features_of(today, 800), one_to_one(today));
  for (int a = 0; a < 8; ++a)
    for (int b = a + 1; b < 8; ++b) {
      const double metres = distance(yesterday, static_cast<std::size_t>(a), static_cast<std::size_t>(b));
      o.distances.push_back({a, b, metres, 0.005 * metres});
    }
  const Result<Calibration> solved = calibrate(o);
  ASSERT_THAT(solved, IsOk());
  for (std::size_t c = 0; c < 8; ++c) {
    if (c == 3) {
      EXPECT_NEAR(*solved->cameras[c].moved_mm, 50, 3);
    } else {
      EXPECT_LT(*solved->cameras[c].moved_mm, 3) << solved->cameras[c].serial;
    }
  }
  EXPECT_THAT(solved->remarks,
              testing::Contains(testing::HasSubstr("camera '" + today.cameras[3].serial + "' has moved")));
}

TEST(AddFeatures, TakesThoseThatMostCamerasSee) {
  const Rig truth = ring_rig(4);
  Observations o = observe(truth);
  const std::vector<SceneFeature> features = {{{0, 0, 0}, {{0, {1, 1}}, {1, {2, 2}}}},
                                              {{0, 0, 0}, {{2, {9, 9}}}},
                                              {{0, 0, 1}, {{0, {3, 3}}, {1, {4, 4}}, {3, {5, 5}}}}};
  add_features(o, features, one_to_one(truth), 1);
  ASSERT_EQ(o.views.size(), 3u);
  EXPECT_EQ(o.views[2].camera, 3);
  EXPECT_EQ(o.views[2].points[0].pixel, Eigen::Vector2d(5, 5));
}

TEST(MetresPerUnit, AreUnknownWithoutATargetInTwoCameras) {
  EXPECT_FALSE(metres_per_unit(observe(ring_rig(4)), ring_rig(4)));
}

TEST(OntoKnown, BringsARigBackWhateverOneCameraDid) {
  const Rig known = ring_rig(8);
  Rig rig = elsewhere(known, 0.2, 0);
  rig.cameras[2].cam_from_world.translation += Eigen::Vector3d(0.1, 0.2, 0);
  const std::optional<Rig> back = onto_known(rig, known);
  ASSERT_TRUE(back);
  for (std::size_t c = 0; c < 8; ++c) {
    const double off =
        (back->cameras[c].cam_from_world.center() - known.cameras[c].cam_from_world.center()).norm();
    if (c == 2) {
      EXPECT_NEAR(off, 5 * std::hypot(0.1, 0.2), 1e-6);
    } else {
      EXPECT_LT(off, 1e-9) << c;
    }
  }
  rig.cameras.resize(2);
  EXPECT_FALSE(onto_known(rig, known));
  EXPECT_FALSE(agreement(rig, known));
}

TEST(Agreement, IsRefusedForCamerasInOnePointAndKnowsNoTurnAboutALine) {
  Rig known = ring_rig(5, 3);
  for (RigCamera& c : known.cameras) c.cam_from_world.translation.setZero();
  EXPECT_THAT(agreement(known, known), FailsWith(ErrorCode::BadData, "stand in one point"));
  EXPECT_THAT(agreement(ring_rig(5, 3), known), FailsWith(ErrorCode::BadData, "the known cameras"));
  for (std::size_t i = 0; i < known.cameras.size(); ++i)
    known.cameras[i].cam_from_world.translation =
        known.cameras[i].cam_from_world.rotation * Eigen::Vector3d(-0.3 * static_cast<double>(i), 0, 0);
  const Result<RigAgreement> line = agreement(known, known);
  ASSERT_THAT(line, IsOk());
  EXPECT_FALSE(line->worst_turn_degrees);
  EXPECT_LT(line->worst_percent, 1e-9);
}

TEST(Agreement, IsAShareOfTheRadiusAndNamesTheWorst) {
  const Rig known = ring_rig(8, 3);
  Rig rig = elsewhere(known, 0.5, 0);
  const RigAgreement exact = *agreement(rig, known);
  EXPECT_LT(exact.worst_percent, 1e-9);
  EXPECT_NEAR(exact.scale, 2, 1e-9);
  rig.cameras[5].cam_from_world.translation.x() +=
      0.5 * 0.03;  // 30 mm at 3 m: 1 %, a part of which the similarity takes up
  const RigAgreement off = *agreement(rig, known);
  EXPECT_EQ(off.worst, known.cameras[5].serial);
  EXPECT_GT(off.worst_percent, 0.5);
  EXPECT_LT(off.worst_percent, 1.1);
}

}  // namespace
}  // namespace floatstage::calib
