// What happens to a studio of several machines when one of them, a cable or a clock fails. Each test is a
// program of its own: it moves to the viewer's machine.

#include "tests/studio/machines/studio_faults.h"

namespace floatstage::studio {
namespace {

using testing::HasSubstr;

TEST_F(StudioFaults, ANodeThatIsKilledIsMissedAndComesBackByItself) {
  const std::filesystem::path cut = record(kRight), whole = record(kLeft);
  right_->kill();
  right_->wait();
  EXPECT_TRUE(sees(3, 5)) << "the other node's cameras go on";
  const std::uint64_t before = recorded(kLeft);
  EXPECT_TRUE(eventually([&] { return recorded(kLeft) > before; }, kPatience)) << "and are recorded";
  right_ = studio_.start_node(kRight);
  EXPECT_TRUE(sees(6)) << logs();
  EXPECT_THAT(control(kLeft).stop_recording(), IsOk());
  expect_no_silent_loss(whole, true);
  expect_no_silent_loss(cut, false);
  EXPECT_TRUE(left_->running());
  EXPECT_TRUE(recon_->running());
}

TEST_F(StudioFaults, ALinkThatIsCutForFiveSecondsHealsByItselfAndNoRecordedFrameIsLost) {
  const std::filesystem::path take = record(kRight);
  const Timestamp cut = now();
  studio_.lab->cut(kRight);
  EXPECT_TRUE(sees(3, 5));
  while (now() - cut < milliseconds(5000)) scenes_->newest(cut + milliseconds(5000));
  studio_.lab->mend(kRight);
  EXPECT_TRUE(sees(6)) << logs();
  EXPECT_THAT(control(kRight).stop_recording(), IsOk());
  expect_no_silent_loss(take, true);
  const Result<std::unique_ptr<capture::TakeReader>> reader = capture::TakeReader::open(take);
  ASSERT_THAT(reader, IsOk());
  const std::vector<FrameRow>& rows = (*reader)->rows(0);
  EXPECT_GT(rows.back().info.exposure_start - rows.front().info.exposure_start, milliseconds(5000))
      << "the cut is in the middle of it";
}

TEST_F(StudioFaults, AReconstructionThatIsKilledComesBackByItself) {
  recon_->kill();
  recon_->wait();
  EXPECT_TRUE(eventually(
      [&] {
        scenes_->newest(now() + milliseconds(100));
        return scenes_->remark().find("no scene comes from") != std::string::npos;
      },
      kPatience));
  recon_ = studio_.start_recon();
  EXPECT_TRUE(sees(6)) << logs();
  EXPECT_EQ(scenes_->remark(), "");
}

TEST_F(StudioFaults, AViewersCableThatIsCutLeavesTheRestOfTheStudioAtWork) {
  studio_.lab->cut(kView);
  while (scenes_->newest(now() + milliseconds(1000))) {
  }
  studio_.lab->mend(kView);
  EXPECT_TRUE(sees(6)) << logs();
  EXPECT_GT(end(*recon_, "recon")["scenes"], 0);
}

TEST_F(StudioFaults, ANodeWhoseClockIsTwentyMillisecondsOffIsNamedUntilItAgrees) {
  right_->terminate();
  EXPECT_EQ(right_->wait(), 0);
  right_ = studio_.start_node(kRight, 20);
  EXPECT_TRUE(eventually(
      [&] {
        scenes_->newest(now() + milliseconds(20));
        return recon_->output().find("cam01, cam03, cam05: 20 ms after the other cameras") !=
               std::string::npos;
      },
      kPatience))
      << logs();
  EXPECT_TRUE(sees(3, 5)) << "the others' instants are shown without it";
  right_->terminate();
  EXPECT_EQ(right_->wait(), 0);
  right_ = studio_.start_node(kRight);
  EXPECT_TRUE(sees(6)) << logs();
}

TEST_F(StudioFaults, NodesAnswerTheirControlOverTheNetwork) {
  const Result<NodeStatus> status = control(kRight).ask_status();
  ASSERT_THAT(status, IsOk());
  EXPECT_EQ(status->node, "node1");
  ASSERT_EQ(status->cameras.size(), 3u);
  EXPECT_EQ(status->cameras[0].serial, "cam01");
  const std::filesystem::path take = record(kRight);
  EXPECT_THAT(control(kRight).stop_recording(), IsOk());
  const Result<std::vector<NodeTake>> takes = control(kRight).takes();
  ASSERT_THAT(takes, IsOk());
  ASSERT_EQ(takes->size(), 1u);
  EXPECT_TRUE(takes->at(0).complete);
  EXPECT_THAT(takes->at(0).name, HasSubstr("fault"));
  expect_no_silent_loss(take, true);
  EXPECT_TRUE(sees(6)) << "the view went on";
}

}  // namespace
}  // namespace floatstage::studio
