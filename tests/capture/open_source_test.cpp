#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/frame_source.h"
#include "capture/take.h"
#include "core/text.h"
#include "tests/capture/pictures.h"
#include "tests/support/fake_source.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

TEST(OpenSource, SaysWhatIsUnderstood) {
  for (const char* uri : {"", "take", "webcam:0", "/dev/video0"})
    EXPECT_THAT(open_source(uri),
                FailsWith(ErrorCode::InvalidArgument, "take:<folder>#<serial> or synthetic:"))
        << uri;
}

TEST(OpenSource, NamesTheCamerasOfATakeWhenOneIsMissing) {
  const TempFolder folder;
  record_small_take(folder / "take", 2, 1);
  const std::string take = "take:" + (folder / "take").string();
  EXPECT_THAT(open_source(take + "#cam7"), FailsWith(ErrorCode::NotFound, "the take has cam0, cam1"));
  EXPECT_THAT(open_source(take), FailsWith(ErrorCode::NotFound, "no camera is named"));
  EXPECT_THAT(open_source("take:" + (folder / "none").string() + "#cam0"),
              FailsWith(ErrorCode::NotFound, "is no take"));
  EXPECT_THAT(open_source("take:#cam0"), FailsWith(ErrorCode::InvalidArgument, "no folder"));
}

TEST(OpenSource, NeedsNoSerialForATakeOfOneCamera) {
  const TempFolder folder;
  record_small_take(folder / "a#b", 1, 1);
  EXPECT_THAT(open_source("take:" + (folder / "a#b").string() + "#cam0"), IsOk());
  record_small_take(folder / "ab", 1, 1);
  EXPECT_THAT(open_source("take:" + (folder / "ab").string()), IsOk());
}

TEST(OpenSource, RefusesSyntheticOptionsThatMakeNoSense) {
  EXPECT_THAT(open_source("synthetic:camera=8"),
              FailsWith(ErrorCode::InvalidArgument, "camera=8 is not a whole number from 0 to 7"));
  EXPECT_THAT(open_source("synthetic:width=1e3"), FailsWith(ErrorCode::InvalidArgument, "width=1e3"));
  EXPECT_THAT(open_source("synthetic:rate=nan"), FailsWith(ErrorCode::InvalidArgument, "rate=nan"));
  EXPECT_THAT(open_source("synthetic:dropped=1"), FailsWith(ErrorCode::InvalidArgument, "dropped=1"));
  EXPECT_THAT(open_source("synthetic:seed=-1"), FailsWith(ErrorCode::InvalidArgument, "seed=-1"));
  EXPECT_THAT(open_source("synthetic:shape=cube"), FailsWith(ErrorCode::InvalidArgument, "shape=cube"));
  EXPECT_THAT(open_source("synthetic:colour=red"),
              FailsWith(ErrorCode::InvalidArgument, "unknown option 'colour'"));
  EXPECT_THAT(open_source("synthetic:frames"),
              FailsWith(ErrorCode::InvalidArgument, "'frames' is not key=value"));
  EXPECT_THAT(open_source("synthetic:seed=1&seed=2"), FailsWith(ErrorCode::InvalidArgument, "given twice"));
}

TEST(OpenSource, LosesTheFramesThatTheSyntheticDefectDrops) {
  auto source = open_source("synthetic:cameras=2&width=8&height=8&samples=1&frames=8&dropped=0.5");
  ASSERT_THAT(source, IsOk());
  ASSERT_THAT((*source)->start(), IsOk());
  while ((*source)->next(milliseconds(1))) {
  }
  const SourceStats stats = (*source)->stats();
  EXPECT_EQ(stats.delivered + stats.lost, 8u);
  EXPECT_GT(stats.lost, 0u);
  EXPECT_GT(stats.delivered, 0u);
}

// What a recorder does with a camera that breaks the contract: refuse the frame, keep the take.
class Misbehaving : public testing::TestWithParam<std::pair<FakeStep, const char*>> {};

TEST_P(Misbehaving, SpoilsNothingThatWasRecorded) {
  const auto [step, complaint] = GetParam();
  const TempFolder folder;
  FakeSource camera({FakeStep::Deliver, FakeStep::Deliver, step, FakeStep::Gap, FakeStep::Deliver});
  ASSERT_THAT(camera.start(), IsOk());
  auto writer = TakeWriter::create(folder / "take", small_rig(1, 16, 12), {});
  ASSERT_THAT(writer, IsOk());
  int written = 0, refused = 0;
  for (Result<Frame> frame = camera.next({}); frame; frame = camera.next({})) {
    const Result<void> ok = (*writer)->write(*frame);
    ok ? ++written : ++refused;
    if (!ok) {
      EXPECT_THAT(ok, FailsWith(ErrorCode::InvalidArgument, complaint));
    }
  }
  EXPECT_GE(refused, 1);
  ASSERT_THAT((*writer)->finish(), IsOk());
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  int there = 0;
  for (int k = 0; k < (*reader)->frame_count(); ++k) there += !(*reader)->frame(0, k)->empty();
  EXPECT_EQ(there, written);
}

INSTANTIATE_TEST_SUITE_P(AllWays, Misbehaving,
                         testing::Values(std::pair{FakeStep::Duplicate, "does not follow"},
                                         std::pair{FakeStep::WrongLayout, "the rig says 16x12"},
                                         std::pair{FakeStep::Wrap, "does not follow"}));

TEST(FakeSource, StaysDisconnectedUntilItIsStartedAgain) {
  FakeSource camera({FakeStep::Deliver, FakeStep::Disconnect, FakeStep::Deliver});
  ASSERT_THAT(camera.start(), IsOk());
  EXPECT_THAT(camera.next({}), IsOk());
  EXPECT_THAT(camera.next({}), FailsWith(ErrorCode::Disconnected, "fake"));
  EXPECT_THAT(camera.next({}), FailsWith(ErrorCode::Disconnected, "fake"));
  camera.stop();
  ASSERT_THAT(camera.start(), IsOk());
  EXPECT_THAT(camera.next({}), IsOk());
}

}  // namespace
}  // namespace floatstage::capture
