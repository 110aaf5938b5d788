#include "apps/viewer/live/control_model.h"

#include <mutex>

#include <gmock/gmock.h>

#include "core/text.h"
#include "tests/support/matchers.h"

namespace floatstage::apps {
namespace {

using testing::IsEmpty;

// A node that does what it is told, or refuses.
class Node final : public studio::StudioControl {
 public:
  explicit Node(std::string name) : name_(std::move(name)) {}

  studio::NodeStatus status() const override {
    const std::lock_guard lock(mutex_);
    studio::NodeStatus status;
    status.node = name_;
    if (recording_) status.recording = studio::NodeRecording{*recording_, 1, 25, 0, 0, {}};
    studio::NodeCamera& camera = status.cameras.emplace_back();
    camera.serial = "cam";
    camera.trouble = trouble_;
    return status;
  }
  Result<std::string> start_recording(const std::string& label) override {
    const std::lock_guard lock(mutex_);
    if (refuses_) return fail(ErrorCode::Io, name_ + ": the disk is full");
    recording_ = text(name_, "-", label);
    return *recording_;
  }
  Result<void> stop_recording() override {
    const std::lock_guard lock(mutex_);
    if (!recording_) return fail(ErrorCode::NotFound, "no take is being recorded");
    recording_.reset();
    if (refuses_) return fail(ErrorCode::Io, name_ + ": its last pictures are lost");
    ++takes_;
    return {};
  }
  Result<std::vector<studio::NodeTake>> takes() const override {
    return std::vector<studio::NodeTake>(static_cast<std::size_t>(takes_));
  }

  void refuse(bool refuses) {
    const std::lock_guard lock(mutex_);
    refuses_ = refuses;
  }
  void lose_camera(const std::string& why) {
    const std::lock_guard lock(mutex_);
    trouble_ = why;
  }
  bool records() const { return status().recording.has_value(); }

 private:
  const std::string name_;
  mutable std::mutex mutex_;
  std::optional<std::string> recording_;
  std::string trouble_;
  bool refuses_ = false;
  int takes_ = 0;
};

class AStudioOfTwoNodes : public testing::Test {
 protected:
  Node left_{"left"}, right_{"right"};
  const std::vector<studio::StudioControl*> nodes_{&left_, &right_};
};

TEST_F(AStudioOfTwoNodes, RecordsAndStopsTogether) {
  EXPECT_EQ(*record_all(nodes_, "one"), "left-one, right-one");
  EXPECT_TRUE(left_.records() && right_.records());
  ASSERT_THAT(stop_all(nodes_), IsOk());
  EXPECT_FALSE(left_.records() || right_.records());
}

TEST_F(AStudioOfTwoNodes, RecordsNothingWhereANodeRefuses) {
  right_.refuse(true);
  EXPECT_THAT(record_all(nodes_, "one"), FailsWith(ErrorCode::Io, "right: the disk is full"));
  EXPECT_FALSE(left_.records()) << "half a studio's take is of no use";
}

TEST_F(AStudioOfTwoNodes, StopsTheOthersWhereANodeFails) {
  ASSERT_THAT(record_all(nodes_, "one"), IsOk());
  left_.refuse(true);
  EXPECT_THAT(stop_all(nodes_), FailsWith(ErrorCode::Io, "left: its last pictures"));
  EXPECT_FALSE(right_.records());
}

TEST_F(AStudioOfTwoNodes, StopsWhatRecordsThoughAnotherNodeWasStartedAnew) {
  ASSERT_THAT(right_.start_recording("one"), IsOk());
  EXPECT_THAT(stop_all(nodes_), IsOk());
  EXPECT_THAT(stop_all(nodes_), FailsWith(ErrorCode::NotFound, "no take"));
}

TEST_F(AStudioOfTwoNodes, IsSeenAndCommandedFromTheControlModel) {
  ControlModel model(nodes_);
  model.settle();
  EXPECT_FALSE(model.state().recording());
  model.record("two");
  model.settle();
  ControlModel::State state = model.state();
  EXPECT_TRUE(state.recording());
  EXPECT_FALSE(state.busy || state.failed);
  EXPECT_EQ(state.told, "recording left-two, right-two");
  ASSERT_EQ(state.nodes.size(), 2U);
  EXPECT_EQ(state.nodes[1].recording->take, "right-two");
  right_.lose_camera("unplugged");
  model.stop();
  model.settle();
  state = model.state();
  EXPECT_FALSE(state.recording());
  EXPECT_EQ(state.told, "recorded");
  EXPECT_EQ(state.nodes[1].cameras.at(0).trouble, "unplugged") << "health is as new as the command";
}

TEST_F(AStudioOfTwoNodes, TellsTheOperatorWhyItDoesNotRecord) {
  left_.refuse(true);
  ControlModel model(nodes_);
  model.record("three");
  model.settle();
  EXPECT_TRUE(model.state().failed);
  EXPECT_EQ(model.state().told, "left: the disk is full");
}

TEST_F(AStudioOfTwoNodes, GoesOnRecordingWhenTheControlModelIsClosed) {
  {
    ControlModel model(nodes_);
    model.record("four");
    model.settle();
  }
  EXPECT_TRUE(left_.records() && right_.records());
}

TEST(AControlModelWithoutNodes, HasNothingToAskOrCommand) {
  ControlModel model({});
  model.record("five");
  model.settle();
  EXPECT_TRUE(model.empty());
  EXPECT_THAT(model.state().nodes, IsEmpty());
  EXPECT_FALSE(model.state().busy);
}

}  // namespace
}  // namespace floatstage::apps
