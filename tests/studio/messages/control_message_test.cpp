#include "studio/messages/control_message.h"

#include <gtest/gtest.h>

#include "tests/studio/network/scripted_control.h"
#include "tests/support/matchers.h"

namespace floatstage::studio::wire {
namespace {

std::string request_of(const std::string& json) {
  MessageHeader header;
  header.kind = MessageKind::Request;
  return *seal(header, json);
}

Result<ControlRequest> read_request(const std::string& json) {
  const std::string bytes = request_of(json);
  return decode_request(*open(bytes));
}

TEST(ControlMessage, CarriesEveryRequest) {
  for (Ask ask : {Ask::Status, Ask::StartRecording, Ask::StopRecording, Ask::Takes}) {
    const ControlRequest request{ask, ask == Ask::StartRecording ? "duet" : ""};
    const std::string bytes = *encode_request(request);
    EXPECT_THAT(decode_request(*open(bytes)), IsOkAnd(testing::Eq(request)));
  }
}

TEST(ControlMessage, NamesWhatItDoesNotUnderstand) {
  EXPECT_THAT(read_request(R"({"ask": "reboot"})"),
              FailsWith(ErrorCode::BadData, "'reboot' is not understood; there are status, start-recording"));
  EXPECT_THAT(read_request(R"({"ask": "status", "now": true})"), FailsWith(ErrorCode::BadData, "now"));
  EXPECT_THAT(read_request(R"({"label": 3, "ask": "status"})"), FailsWith(ErrorCode::BadData, "label"));
  EXPECT_THAT(read_request("[]"), FailsWith(ErrorCode::BadData, "request"));
  EXPECT_THAT(read_request("{"), FailsWith(ErrorCode::BadData, "request"));
}

TEST(ControlMessage, NestedDeeperThanAnyOfOursIsRefusedUnread) {
  EXPECT_THAT(read_request(std::string(100'000, '[')), FailsWith(ErrorCode::BadData, "deeper"));
  EXPECT_THAT(read_request(R"({"ask": "[[[[[[[[[[[[[[[[[[[[[[[["})"),
              FailsWith(ErrorCode::BadData, "not understood"));
}

TEST(ControlMessage, GivesBackAStatusWithAllItsNumbers) {
  const NodeStatus status = ScriptedControl().status();
  const std::string bytes = *encode_status(status);
  const Result<NodeStatus> again = decode_status(*open(bytes));
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(to_json(*again), to_json(status));
  EXPECT_EQ(again->cameras.at(0).lost, 18'000'000'000'000'000'000u);
  EXPECT_EQ(again->cameras.at(0).temperature_c, 41.5);
  EXPECT_EQ(again->cameras.at(1).temperature_c, std::nullopt);
}

TEST(ControlMessage, GivesBackTheSoundOfATake) {
  ScriptedControl control;
  ASSERT_THAT(answer({Ask::StartRecording, "duet"}, control), IsOk());
  const NodeStatus status = control.status();
  const Result<NodeStatus> again = parse_node_status(to_json(status));
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(to_json(*again), to_json(status));
  ASSERT_EQ(again->recording->sounds.size(), 2u);
  EXPECT_EQ(again->recording->sounds[0].peak, 0.25);
  EXPECT_TRUE(again->recording->sounds[1].ended);
  NodeStatus mute = status;
  mute.recording->sounds.clear();
  EXPECT_EQ(to_json(mute).find("sounds"), std::string::npos) << "programs of before read it";
}

TEST(ControlMessage, LeavesOutWhatADeviceDoesNotTell) {
  NodeStatus status = ScriptedControl().status();
  status.recording.reset();
  status.cameras.resize(1);
  status.cameras[0].temperature_c.reset();
  EXPECT_EQ(to_json(status).find("\"recording\""), std::string::npos);
  EXPECT_EQ(to_json(status).find("temperature"), std::string::npos);
}

TEST(ControlMessage, RefusesAStatusWithAMinus) {
  std::string json = to_json(ScriptedControl().status());
  const std::string bytes = "\"disk_free_bytes\": ";
  json.insert(json.find(bytes) + bytes.size(), "-");
  EXPECT_THAT(parse_node_status(json),
              FailsWith(ErrorCode::BadData, "disk_free_bytes must be a whole number"));
}

TEST(ControlMessage, BringsANodesRefusalBackWithItsCode) {
  ScriptedControl control;
  ASSERT_THAT(answer({Ask::StartRecording, "duet"}, control), IsOkAnd(testing::Eq("take-duet")));
  const ControlReply refused = answer({Ask::StartRecording, "solo"}, control);
  const std::string bytes = *encode_reply(refused);
  EXPECT_THAT(decode_reply(*open(bytes)),
              FailsWith(ErrorCode::AlreadyExists, "'take-duet' is being recorded"));
}

TEST(ControlMessage, BringsAnswersBack) {
  ScriptedControl control;
  const std::string bytes = *encode_reply(answer({Ask::Takes, ""}, control));
  const ControlReply reply = decode_reply(*open(bytes));
  ASSERT_THAT(reply, IsOk());
  const Result<std::vector<NodeTake>> takes = parse_node_takes(*reply);
  ASSERT_THAT(takes, IsOk());
  EXPECT_EQ(to_json(*takes), to_json(*control.takes()));
  EXPECT_THAT(answer({Ask::StopRecording, ""}, control),
              FailsWith(ErrorCode::NotFound, "nothing is being recorded"));
}

TEST(ControlMessage, IsNotReadFromAnotherKind) {
  const std::string bytes = request_of("{}");
  EXPECT_THAT(decode_reply(*open(bytes)),
              FailsWith(ErrorCode::BadData, "a reply was expected, and this is a request"));
  EXPECT_THAT(decode_status(*open(bytes)), FailsWith(ErrorCode::BadData, "no status"));
}

}  // namespace
}  // namespace floatstage::studio::wire
