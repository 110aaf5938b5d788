#include "calib/drift.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "core/random.h"
#include "tests/support/board_picture.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

const CameraModel kCamera = test::simple_camera(320, 240, 56, BrownConrady{.k1 = -0.1});

// A cluttered wall at infinity: smooth noise of several sizes by direction.
double wall(const Eigen::Vector3d& ray) {
  double grey = 0;
  for (const double size : {14.0, 40.0}) {
    const double x = size * ray.x() / ray.z() + 500, y = size * ray.y() / ray.z() + 500;
    const double u = std::floor(x), v = std::floor(y), a = x - u, b = y - v;
    auto node = [&](double i, double j) {
      return static_cast<double>(mix(static_cast<std::uint64_t>(i) * 7919 +
                                     static_cast<std::uint64_t>(j) * 104729 +
                                     static_cast<std::uint64_t>(size)) %
                                 1000) /
             1000;
    };
    auto ease = [](double t) { return t * t * (3 - 2 * t); };
    grey += (1 - ease(b)) * ((1 - ease(a)) * node(u, v) + ease(a) * node(u + 1, v)) +
            ease(b) * ((1 - ease(a)) * node(u, v + 1) + ease(a) * node(u + 1, v + 1));
  }
  return 40 + 85 * grey;
}

// The empty stage as the camera sees it when it is turned by these degrees about its axes.
Image empty_stage(const Eigen::Vector3d& degrees) {
  const Eigen::Vector3d turn = degrees * std::numbers::pi / 180;
  const Eigen::Matrix3d r = turn.norm() > 0
                                ? Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix()
                                : Eigen::Matrix3d::Identity();
  Image image(kCamera.width, kCamera.height, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      *image.at(x, y) = static_cast<std::uint8_t>(
          std::lround(wall(r.transpose() * *unproject(kCamera, {x + 0.5, y + 0.5}))));
  return image;
}

// What a take adds: a performer of a sixth of the picture who dances before the wall, lamps that flicker,
// noise.
Image with_performer(const Image& stage, double time, Random& random) {
  Image image = stage;
  const double center = 160 + 90 * std::sin(0.7 * time), light = 1 + 0.05 * std::sin(3 * time);
  for (int y = 0; y < image.height; ++y) {
    const std::uint64_t row = random.next();
    for (int x = 0; x < image.width; ++x) {
      double grey = light * *image.at(x, y);
      const double dx = (x - center) / 30, dy = (y - 140.0) / 90;
      if (dx * dx + dy * dy < 1) grey = 60 + 100 * std::abs(std::sin(0.3 * x + 0.2 * y + 5 * time));
      const std::uint64_t bits =
          mix(row + static_cast<std::uint64_t>(x));  // the sum of four bytes: nearly normal
      grey +=
          (static_cast<double>((bits & 255) + (bits >> 8 & 255) + (bits >> 16 & 255) + (bits >> 24 & 255)) -
           510) /
          148 * 2;
      *image.at(x, y) = static_cast<std::uint8_t>(std::clamp(std::lround(grey), 0L, 255L));
    }
  }
  return image;
}

Rig one_camera() {
  Rig rig;
  rig.cameras.push_back({.serial = "left", .model = kCamera, .cam_from_world = {}, .color = {}});
  return rig;
}

DriftWatch watch_of(const Image& stage) {
  const Result<DriftReference> reference = make_drift_reference(one_camera(), {stage});
  EXPECT_THAT(reference, IsOk());
  EXPECT_GE(reference->patches[0].size(), 30u);
  Result<DriftWatch> watch = DriftWatch::create(one_camera(), *reference);
  EXPECT_THAT(watch, IsOk());
  return *std::move(watch);
}

TEST(MeasureTurn, TellsAngleAndAxis) {
  const Image stage = empty_stage({0, 0, 0});
  const Result<DriftReference> reference = make_drift_reference(one_camera(), {stage});
  for (const Eigen::Vector3d& degrees : {Eigen::Vector3d(0, 0.2, 0), Eigen::Vector3d(0.3, -0.1, 0),
                                         Eigen::Vector3d(0, 0, 0.5), Eigen::Vector3d(0, 1, 0)}) {
    const CameraTurn turn = measure_turn(kCamera, reference->patches[0], empty_stage(degrees));
    EXPECT_TRUE(turn.known);
    EXPECT_LT((turn.axis_degrees - degrees).norm(), 0.02)
        << degrees.transpose() << " measured " << turn.axis_degrees.transpose();
    EXPECT_LT(turn.residual_px, 0.3);
  }
}

TEST(MeasureTurn, KnowsNothingInTheDarkAndBehindACurtain) {
  const Result<DriftReference> reference = make_drift_reference(one_camera(), {empty_stage({0, 0, 0})});
  EXPECT_FALSE(measure_turn(kCamera, reference->patches[0], Image(320, 240, 1, 3)).known);
  EXPECT_FALSE(measure_turn(kCamera, reference->patches[0], empty_stage({0, 40, 0})).known);
  EXPECT_FALSE(measure_turn(kCamera, reference->patches[0], Image(64, 48, 1, 3)).known);
}

TEST(DriftWatch, FindsAFifthOfADegreeOfYawWithinFiveSeconds) {
  const Image before = empty_stage({0, 0, 0}), after = empty_stage({0, 0.2, 0});
  DriftWatch watch = watch_of(before);
  Random random(1);
  std::optional<DriftAlarm> alarm;
  constexpr double kKicked = 61;
  for (double time = 0; time < 90 && !alarm; time += 2)
    alarm = watch.check(0, time, with_performer(time < kKicked ? before : after, time, random));
  ASSERT_TRUE(alarm);
  EXPECT_GE(alarm->time, kKicked);
  EXPECT_LE(alarm->time, kKicked + 5);
  EXPECT_EQ(alarm->serial, "left");
  EXPECT_NEAR(alarm->degrees, 0.2, 0.04);
  EXPECT_THAT(alarm->sentence, testing::HasSubstr("camera 'left' has turned by 0."));
}

TEST(DriftWatch, GivesNoFalseAlarmInAnHour) {
  const Image stage = empty_stage({0, 0, 0});
  DriftWatch watch = watch_of(stage);
  Random random(2);
  int known = 0;
  double largest = 0;
  for (double time = 0; time < 3600; time += 2) {
    const auto alarm = watch.check(0, time, with_performer(stage, time, random));
    ASSERT_FALSE(alarm) << alarm->sentence << " at " << time << " s";
    known += watch.turns()[0].known;
    largest = std::max(largest, watch.turns()[0].degrees);
  }
  EXPECT_GE(known, 1750) << "of 1800 checks: it was not silent because it was blind";
  EXPECT_LT(largest, 0.1);
}

TEST(DriftWatch, GivesOneAlarmUntilTheCameraIsBack) {
  const Image before = empty_stage({0, 0, 0}), after = empty_stage({0.3, 0, 0});
  DriftWatch watch = watch_of(before);
  int alarms = 0;
  for (int i = 0; i < 10; ++i) alarms += watch.check(0, i, after).has_value();
  EXPECT_EQ(alarms, 1);
  EXPECT_FALSE(watch.check(0, 10, before));
  for (int i = 11; i < 20; ++i) alarms += watch.check(0, i, after).has_value();
  EXPECT_EQ(alarms, 2);
}

// The wall four metres off and two screens before it, half as far.
Image deep_stage(const Eigen::Vector3d& eye, double yaw_degrees) {
  const Eigen::Matrix3d world_from_camera =
      Eigen::AngleAxisd(-yaw_degrees * std::numbers::pi / 180, Eigen::Vector3d::UnitY()).toRotationMatrix();
  Image image(kCamera.width, kCamera.height, 1);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Eigen::Vector3d ray = world_from_camera * *unproject(kCamera, {x + 0.5, y + 0.5});
      const Eigen::Vector3d near = eye + ray * ((2 - eye.z()) / ray.z()),
                            far = eye + ray * ((4 - eye.z()) / ray.z());
      const bool screen = std::abs(std::abs(near.x()) - 0.55) < 0.3;
      *image.at(x, y) = static_cast<std::uint8_t>(
          std::lround(screen ? wall(near / 2 + Eigen::Vector3d(7, 3, 0)) : wall(far / 4)));
    }
  return image;
}

