// What is known beforehand, what the world is, when cameras expose, and how well all of it is known
// afterwards.

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/calibrate.h"
#include "core/rig_io.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

// The camera that the others' instants are relative to has an offset of 0 by definition and no measurement.
double late_by(const CameraQuality& q) { return q.time_offset_ms ? *q.time_offset_ms : 0; }

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr double kDegrees = 180 / std::numbers::pi;

void know(Observations& seen, const Rig& rig, Prior intrinsics, Prior pose) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    seen.cameras[c].intrinsics = intrinsics;
    seen.cameras[c].pose = pose;
    seen.cameras[c].model = rig.cameras[c].model;
    seen.cameras[c].cam_from_world = rig.cameras[c].cam_from_world;
  }
}

double turned(const Rigid3& a, const Rigid3& b) { return a.rotation.angularDistance(b.rotation) * kDegrees; }
double moved_mm(const Rigid3& a, const Rigid3& b) { return 1e3 * (a.center() - b.center()).norm(); }

TEST(Calibrate, FindsPosesFromAWandAlone) {
  const Rig truth = ring_rig(4);
  const CaptureOptions options{.frames = 150, .frame_seconds = 0.2};
  Observations seen = capture(truth, wand({0, 0.2, 0.5}, 1e-4), wandering(options), options);
  know(seen, truth, Prior::Fixed, Prior::Unknown);
  const Result<Calibration> solved = calibrate(seen);
  ASSERT_THAT(solved, IsOk());
  EXPECT_THAT(solved->failures, IsEmpty());
  const TruthErrors e = compare(solved->rig, truth, options);
  EXPECT_LT(e.grid_mm, 0.3);
  EXPECT_LT(e.rotation_degrees, 0.02);
  EXPECT_LT(std::abs(solved->scale.bias_mm), 0.1);
}

TEST(Calibrate, SaysThatAWandAloneDoesNotGiveIntrinsics) {
  const CaptureOptions options{.frames = 30};
  EXPECT_THAT(calibrate(capture(ring_rig(2), wand({0, 0.5}, 1e-4), wandering(options), options)),
              FailsWith(ErrorCode::BadData, "give its intrinsics"));
}

TEST(Calibrate, StandsInTheWorldOfSurveyedMarkers) {
  const Rig truth = ring_rig(4);
  Target markers = grid_board(3, 3, 0.5);
  markers.name = "markers";
  markers.kind = TargetKind::Markers;
  markers.grid.reset();
  markers.positions_sigma = 1e-4;
  for (TargetPoint& p : markers.points) {
    p.normal.setZero();
    p.position += Eigen::Vector3d(-0.5, -0.5, 0.5 + 0.11 * (p.id % 4));
  }
  Observations seen = capture(truth, markers,
                              [&](double) {
                                Eigen::Vector3d middle = Eigen::Vector3d::Zero();
                                for (const TargetPoint& p : markers.points) middle += p.position / 9;
                                return Rigid3{Eigen::Quaterniond::Identity(), middle};
                              },
                              {.frames = 20});
  know(seen, truth, Prior::Fixed, Prior::Unknown);
  const Result<Calibration> solved = calibrate(seen);
  ASSERT_THAT(solved, IsOk());
  EXPECT_EQ(solved->reference, -1);
  for (std::size_t c = 0; c < 4; ++c) {
    EXPECT_LT(moved_mm(solved->rig.cameras[c].cam_from_world, truth.cameras[c].cam_from_world), 1.0);
    EXPECT_LT(turned(solved->rig.cameras[c].cam_from_world, truth.cameras[c].cam_from_world), 0.02);
  }
}

