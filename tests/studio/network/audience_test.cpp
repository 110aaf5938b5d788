#include "studio/network/audience.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/text.h"

namespace floatstage::studio::wire {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr Audience::Clock::time_point kNow{};
constexpr std::chrono::milliseconds kMoment{1};

TEST(Audience, IsToldWhatItAskedFor) {
  Audience audience;
  EXPECT_TRUE(audience.put("recon", {{MessageKind::Outline}, {}}, kNow));
  EXPECT_TRUE(audience.put("view", {{}, {"cam1"}}, kNow));
  EXPECT_THAT(audience.who_wants(MessageKind::Outline, "cam1"), ElementsAre("recon"));
  EXPECT_THAT(audience.who_wants(MessageKind::Tile, "cam1"), ElementsAre("view"));
  EXPECT_THAT(audience.who_wants(MessageKind::Tile, "cam2"), IsEmpty());
  EXPECT_FALSE(audience.wants(MessageKind::Tile, "cam2"));
}

TEST(Audience, HasItsLastWordOnly) {
  Audience audience;
  audience.put("view", {{}, {"cam1"}}, kNow);
  audience.put("view", {{}, {"cam2"}}, kNow);
  EXPECT_FALSE(audience.wants(MessageKind::Tile, "cam1"));
  EXPECT_TRUE(audience.wants(MessageKind::Tile, "cam2"));
  EXPECT_EQ(audience.size(), 1u);
}

TEST(Audience, ForgetsWhoFellSilentAndKeepsWhoSaysItAgain) {
  Audience audience;
  audience.put("gone", {{}, {"cam1"}}, kNow);
  audience.put("there", {{}, {"cam2"}}, kNow);
  audience.put("there", {{}, {"cam2"}}, kNow + kMoment);
  audience.forget_silent(kNow + Audience::kWatchHolds);
  EXPECT_FALSE(audience.wants(MessageKind::Tile, "cam1"));
  EXPECT_TRUE(audience.wants(MessageKind::Tile, "cam2"));
  audience.forget("there");
  EXPECT_EQ(audience.size(), 0u);
}

TEST(Audience, TurnsAwayWhoComesWhenAllSeatsAreTakenButNobodyWhoSits) {
  Audience audience;
  for (std::size_t i = 0; i < Audience::kMostPeers; ++i)
    EXPECT_TRUE(audience.put(text("peer ", i), {{}, {"cam1"}}, kNow));
  EXPECT_FALSE(audience.put("late", {{}, {"cam2"}}, kNow));
  EXPECT_FALSE(audience.wants(MessageKind::Tile, "cam2"));
  EXPECT_TRUE(audience.put("peer 0", {{}, {"cam3"}}, kNow + kMoment));
  EXPECT_TRUE(audience.wants(MessageKind::Tile, "cam3"));
  EXPECT_TRUE(audience.put("late", {{}, {"cam2"}}, kNow + Audience::kWatchHolds)) << "the others were silent";
  EXPECT_EQ(audience.size(), 2u);
}

}  // namespace
}  // namespace floatstage::studio::wire