TEST(DriftWatch, TellsAMoveFromATurn) {
  const Image before = deep_stage({0, 0, 0}, 0);
  DriftWatch watch = watch_of(before);
  Random random(6);
  std::optional<DriftAlarm> alarm;
  for (int i = 0; i < 3 && !alarm; ++i)
    alarm = watch.check(0, i, with_performer(deep_stage({0.03, 0, 0}, 0), i, random));
  ASSERT_TRUE(alarm);
  EXPECT_TRUE(alarm->moved);
  EXPECT_GT(alarm->parallax_px, 1);
  EXPECT_THAT(alarm->sentence, testing::HasSubstr("camera 'left' has moved"));
  EXPECT_LT(watch.turns()[0].epipolar_px, 0.3 * watch.turns()[0].parallax_px);

  DriftWatch other = watch_of(before);
  alarm.reset();
  for (int i = 0; i < 3 && !alarm; ++i)
    alarm = other.check(0, i, with_performer(deep_stage({0, 0, 0}, 0.3), i, random));
  ASSERT_TRUE(alarm);
  EXPECT_FALSE(alarm->moved) << alarm->parallax_px;
  EXPECT_NEAR(alarm->degrees, 0.3, 0.05);
  DriftWatch still = watch_of(before);
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(still.check(0, i, with_performer(before, i, random))) << i;
}

TEST(DriftReference, SurvivesItsFileAndEveryDamageToIt) {
  const TempFolder folder;
  const Result<DriftReference> reference = make_drift_reference(one_camera(), {empty_stage({0, 0, 0})}, 8);
  ASSERT_THAT(save_drift_reference(*reference, folder / "drift.json"), IsOk());
  EXPECT_THAT(load_drift_reference(folder / "drift.json"), IsOkAnd(*reference));
  const std::string whole = to_json(*reference);
  const std::size_t end = whole.find_last_of('}');
  for (std::size_t size = 0; size <= end; size += 37)
    EXPECT_FALSE(parse_drift_reference(whole.substr(0, size), "drift.json")) << size;
  std::string hostile = whole;
  hostile.replace(hostile.find("\"grey\": \"") + 9, 2, "zz");
  EXPECT_THAT(parse_drift_reference(hostile, "drift.json"), FailsWith(ErrorCode::BadData, "hexadecimal"));
}

TEST(DriftReference, IsRefusedForAnotherRigOrOtherPictures) {
  const Result<DriftReference> reference = make_drift_reference(one_camera(), {empty_stage({0, 0, 0})});
  Rig other = one_camera();
  other.cameras[0].serial = "right";
  EXPECT_THAT(DriftWatch::create(other, *reference), FailsWith(ErrorCode::InvalidArgument, "other cameras"));
  EXPECT_THAT(make_drift_reference(one_camera(), {Image(64, 48, 1)}),
              FailsWith(ErrorCode::InvalidArgument, "camera 'left'"));
  EXPECT_THAT(make_drift_reference(one_camera(), {}),
              FailsWith(ErrorCode::InvalidArgument, "0 pictures for 1 cameras"));
}

}  // namespace
}  // namespace floatstage::calib