TEST(Calibrate, StandsOnTheFloorBoard) {
  const Rig truth = ring_rig(6);
  const CaptureOptions options{.frames = 60, .frame_seconds = 0.2};
  Observations seen = capture(truth, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  Target floor = grid_board(6, 5, 0.12);
  floor.name = "floor";
  const Rigid3 lying{Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX())),
                     {0.1, 0.2, 0.004}};
  CaptureOptions once = options;
  once.frames = 1;
  once.steepest_degrees = 80;
  capture_more(
      seen, truth, floor, [&](double) { return lying; }, once);
  const int frame = seen.views.back().frame;
  seen.gauge = FloorBoard{1, frame, 0.004};
  const Result<Calibration> solved = calibrate(seen);
  ASSERT_THAT(solved, IsOk());
  for (std::size_t c = 0; c < 6; ++c) {
    const Eigen::Vector3d up = solved->rig.cameras[c].cam_from_world.rotation * Eigen::Vector3d::UnitZ();
    EXPECT_LT(
        std::acos(up.dot(truth.cameras[c].cam_from_world.rotation * Eigen::Vector3d::UnitZ())) * kDegrees,
        0.1);
    EXPECT_NEAR(solved->rig.cameras[c].cam_from_world.center().z(),
                truth.cameras[c].cam_from_world.center().z(), 0.004);
  }
  seen.gauge = FloorBoard{1, frame + 1, 0};
  EXPECT_THAT(calibrate(seen), FailsWith(ErrorCode::BadData, "choose a frame"));
}

