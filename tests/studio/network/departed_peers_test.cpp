// Peers that go while their messages still wait: libzmq 4.3.4 ends the whole program when a heartbeat is due
// to such a peer.

#include <condition_variable>
#include <mutex>
#include <thread>

#include <gtest/gtest.h>
#include <zmq.hpp>

#include "studio/messages/control_message.h"
#include "studio/network/control_client.h"
#include "studio/network/control_server.h"
#include "studio/network/publisher.h"
#include "studio/network/subscriber.h"
#include "tests/studio/network/scripted_control.h"
#include "tests/support/eventually.h"
#include "tests/support/matchers.h"

namespace floatstage::studio::wire {
namespace {

constexpr auto kSomeHeartbeats = std::chrono::milliseconds(1500);

// Stops until it is told that it may.
class SlowControl : public StudioControl {
 public:
  NodeStatus status() const override { return node_.status(); }
  Result<std::string> start_recording(const std::string& label) override {
    return node_.start_recording(label);
  }
  Result<void> stop_recording() override {
    std::unique_lock lock(mutex_);
    ++asked_;
    changed_.notify_all();
    changed_.wait(lock, [&] { return may_; });
    return {};
  }
  Result<std::vector<NodeTake>> takes() const override { return node_.takes(); }

  bool was_asked() const {
    std::lock_guard lock(mutex_);
    return asked_ > 0;
  }
  void let_go() {
    std::lock_guard lock(mutex_);
    may_ = true;
    changed_.notify_all();
  }

 private:
  ScriptedControl node_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  int asked_ = 0;
  bool may_ = false;
};

// Asks a server so often that its queue is full, and goes.
void ask_and_go(const std::string& address, const SlowControl& control) {
  zmq::context_t context;
  zmq::socket_t impatient{context, zmq::socket_type::dealer};
  impatient.set(zmq::sockopt::linger, 0);
  impatient.set(zmq::sockopt::sndhwm, 0);
  impatient.connect(address);
  const Result<std::string> stop = encode_request({Ask::StopRecording, {}});
  ASSERT_THAT(stop, IsOk());
  for (int i = 0; i < 5'000; ++i) ASSERT_TRUE(impatient.send(zmq::buffer(*stop)));
  ASSERT_TRUE(eventually([&] { return control.was_asked(); }));
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // until what waits fills every queue
}

TEST(DepartedPeers, WhoseOrdersWaitBehindASlowOneDoNotEndANode) {
  SlowControl control;
  Result<std::unique_ptr<ControlServer>> server = ControlServer::bind("tcp://127.0.0.1:0", {}, control);
  ASSERT_THAT(server, IsOk());
  ask_and_go((*server)->address(), control);
  std::this_thread::sleep_for(kSomeHeartbeats);
  control.let_go();
  const Result<std::unique_ptr<ControlClient>> next =
      ControlClient::connect((*server)->address(), {}, milliseconds(20'000));
  ASSERT_THAT(next, IsOk());
  EXPECT_THAT((*next)->takes(), IsOk());
}

TEST(DepartedPeers, WhoAskedForMuchDoNotEndANode) {
  const auto node = std::move(*Publisher::bind({.address = "tcp://127.0.0.1:0"}));
  for (int round = 0; round < 3; ++round) {
    zmq::context_t context;
    zmq::socket_t greedy{context, zmq::socket_type::dealer};
    greedy.set(zmq::sockopt::linger, 0);
    greedy.set(zmq::sockopt::sndhwm, 0);
    greedy.connect(node->address());
    for (int i = 0; i < 50'000; ++i) ASSERT_TRUE(greedy.send(zmq::buffer(text("junk ", i))));
    ASSERT_TRUE(eventually([&] { return node->counters().malformed > 0; }));
  }
  std::this_thread::sleep_for(kSomeHeartbeats);
  const auto viewer = std::move(*Subscriber::connect({{node->address()}, {}, {MessageKind::Status}, 8}));
  EXPECT_TRUE(eventually([&] {
    node->publish(ScriptedControl().status());
    return viewer->next(milliseconds(50)).has_value();
  }));
}

}  // namespace
}  // namespace floatstage::studio::wire
