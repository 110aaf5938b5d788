#include "studio/messages/watch_message.h"

#include <gtest/gtest.h>

#include "core/text.h"
#include "tests/fuzz/mutations.h"
#include "tests/support/matchers.h"

namespace floatstage::studio::wire {
namespace {

Result<Watch> decoded(std::string_view bytes) {
  const Result<Message> message = open(bytes);
  if (!message) return forward(message);
  return decode_watch(*message);
}

std::string with_payload(std::string_view payload, MessageKind kind = MessageKind::Watch) {
  MessageHeader header;
  header.kind = kind;
  return *seal(header, payload);
}

TEST(WatchMessage, ComesBackAsItWas) {
  for (const Watch& watch :
       {Watch{}, Watch{{MessageKind::Outline, MessageKind::Status}, {}}, Watch{{}, {"cam1", "cam10", "cam2"}},
        Watch{{MessageKind::Tile, MessageKind::Scene}, {std::string(kLongestSerial, 'x')}}}) {
    const Result<std::string> bytes = encode_watch(watch);
    ASSERT_THAT(bytes, IsOk());
    const Result<Watch> again = decoded(*bytes);
    ASSERT_THAT(again, IsOk());
    EXPECT_EQ(*again, watch);
  }
}

TEST(WatchMessage, CoversKindsAndTheTilesThatItNames) {
  const Watch watch{{MessageKind::Outline}, {"cam1"}};
  EXPECT_TRUE(watch.covers(MessageKind::Outline, "any"));
  EXPECT_TRUE(watch.covers(MessageKind::Tile, "cam1"));
  EXPECT_FALSE(watch.covers(MessageKind::Tile, "cam10"));
  EXPECT_FALSE(watch.covers(MessageKind::Scene, ""));
  EXPECT_TRUE((Watch{{MessageKind::Tile}, {}}.covers(MessageKind::Tile, "cam10")));
}

TEST(WatchMessage, HasABound) {
  Watch watch;
  for (std::size_t i = 0; i < kMostWatched; ++i)
    watch.tiles.insert(text(100'000 + i, std::string(kLongestSerial - 6, 'x')));
  const Result<std::string> full = encode_watch(watch);
  ASSERT_THAT(full, IsOk());
  EXPECT_EQ(full->size(), kLongestWatch);
  EXPECT_EQ(*decoded(*full), watch);
  watch.tiles.insert("one");
  EXPECT_THAT(encode_watch(watch), FailsWith(ErrorCode::InvalidArgument, "of 257 cameras; at most 256"));
  std::string more(4, '\0');
  more[2] = more[3] = 1;  // 257 serials
  for (int i = 0; i < 257; ++i) more += text("\x06", 100'000 + i);
  EXPECT_THAT(decoded(with_payload(more)), FailsWith(ErrorCode::BadData, "of 257 cameras; at most 256"));
}

TEST(WatchMessage, RefusesWhatCannotBeWatched) {
  EXPECT_THAT(encode_watch({{MessageKind::Reply}, {}}),
              FailsWith(ErrorCode::InvalidArgument, "nobody is told of a reply"));
  EXPECT_THAT(encode_watch({{}, {"../etc"}}),
              FailsWith(ErrorCode::InvalidArgument, "no serial that travels"));
  EXPECT_THAT(encode_watch({{}, {std::string(kLongestSerial + 1, 'x')}}),
              FailsWith(ErrorCode::InvalidArgument, "no serial that travels"));
}

TEST(WatchMessage, OfOthersIsRefusedWhereItSaysWhatWeDoNotSay) {
  using namespace std::string_literals;
  EXPECT_THAT(decoded(with_payload("\x02\0\0\0"s, MessageKind::Request)),
              FailsWith(ErrorCode::BadData, "another kind"));
  EXPECT_THAT(decoded(with_payload("\x02"s)), FailsWith(ErrorCode::BadData, "does not begin"));
  EXPECT_THAT(decoded(with_payload("\x02\x01\0\0"s)), FailsWith(ErrorCode::BadData, "does not begin"));
  EXPECT_THAT(decoded(with_payload("\x01\0\0\0"s)), FailsWith(ErrorCode::BadData, "nobody is told"));
  EXPECT_THAT(decoded(with_payload("\x20\0\0\0"s)), FailsWith(ErrorCode::BadData, "nobody is told"));
  EXPECT_THAT(decoded(with_payload("\0\0\x02\0\x01"
                                   "a\x09"
                                   "b"s)),
              FailsWith(ErrorCode::BadData, "serial 2 of 2 is none"));
  EXPECT_THAT(decoded(with_payload("\0\0\x02\0\x01"
                                   "b\x01"
                                   "a"s)),
              FailsWith(ErrorCode::BadData, "not in order"));
  EXPECT_THAT(decoded(with_payload("\0\0\x02\0\x01"
                                   "a\x01"
                                   "a"s)),
              FailsWith(ErrorCode::BadData, "not in order"));
  EXPECT_THAT(decoded(with_payload("\x02\0\0\0x"s)), FailsWith(ErrorCode::BadData, "left over"));
}

TEST(WatchMessage, ThatIsDamagedIsRefusedOrSaysTheSameAgain) {
  const std::string seed = *encode_watch({{MessageKind::Outline}, {"cam1", "cam2"}});
  for (std::size_t i = 0; i < mutation_count(seed.size()); ++i) {
    const Result<Watch> watch = decoded(mutated(seed, i));
    if (watch) {
      EXPECT_EQ(*decoded(*encode_watch(*watch)), *watch);
    }
  }
}

}  // namespace
}  // namespace floatstage::studio::wire