TEST(Calibrate, StandsWhereAHandSetIt) {
  const Rig truth = ring_rig(3);
  const CaptureOptions options{.frames = 60, .frame_seconds = 0.2};
  Observations seen = capture(truth, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  seen.gauge = HandSet{1, truth.cameras[1].cam_from_world};
  const Result<Calibration> solved = calibrate(seen);
  ASSERT_THAT(solved, IsOk());
  EXPECT_LT(moved_mm(solved->rig.cameras[1].cam_from_world, truth.cameras[1].cam_from_world), 1e-6);
  EXPECT_LT(moved_mm(solved->rig.cameras[0].cam_from_world, truth.cameras[0].cam_from_world), 5);
  EXPECT_THAT(solved->remarks, IsEmpty());
}

TEST(Calibrate, SaysWhenNothingTellsWhereTheFloorIs) {
  const CaptureOptions options{.frames = 60, .frame_seconds = 0.2};
  const Result<Calibration> solved =
      calibrate(capture(ring_rig(3), two_sided_board(7, 5, 0.08, 0.005), wandering(options), options));
  ASSERT_THAT(solved, IsOk());
  EXPECT_THAT(solved->remarks, Contains(HasSubstr("where the floor is remains unknown")));
  EXPECT_GT(mean_up(solved->rig).z(), 0.99);
}

TEST(Calibrate, KeepsFixedPosesToTheLastBit) {
  const Rig truth = ring_rig(4);
  const CaptureOptions options{.frames = 40, .frame_seconds = 0.2};
  Observations seen = capture(truth, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  know(seen, truth, Prior::Fixed, Prior::Fixed);
  seen.cameras[3].pose = Prior::Unknown;
  const Result<Calibration> solved = calibrate(seen);
  ASSERT_THAT(solved, IsOk());
  EXPECT_EQ(solved->rig.cameras[0].model, truth.cameras[0].model);
  EXPECT_EQ(solved->rig.cameras[0].cam_from_world.translation, truth.cameras[0].cam_from_world.translation);
  EXPECT_LT(moved_mm(solved->rig.cameras[3].cam_from_world, truth.cameras[3].cam_from_world), 0.5);
}

TEST(Calibrate, StartsFromYesterdayAndSaysWhichCameraHasMoved) {
  const Rig yesterday = ring_rig(5);
  Rig today = yesterday;
  Rigid3& knocked = today.cameras[2].cam_from_world;
  knocked =
      Rigid3{Eigen::Quaterniond(Eigen::AngleAxisd(0.4 / kDegrees, Eigen::Vector3d::UnitY())), {0.01, 0, 0}} *
      knocked;
  const CaptureOptions options{.frames = 100, .extent = 0.9, .frame_seconds = 0.2};
  Observations seen = capture(today, two_sided_board(8, 6, 0.1, 0.005), wandering(options), options);
  know(seen, yesterday, Prior::Fixed, Prior::Start);
  const Result<Calibration> solved = calibrate(seen);
  ASSERT_THAT(solved, IsOk());
  EXPECT_NEAR(*solved->cameras[2].turned_degrees, 0.4, 0.03);
  EXPECT_LT(*solved->cameras[0].turned_degrees, 0.05);
  ASSERT_EQ(solved->remarks.size(), 1u);
  EXPECT_THAT(solved->remarks[0], HasSubstr("'cam2' has moved"));
}

TEST(Calibrate, FindsWhenACameraExposes) {
  const Rig truth = ring_rig(4);
  CaptureOptions options{.frames = 150};
  options.late_camera = 1;
  options.late_frames = 0.37;
  const Observations seen = capture(truth, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  const Result<Calibration> solved = calibrate(seen, {.time_offsets = true});
  ASSERT_THAT(solved, IsOk());
  const double others = late_by(solved->cameras[0]);
  // Its pictures show what the others saw 0.37 frames before: it is at -0.37 frames on the others' clock.
  EXPECT_NEAR(late_by(solved->cameras[1]) - others, -0.37 * 1000 / 30, 0.5);
  EXPECT_NEAR(late_by(solved->cameras[2]) - others, 0, 0.5);
  EXPECT_LT(solved->cameras[1].rms_px, 0.2);
  EXPECT_LT(compare(solved->rig, truth, options).grid_mm, 0.3);
}

// Webcams: each picture has an instant of its own, and one camera shows the frame before.
TEST(Calibrate, BearsPicturesTakenTooEarlyAndTooLate) {
  Rig truth = facing_rig();
  truth.cameras.resize(4);  // on one side: all see the board together
  CaptureOptions options{
      .frames = 150, .frame_seconds = 1.0 / 6, .late_camera = 1, .late_frames = 0.8, .jitter_seconds = 0.01};
  const Observations seen =
      capture(truth, two_sided_board(7, 5, 0.08, 0.005), wandering(options, 0.15), options);
  const Result<Calibration> solved = calibrate(seen, {.time_offsets = true});
  ASSERT_THAT(solved, IsOk());
  const double others = late_by(solved->cameras[0]);
  EXPECT_NEAR(late_by(solved->cameras[1]) - others, -0.8 * 1000 / 6, 6);
  EXPECT_NEAR(late_by(solved->cameras[2]) - others, 0, 6);
  EXPECT_NEAR(
      *solved->jitter_ms, 10,
      5);  // too small rather than too large: boards follow what all cameras of a frame have in common
  for (const CameraQuality& q : solved->cameras) {
    EXPECT_LT(q.rms_px, 0.2) << q.serial;
    EXPECT_LT(q.holdout_px, 1.3 * *q.rms_px) << q.serial;
    EXPECT_LT(q.outliers, 0.1 * (q.points + q.outliers)) << q.serial;
  }
  EXPECT_LT(compare(solved->rig, truth, options).grid_mm, 1);
}

// Noise in the pictures goes into the fit and into what the fit predicts alike; one lens term too many does
// not.
TEST(Calibrate, PredictsEveryFrameOfASmallCapture) {
  const CaptureOptions options{.frames = 30, .frame_seconds = 0.2};
  const Observations seen =
      capture(ring_rig(4), two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  const Result<Calibration> with = calibrate(seen), without = calibrate(seen, {.holdout_every = 0});
  ASSERT_THAT(with, IsOk());
  ASSERT_THAT(without, IsOk());
  for (const CameraQuality& q : with->cameras) {
    EXPECT_GT(q.holdout_px, 0.9 * *q.rms_px);  // not of a few lucky frames
    EXPECT_LT(q.holdout_px, 1.3 * *q.rms_px);
  }
  EXPECT_EQ(to_json(with->rig), to_json(without->rig));
  EXPECT_FALSE(without->cameras[0].holdout_px) << "nothing was held out, which is no error of 0";
}

TEST(Calibrate, GivesTheSameBytesAtAnyNumberOfThreads) {
  const CaptureOptions options{.frames = 30, .frame_seconds = 0.2};
  const Observations seen =
      capture(ring_rig(4), two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  const Result<Calibration> one = calibrate(seen, {.threads = 1}), four = calibrate(seen, {.threads = 4});
  ASSERT_THAT(one, IsOk());
  ASSERT_THAT(four, IsOk());
  EXPECT_EQ(to_json(one->rig), to_json(four->rig));
  EXPECT_EQ(one->covariance, four->covariance);
}

// Ceres orders blocks by their addresses, which the heap chooses anew each time.
TEST(Calibrate, GivesTheSameBytesWhereverTheHeapPutsThings) {
  const CaptureOptions options{.frames = 20, .frame_seconds = 0.2};
  const Rig rig = ring_rig(4);
  Observations seen = capture(rig, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  capture_more(seen, rig, wand({0, 0.3, 0.7}, 2e-4), wandering(options), options);
  std::vector<std::vector<double>> holes;  // of the sizes that wands have
  std::string first;
  for (std::size_t round = 0; round < 3; ++round) {
    const Result<Calibration> solved = calibrate(seen);
    ASSERT_THAT(solved, IsOk());
    if (round == 0) first = to_json(solved->rig);
    EXPECT_EQ(to_json(solved->rig), first);
    for (std::size_t i = 0; i < 500; ++i) holes.emplace_back(9 + (i * (round + 3)) % 7);
    for (std::size_t i = 0; i < holes.size(); i += 2 + round) holes[i] = {};
  }
}

TEST(Calibrate, NamesCamerasThatNoTargetJoins) {
  const Rig truth = facing_rig();
  const CaptureOptions options{.frames = 40, .frame_seconds = 0.2};
  Observations seen = capture(truth, two_sided_board(7, 5, 0.08, 0.005), wandering(options), options);
  // The second half of the rig sees other frames.
  for (TargetView& v : seen.views)
    if (v.camera >= 4) v.frame += 1000;
  EXPECT_THAT(calibrate(seen),
              FailsWith(ErrorCode::BadData, "'cam0', 'cam1', 'cam2', 'cam3' to camera 'cam7'"));
}

TEST(Calibrate, SaysWhenThereIsNothingToSolve) {
  Observations seen;
  EXPECT_THAT(calibrate(seen), FailsWith(ErrorCode::BadData, "no camera"));
  seen = capture(ring_rig(2), grid_board(7, 5, 0.08),
                 [](double) {
                   return Rigid3{Eigen::Quaterniond::Identity(), {0, 0, 100}};
                 },
                 {.frames = 3});
  EXPECT_THAT(calibrate(seen), FailsWith(ErrorCode::BadData, "no picture of any camera shows a target"));
  EXPECT_THAT(calibrate(seen, {.outlier_sigmas = 0}), FailsWith(ErrorCode::InvalidArgument, "outliers"));
}

// The errors of many captures must be as large as was predicted of each: no camera's numbers look better than
// they are.
TEST(Sigmas, AreTheSizeOfTheTrueErrors) {
  const Rig truth = ring_rig(3);
  double focal = 0, center = 0, rotation = 0, position = 0, projection = 0;
  int cameras = 0, poses = 0, points = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const CaptureOptions options{.frames = 18, .seed = seed, .extent = 0.8, .frame_seconds = 0.4};
    const Result<Calibration> solved =
        calibrate(capture(truth, two_sided_board(6, 4, 0.15, 0.005), wandering(options), options),
                  {.holdout_every = 0});
    ASSERT_THAT(solved, IsOk());
    const auto reference = static_cast<std::size_t>(solved->reference);
    // Into the truth's world by the reference camera, in whose frame the sigmas are.
    const Rigid3 solved_from_truth =
        solved->rig.cameras[reference].cam_from_world.inverse() * truth.cameras[reference].cam_from_world;
    std::vector<Eigen::Vector3d> volume;
    for (int i = 0; i < 27; ++i)
      volume.push_back(solved_from_truth *
                       Eigen::Vector3d(0.6 * (i % 3 - 1), 0.6 * (i / 3 % 3 - 1), 1 + 0.6 * (i / 9 - 1)));
    for (std::size_t c = 0; c < 3; ++c) {
      const CameraQuality& q = solved->cameras[c];
      const CameraModel &is = solved->rig.cameras[c].model, &was = truth.cameras[c].model;
      focal += 0.5 * (std::pow((is.fx - was.fx) / q.intrinsics_sigma[0], 2) +
                      std::pow((is.fy - was.fy) / q.intrinsics_sigma[1], 2));
      center += 0.5 * (std::pow((is.cx - was.cx) / q.intrinsics_sigma[2], 2) +
                       std::pow((is.cy - was.cy) / q.intrinsics_sigma[3], 2));
      ++cameras;
      if (c == reference) continue;
      const Rigid3 pose = solved->rig.cameras[c].cam_from_world * solved_from_truth;
      rotation += std::pow(turned(pose, truth.cameras[c].cam_from_world) / *q.rotation_sigma_degrees, 2);
      position += std::pow(moved_mm(pose, truth.cameras[c].cam_from_world) / *q.position_sigma_mm, 2);
      ++poses;
      // Of points fixed to the reference camera: a volume of none leaves the map in its frame.
      const ProjectionUncertainty map(*solved, {});
      for (const Eigen::Vector3d& x : volume) {
        const Eigen::Vector3d true_x = solved_from_truth.inverse() * x;
        const std::optional<Eigen::Vector2d> here = project(is, solved->rig.cameras[c].cam_from_world * x),
                                             there = project(was, truth.cameras[c].cam_from_world * true_x);
        if (!here || !there) continue;
        projection +=
            (*here - *there).squaredNorm() / (2 * std::pow(map.sigma_px(static_cast<int>(c), x), 2));
        ++points;
      }
    }
  }
  for (const double ratio :
       {focal / cameras, center / cameras, rotation / poses, position / poses, projection / points}) {
    EXPECT_GE(ratio, 0.8);
    EXPECT_LE(ratio, 1.25);
  }
}

TEST(Uncertainty, IsLeastWhereTheBoardWasAndGrowsOutside) {
  const CaptureOptions options{.frames = 40, .extent = 0.4, .frame_seconds = 0.2};
  const Rig truth = ring_rig(4);
  Observations seen = capture(truth, two_sided_board(7, 5, 0.06, 0.005), wandering(options), options);
  seen.gauge = HandSet{0, truth.cameras[0].cam_from_world};
  const Result<Calibration> solved = calibrate(seen);
  ASSERT_THAT(solved, IsOk());
  std::vector<Eigen::Vector3d> volume;
  for (int i = 0; i < 27; ++i)
    volume.push_back({0.3 * (i % 3 - 1), 0.3 * (i / 3 % 3 - 1), 1 + 0.3 * (i / 9 - 1)});
  const ProjectionUncertainty map(*solved, volume);
  for (int c = 0; c < 4; ++c) {
    EXPECT_LT(map.sigma_px(c, {0, 0, 1}), 0.1);
    EXPECT_GT(map.sigma_px(c, {0, 0, 2}), 1.5 * map.sigma_px(c, {0, 0, 1}));
  }
  EXPECT_TRUE(std::isinf(map.sigma_px(0, {10, 0, 1}))) << "behind the camera";
  // Taking out the motion that no picture shows can only reduce what is left over the volume.
  const ProjectionUncertainty in_reference(*solved, {});
  double relative = 0, absolute = 0;
  for (const Eigen::Vector3d& x : volume)
    for (int c = 0; c < 4; ++c) {
      relative += std::pow(map.sigma_px(c, x), 2);
      absolute += std::pow(in_reference.sigma_px(c, x), 2);
    }
  EXPECT_LT(relative, absolute);
}

}  // namespace
}  // namespace floatstage::calib
