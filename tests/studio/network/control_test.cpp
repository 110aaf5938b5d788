#include <gtest/gtest.h>

#include "studio/messages/status_json.h"
#include "studio/network/control_client.h"
#include "studio/network/control_server.h"
#include "tests/studio/network/scripted_control.h"
#include "tests/support/eventually.h"
#include "tests/support/matchers.h"

namespace floatstage::studio::wire {
namespace {

std::unique_ptr<ControlServer> serve(StudioControl& control, const std::optional<StudioKeys>& keys = {},
                                     const std::string& address = "tcp://127.0.0.1:0") {
  Result<std::unique_ptr<ControlServer>> server = ControlServer::bind(address, keys, control);
  EXPECT_THAT(server, IsOk());
  return std::move(*server);
}

std::unique_ptr<ControlClient> client(const std::string& address, const std::optional<StudioKeys>& keys = {},
                                      Nanoseconds patience = milliseconds(20'000)) {
  Result<std::unique_ptr<ControlClient>> connected = ControlClient::connect(address, keys, patience);
  EXPECT_THAT(connected, IsOk());
  return std::move(*connected);
}

TEST(Control, OfANodeElsewhereIsAsOfOneHere) {
  ScriptedControl node;
  const auto server = serve(node);
  const auto remote = client(server->address());
  EXPECT_EQ(to_json(remote->status()), to_json(node.status()));
  EXPECT_THAT(remote->start_recording("duet"), IsOkAnd(testing::Eq("take-duet")));
  EXPECT_THAT(remote->start_recording("solo"),
              FailsWith(ErrorCode::AlreadyExists, "'take-duet' is being recorded"));
  EXPECT_EQ(remote->status().recording->take, "take-duet");
  EXPECT_THAT(remote->stop_recording(), IsOk());
  EXPECT_THAT(remote->stop_recording(), FailsWith(ErrorCode::NotFound, "nothing is being recorded"));
  const Result<std::vector<NodeTake>> takes = remote->takes();
  ASSERT_THAT(takes, IsOk());
  EXPECT_EQ(to_json(*takes), to_json(*node.takes()));
  EXPECT_EQ(server->counters().requests, 7u);
}

TEST(Control, OfANodeThatIsNotThereSaysSoInTime) {
  const auto remote = client("tcp://127.0.0.1:1", {}, milliseconds(100));
  EXPECT_THAT(remote->takes(), FailsWith(ErrorCode::Timeout, "'tcp://127.0.0.1:1': no answer within 0.1 s"));
  const NodeStatus status = remote->status();
  EXPECT_EQ(status.node, "tcp://127.0.0.1:1");
  ASSERT_EQ(status.complaints.size(), 1u);
  EXPECT_NE(status.complaints[0].find("is the node running"), std::string::npos);
}

TEST(Control, FindsANodeAgainThatWasStartedAgain) {
  ScriptedControl node;
  auto server = serve(node);
  const std::string address = server->address();
  const auto remote = client(address);
  ASSERT_THAT(remote->ask_status(), IsOk());
  server.reset();
  server = serve(node, {}, address);
  EXPECT_THAT(remote->ask_status(), IsOk());
}

TEST(Control, RefusesAndCountsWhoHasOtherKeys) {
  ScriptedControl node;
  const StudioKeys keys = *make_keys(), others = *make_keys();
  const auto server = serve(node, keys);
  EXPECT_THAT(client(server->address(), others, milliseconds(300))->start_recording("theft"),
              FailsWith(ErrorCode::Timeout, "are its keys the same?"));
  EXPECT_TRUE(eventually([&] { return server->counters().refused > 0; }));
  EXPECT_FALSE(node.status().recording);
  EXPECT_THAT(client(server->address(), keys)->start_recording("duet"), IsOk());
}

TEST(Control, IsNotBoundWhereOthersReachItWithoutKeys) {
  ScriptedControl node;
  EXPECT_THAT(ControlServer::bind("tcp://*:0", {}, node),
              FailsWith(ErrorCode::InvalidArgument, "floatstage keys"));
}

}  // namespace
}  // namespace floatstage::studio::wire
