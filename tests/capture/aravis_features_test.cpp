#include <chrono>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/aravis/gige_link.h"
#include "capture/aravis/gobject.h"
#include "capture/frame_source.h"
#include "tests/capture/fake_gige_camera.h"
#include "tests/capture/gige_features.h"
#include "tests/support/matchers.h"
#include "tests/support/own_network.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

class AGigeCameraWithMore : public testing::Test {
 protected:
  static void SetUpTestSuite() { ASSERT_TRUE(enter_own_network()); }

  /// A camera that has these features besides its own.
  std::unique_ptr<FakeGigeCamera> camera_with(const std::string& features) {
    return std::make_unique<FakeGigeCamera>(1, "MORE", 0, described_with(features, folder_));
  }
  static std::unique_ptr<FrameSource> opened(const FakeGigeCamera& camera, const std::string& options) {
    auto source = open_source(camera.uri("format=gray8&width=64&height=48&rate=20&" + options));
    EXPECT_THAT(source, IsOk());
    return std::move(*source);
  }

  TempFolder folder_;
};

TEST_F(AGigeCameraWithMore, IsOnTheNetworksClockWhereItsPtpLocks) {
  const auto camera = camera_with(ptp_features("Latch"));  // so that its status is read after it was latched
  const auto source = opened(*camera, "ptp=on");
  const Result<StreamInfo> info = source->start();
  ASSERT_THAT(info, IsOk());
  EXPECT_TRUE(info->ptp);
  const Result<Frame> frame = source->next(milliseconds(20'000));
  ASSERT_THAT(frame, IsOk());
  ASSERT_TRUE(frame->info.device_time.has_value());
  EXPECT_EQ(frame->info.exposure_start.ns, frame->info.device_time->count)
      << "as the camera says, not fitted";
}

TEST_F(AGigeCameraWithMore, IsSwitchedToPtpBeforeItsStatusIsAsked) {
  const auto camera = camera_with(ptp_features("Enable"));
  EXPECT_THAT(opened(*camera, "ptp=on&ptp-wait=0")->start(), IsOk());
}

TEST_F(AGigeCameraWithMore, IsRefusedWhereItsPtpDoesNotLock) {
  const auto camera = camera_with(ptp_features("Never"));
  EXPECT_THAT(opened(*camera, "ptp=on&ptp-wait=0.3")->start(),
              FailsWith(ErrorCode::Timeout, "(PTP: Listening); check that ptp4l runs"));
  const auto without = opened(*camera, "ptp=off");
  const Result<StreamInfo> info = without->start();
  ASSERT_THAT(info, IsOk());
  EXPECT_FALSE(info->ptp);
}

TEST_F(AGigeCameraWithMore, IsNotWaitedForBySomebodyWhoHasEnough) {
  const auto camera = camera_with(ptp_features("Never"));
  const auto source = opened(*camera, "ptp=on&ptp-wait=600");
  const auto begun = std::chrono::steady_clock::now();
  source->stop_when([&] { return std::chrono::steady_clock::now() - begun > std::chrono::seconds(1); });
  EXPECT_THAT(source->start(), FailsWith(ErrorCode::Cancelled, "interrupted before its clock"));
  EXPECT_LT(std::chrono::steady_clock::now() - begun, std::chrono::seconds(3))
      << "which the camera takes part of";
}

TEST_F(AGigeCameraWithMore, TellsItsTemperature) {
  const auto camera = camera_with("<Float Name=\"DeviceTemperature\"><Value>41.5</Value></Float>");
  const auto source = opened(*camera, "frames=1");
  EXPECT_FALSE(source->health().temperature_c.has_value()) << "not before it is started";
  ASSERT_THAT(source->start(), IsOk());
  EXPECT_EQ(source->health().temperature_c, 41.5);
}

TEST_F(AGigeCameraWithMore, LeavesRoomBetweenItsPacketsForTheOthersOfItsLink) {
  const FakeGigeCamera camera(1, "ONE");
  const auto source = opened(camera, "cameras=4&link-mbit=100&packet=1000");
  ASSERT_THAT(source->start(), IsOk());
  const Result<GigeSchedule> schedule = gige_schedule(
      {.payload_bytes = 64 * 48, .frame_rate = 20, .cameras = 4, .link_mbit = 100, .packet_bytes = 1000});
  ASSERT_THAT(schedule, IsOk());
  const GObjectPtr<ArvCamera> reader(arv_camera_new(camera.address().c_str(), nullptr));
  EXPECT_EQ(arv_camera_gv_get_packet_size(reader.get(), nullptr), 1000u);
  EXPECT_EQ(arv_camera_gv_get_packet_delay(reader.get(), nullptr), schedule->packet_delay.count);
}

double mean_of(const Frame& frame) {
  double sum = 0;
  for (std::size_t i = 0; i < frame.layout.size_bytes; ++i) sum += std::to_integer<int>(frame.pixels[i]);
  return sum / static_cast<double>(frame.layout.size_bytes);
}

double value_of(FrameSource& source, const std::string& name) {
  for (const CameraControl& control : source.controls())
    if (control.name == name) return control.value;
  ADD_FAILURE() << "no control " << name;
  return 0;
}

TEST_F(AGigeCameraWithMore, IsExposedOtherwiseWhileItStreams) {
  const FakeGigeCamera camera(1, "ONE");
  const auto source = opened(camera, "exposure-us=10000");
  EXPECT_TRUE(source->controls().empty()) << "not before it is started";
  EXPECT_THAT(source->set_control("gain", 1), FailsWith(ErrorCode::InvalidArgument, "not started"));
  ASSERT_THAT(source->start(), IsOk());
  const Result<Frame> before = source->next(milliseconds(20'000));
  ASSERT_THAT(before, IsOk());
  ASSERT_THAT(source->set_control("exposure-us", 1000), IsOk());
  EXPECT_EQ(value_of(*source, "exposure-us"), 1000);
  const GObjectPtr<ArvCamera> reader(arv_camera_new(camera.address().c_str(), nullptr));
  EXPECT_EQ(arv_camera_get_exposure_time(reader.get(), nullptr), 1000) << "in the camera's own register";
  // Its ramp grows with the logarithm of the exposure; a picture or two are still of the old one.
  double mean = mean_of(*before);
  for (int i = 0; i < 40 && mean >= mean_of(*before) / 2; ++i) {
    const Result<Frame> frame = source->next(milliseconds(20'000));
    ASSERT_THAT(frame, IsOk());
    EXPECT_EQ(frame->info.exposure, milliseconds(1));
    mean = mean_of(*frame);
  }
  EXPECT_LT(mean, mean_of(*before) / 2);
}

TEST_F(AGigeCameraWithMore, RefusesWhatItCannotBeSetTo) {
  const FakeGigeCamera camera(1, "ONE");
  const auto source = opened(camera, "");
  ASSERT_THAT(source->start(), IsOk());
  const double exposure = value_of(*source, "exposure-us");
  EXPECT_THAT(
      source->set_control("exposure-us", 1e12),
      FailsWith(ErrorCode::InvalidArgument,
                "camera 'ONE': exposure-us = 1000000000000 is out of range; it takes 10 to 10000000"));
  EXPECT_THAT(source->set_control("exposure-us", std::nan("")),
              FailsWith(ErrorCode::InvalidArgument, "is out of range"));
  EXPECT_THAT(
      source->set_control("glow", 1),
      FailsWith(ErrorCode::NotFound, "no control 'glow' that can be set now; it has exposure-us, gain"));
  EXPECT_EQ(value_of(*source, "exposure-us"), exposure);
}

TEST_F(AGigeCameraWithMore, BalancesItsColoursOneByOne) {
  const auto camera = camera_with(white_balance_features());
  const auto source = opened(*camera, "");
  ASSERT_THAT(source->start(), IsOk());
  ASSERT_THAT(source->set_control("white-balance-red", 1.5), IsOk());
  ASSERT_THAT(source->set_control("white-balance-green", 1), IsOk());
  ASSERT_THAT(source->set_control("white-balance-blue", 2.25), IsOk());
  EXPECT_EQ(value_of(*source, "white-balance-red"), 1.5);
  EXPECT_EQ(value_of(*source, "white-balance-green"), 1);
  EXPECT_EQ(value_of(*source, "white-balance-blue"), 2.25);
  EXPECT_THAT(source->set_control("white-balance-red", 9),
              FailsWith(ErrorCode::InvalidArgument, "it takes 0.5 to 4"));
}

}  // namespace
}  // namespace floatstage::capture
