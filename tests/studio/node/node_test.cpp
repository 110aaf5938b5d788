#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include "capture/take.h"
#include "studio/node/capture_node.h"
#include "tests/studio/node/studios.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

/// A node that is looked after until something is so; false when it is not within a minute.
bool poll_until(CaptureNode& node, const std::function<bool()>& so) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (!so() && std::chrono::steady_clock::now() < end) {
    node.poll();
    ::poll(nullptr, 0, 20);
  }
  return so();
}

std::unique_ptr<CaptureNode> running(const CaptureConfig& config) {
  Result<std::unique_ptr<CaptureNode>> node = CaptureNode::open(config);
  EXPECT_THAT(node, IsOk());
  (*node)->begin();
  return std::move(*node);
}

std::uint64_t recorded(const CaptureNode& node) {
  std::uint64_t least = UINT64_MAX;
  const std::optional<capture::RecordingQuality> quality = node.quality();
  for (const capture::RecordedCamera& camera : quality->cameras) least = std::min(least, camera.recorded);
  return least;
}

TEST(CaptureNode, RecordsTakeAfterTakeWhileTheCamerasGoOn) {
  const TempFolder folder;
  const auto node = running(live_studio(3, 50, folder.path()));
  ASSERT_TRUE(poll_until(*node, [&] { return node->agreement_seen(); }));
  EXPECT_THAT(node->stop_recording(), FailsWith(ErrorCode::NotFound, "no take"));
  for (int i = 0; i < 2; ++i) {
    const Result<std::string> name = node->start_recording(i == 0 ? "" : "second");
    ASSERT_THAT(name, IsOk());
    EXPECT_THAT(*name, HasSubstr(i == 0 ? "-take" : "-second"));
    EXPECT_THAT(node->start_recording(""), FailsWith(ErrorCode::AlreadyExists, *name));
    ASSERT_TRUE(poll_until(*node, [&] { return recorded(*node) >= 20; }));
    EXPECT_EQ(node->status().recording->take, *name);
    ASSERT_THAT(node->stop_recording(), IsOk());
    EXPECT_FALSE(node->status().recording.has_value());
    const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder / *name);
    ASSERT_THAT(take, IsOk());
    EXPECT_TRUE((*take)->manifest().complete);
    for (int camera = 0; camera < 3; ++camera) {
      EXPECT_EQ((*take)->rows(camera).size(), (*take)->rows(0).size());
      EXPECT_TRUE((*take)->rows(camera).front().media_index) << "it begins with an instant that all saw";
    }
  }
  EXPECT_EQ(node->takes()->size(), 2u);
  EXPECT_THAT(node->start_recording("../escape"), FailsWith(ErrorCode::InvalidArgument, "label"));
}

TEST(CaptureNode, BeginsATakeSecondsBeforeItWasAskedTo) {
  const TempFolder folder;
  CaptureConfig config = live_studio(2, 50, folder.path());
  config.preroll_seconds = 1;
  const auto node = running(config);
  // Two seconds have been seen, so one is there to be had.
  ASSERT_TRUE(poll_until(*node, [&] { return node->status().cameras[1].delivered > 100; }));
  const auto newest = [&] { return node->status().cameras[0].delivered; };
  const std::uint64_t asked = newest();
  const Result<std::string> name = node->start_recording("");
  ASSERT_THAT(name, IsOk());
  ASSERT_TRUE(poll_until(*node, [&] { return recorded(*node) > 60; }));
  const std::uint64_t stopped = newest();
  ASSERT_THAT(node->stop_recording(), IsOk());
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder / *name);
  ASSERT_THAT(take, IsOk());
  EXPECT_GE((*take)->rows(0).size() + 5, stopped - asked + 50) << "with the second before";
  EXPECT_LE((*take)->rows(0).size(), stopped - asked + 200);
}

TEST(CaptureNode, RefusesATakeWhileTheCamerasDisagree) {
  const TempFolder folder;
  CaptureConfig config = live_studio(3, 20, folder.path(), "&late-ms=20");
  config.refuse_disagreement = true;
  const auto node = running(config);
  ASSERT_TRUE(poll_until(*node, [&] { return !node->status().complaints.empty(); }));
  EXPECT_THAT(node->start_recording(""), FailsWith(ErrorCode::InvalidArgument, "camera 'CAM1'"));
  EXPECT_THAT(*node->takes(), IsEmpty());
}

TEST(CaptureNode, EndsATakeBeforeTheDiskIsFullAndRecordsAgainWhenThereIsRoom) {
  const TempFolder folder;
  CaptureConfig config = live_studio(2, 50, folder.path());
  const std::uint64_t room = std::filesystem::space(folder.path()).available;
  if (room < 2'000'000'000) GTEST_SKIP() << "the disk of temporary files is nearly full";
  config.keep_free_bytes = room - 1'000'000;  // 1 MB to go: 50 pictures of each camera
  const auto node = running(config);
  const Result<std::string> name = node->start_recording("");
  if (!name) GTEST_SKIP() << "another program wrote to the disk meanwhile";
  ASSERT_TRUE(poll_until(*node, [&] { return !node->recording(); }));
  EXPECT_THAT(node->status().last_recording, HasSubstr("the disk is full"));
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(folder / *name);
  ASSERT_THAT(take, IsOk());
  EXPECT_TRUE((*take)->manifest().complete) << "there was room to end it well";
  EXPECT_EQ((*take)->rows(0).size(), (*take)->rows(1).size());
  const std::uint64_t seen = node->status().cameras[0].delivered;
  EXPECT_TRUE(poll_until(*node, [&] { return node->status().cameras[0].delivered > seen + 5; }))
      << "the cameras go on";
}

TEST(CaptureNode, RecordsIntoAFolderOfTheWorkingDirectory) {
  const TempFolder folder;
  CaptureConfig config = live_studio(2, 50, folder.path());
  config.keep_free_bytes = 1'000'000;
  const auto node = running(config);
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  const Result<std::string> name = node->record_into("bare", "");
  std::filesystem::current_path(before);
  ASSERT_THAT(name, IsOk());
  EXPECT_TRUE(std::filesystem::exists(folder / "bare"));
}

TEST(CaptureNode, TellsHowItIs) {
  const TempFolder folder;
  const auto node = running(live_studio(2, 50, folder.path()));
  ASSERT_TRUE(poll_until(*node, [&] { return node->status().cameras[1].delivered > 50; }));
  const NodeStatus status = node->status();
  EXPECT_EQ(status.node, "test studio");
  EXPECT_NEAR(status.cameras[1].frame_rate, 50, 10);
  EXPECT_NEAR(*status.cameras[1].bandwidth_mbit, status.cameras[1].frame_rate * 64 * 48 * 3 * 8e-6, 1e-6);
  EXPECT_FALSE(status.cameras[1].temperature_c.has_value()) << "it does not tell";
  EXPECT_GT(status.disk_free_bytes, 0u);
  EXPECT_TRUE(status.disk_minutes.has_value());
  EXPECT_TRUE(node->alive());
}

}  // namespace
}  // namespace floatstage::studio
