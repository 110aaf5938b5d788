#include "studio/messages/message.h"

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace floatstage::studio::wire {
namespace {

MessageHeader some_header() {
  MessageHeader header;
  header.kind = MessageKind::Tile;
  header.serial = "cam1";
  header.epoch = 41;
  header.instant = {100};
  header.exposed = {-3};
  header.produced = {1'700'000'000'000'000'000};
  header.width = 1024;
  header.height = 768;
  return header;
}

std::string sealed(const MessageHeader& header, std::string_view payload = "payload") {
  const Result<std::string> bytes = seal(header, payload);
  EXPECT_THAT(bytes, IsOk());
  return bytes ? *bytes : "";
}

TEST(WireMessage, ComesBackAsItWasSealed) {
  MessageHeader header = some_header();
  std::string bytes = sealed(header);
  stamp(bytes, 0xfeedu, 99);
  header.session = 0xfeedu;
  header.sequence = 99;
  const Result<Message> message = open(bytes);
  ASSERT_THAT(message, IsOk());
  EXPECT_EQ(message->header, header);
  EXPECT_EQ(message->payload, "payload");
}

TEST(WireMessage, OfAnotherVersionIsNamedAndNotRead) {
  std::string bytes = sealed(some_header());
  bytes[48] = 9;
  EXPECT_THAT(open(bytes), FailsWith(ErrorCode::Unsupported, "of version 9, and this program speaks 3"));
}

TEST(WireMessage, IsNoMessageWhereverItIsCut) {
  const std::string bytes = sealed(some_header());
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_THAT(open(std::string_view(bytes).substr(0, size)), FailsWith(ErrorCode::BadData, "message"))
        << size;
  EXPECT_THAT(open(bytes + "x"), FailsWith(ErrorCode::BadData, "7 bytes were announced and 8 are there"));
}

TEST(WireMessage, RefusesWhatNoHeaderSays) {
  const auto spoiled = [](std::size_t at, char value) {
    std::string bytes = sealed(some_header());
    bytes[at] = value;
    return bytes;
  };
  EXPECT_THAT(open(spoiled(0, 'X')), FailsWith(ErrorCode::BadData, "does not begin as ours do"));
  EXPECT_THAT(open(spoiled(4, 77)), FailsWith(ErrorCode::BadData, "unknown kind 77"));
  EXPECT_THAT(open(spoiled(5, '/')), FailsWith(ErrorCode::BadData, "no serial of a camera"));
  EXPECT_THAT(open(spoiled(47, 'x')), FailsWith(ErrorCode::BadData, "does not end with zeros"));
  EXPECT_THAT(open(spoiled(50, 1)), FailsWith(ErrorCode::BadData, "reserved"));
  EXPECT_THAT(open(spoiled(87, 0x7f)), FailsWith(ErrorCode::BadData, "no clock shows"));
  EXPECT_THAT(open(spoiled(106, 0x7f)), FailsWith(ErrorCode::BadData, "px a side"));
  EXPECT_THAT(open(spoiled(107, static_cast<char>(0x80))), FailsWith(ErrorCode::BadData, "px a side"));
}

TEST(WireMessage, IsNotSealedWhenItCannotTravel) {
  MessageHeader header = some_header();
  header.serial = std::string(kLongestSerial + 1, 'a');
  EXPECT_THAT(seal(header, ""), FailsWith(ErrorCode::InvalidArgument, "give it a shorter one"));
  header.serial.pop_back();
  EXPECT_THAT(seal(header, ""), IsOk());
  header.serial = "../etc";
  EXPECT_THAT(seal(header, ""), FailsWith(ErrorCode::InvalidArgument, "no serial"));
  header = some_header();
  header.width = kLongestSide + 1;
  EXPECT_THAT(seal(header, ""), FailsWith(ErrorCode::InvalidArgument, "8193x768"));
  EXPECT_THAT(seal(some_header(), std::string(kLargestMessage, 'x')),
              FailsWith(ErrorCode::InvalidArgument, "bytes are more than"));
}

}  // namespace
}  // namespace floatstage::studio::wire
