#include "studio/live/view_gatherer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace floatstage::studio {
namespace {

using testing::StartsWith;

constexpr Timestamp at_ms(std::int64_t ms) { return Timestamp{} + milliseconds(ms); }

std::shared_ptr<const CameraView> view(const std::string& serial, Timestamp instant, bool known = true) {
  auto v = std::make_shared<CameraView>();
  v->serial = serial;
  v->instant = v->exposed = instant;
  v->produced = instant + milliseconds(3);
  v->known = known;
  return v;
}

// Two nodes of two cameras.
struct Studio {
  ViewGatherer gatherer{{"a", "b", "c", "d"}, {}};
  void push(const std::string& serials, std::int64_t instant_ms, std::int64_t now_ms) {
    for (char serial : serials) gatherer.push(view({serial}, at_ms(instant_ms)), at_ms(now_ms));
  }
};

TEST(ViewGatherer, PutsAnInstantTogetherWhateverTheOrder) {
  Studio s;
  s.push("db", 1000, 1005);
  s.push("a", 1040, 1045);  // the next instant overtakes on its way
  EXPECT_FALSE(s.gatherer.newest(at_ms(1045)));
  s.push("ca", 1000, 1046);
  const std::optional<GatheredViews> set = s.gatherer.newest(at_ms(1046));
  ASSERT_TRUE(set);
  EXPECT_EQ(set->instant, at_ms(1000));
  EXPECT_EQ(set->first_produced, at_ms(1003));
  for (std::size_t i = 0; i < 4; ++i) {
    ASSERT_TRUE(set->views[i]);
    EXPECT_EQ(set->views[i]->serial, std::string(1, static_cast<char>('a' + i)));
    EXPECT_EQ(set->views[i]->instant, at_ms(1000));
  }
}

TEST(ViewGatherer, TakesNodesWhoseMiddlesDifferALittleForOneInstant) {
  Studio s;
  s.push("ab", 1000, 1010);
  s.push("cd", 1003, 1010);
  EXPECT_TRUE(s.gatherer.newest(at_ms(1010)));
  s.push("ab", 1040, 1050);
  s.push("cd", 1045, 1050);  // clocks that differ more than that are two instants
  EXPECT_FALSE(s.gatherer.newest(at_ms(1050)));
}

TEST(ViewGatherer, WaitsForALateCameraAndThenNoLonger) {
  Studio s;
  s.push("abcd", 960, 970);
  ASSERT_TRUE(s.gatherer.newest(at_ms(970)));
  s.push("abc", 1000, 1010);
  EXPECT_FALSE(s.gatherer.newest(at_ms(1069)));
  const std::optional<GatheredViews> set = s.gatherer.newest(at_ms(1070));
  ASSERT_TRUE(set);
  EXPECT_EQ(set->views[3], nullptr);
  EXPECT_EQ(s.gatherer.counters().incomplete, 1u);
  s.push("d", 1000, 1071);
  EXPECT_EQ(s.gatherer.counters().late, 1u);
  EXPECT_FALSE(s.gatherer.newest(at_ms(5000)));
}

TEST(ViewGatherer, DoesNotWaitForANodeThatIsSilent) {
  Studio s;
  s.push("abcd", 1000, 1010);
  ASSERT_TRUE(s.gatherer.newest(at_ms(1010)));
  s.push("ab", 2000, 2009);
  EXPECT_FALSE(s.gatherer.newest(at_ms(2009))) << "heard 999 ms ago";
  EXPECT_TRUE(s.gatherer.newest(at_ms(2010)));
  s.push("ab", 2040, 2050);
  EXPECT_TRUE(s.gatherer.newest(at_ms(2050))) << "at once";
  s.push("abcd", 2080, 2090);
  EXPECT_TRUE(s.gatherer.newest(at_ms(2090)));
  s.push("ab", 2120, 2130);
  EXPECT_FALSE(s.gatherer.newest(at_ms(2130))) << "the node is back and is waited for again";
}

TEST(ViewGatherer, HandsOutTheNewestAndCountsWhatItOvertakes) {
  Studio s;
  for (std::int64_t instant : {1000, 1040, 1080}) s.push("abcd", instant, 1090);
  s.push("a", 1120, 1125);
  const std::optional<GatheredViews> set = s.gatherer.newest(at_ms(1125));
  ASSERT_TRUE(set);
  EXPECT_EQ(set->instant, at_ms(1080));
  EXPECT_EQ(s.gatherer.counters().overtaken, 2u);
  s.push("bcd", 1120, 1126);
  EXPECT_TRUE(s.gatherer.newest(at_ms(1126)));
}

TEST(ViewGatherer, TakesACameraThatSaysItMissedTheInstantForAnAnswer) {
  Studio s;
  s.push("abc", 1000, 1010);
  s.gatherer.push(view("d", at_ms(1000), false), at_ms(1010));
  const std::optional<GatheredViews> set = s.gatherer.newest(at_ms(1010));
  ASSERT_TRUE(set);
  EXPECT_FALSE(set->views[3]->known);
  EXPECT_EQ(s.gatherer.counters().incomplete, 0u);
}

TEST(ViewGatherer, CountsStrangersAndKeepsNothingOfThem) {
  Studio s;
  s.push("abcx", 1000, 1010);
  EXPECT_EQ(s.gatherer.counters().unknown_cameras, 1u);
  s.push("d", 1000, 1011);
  ASSERT_TRUE(s.gatherer.newest(at_ms(1011)));
}

TEST(ViewGatherer, DoesNotFillTheMemoryWithInstantsOfAWildClock) {
  Studio s;
  s.push("bcd", 1000, 1001);
  for (int i = 0; i < 1000; ++i) s.push("a", 1000 - i * 9, 1002);
  EXPECT_GE(s.gatherer.counters().overtaken, 900u);
}

TEST(ViewGatherer, LeavesOutANodeWhoseClockIsWrongByHours) {
  Studio s;
  s.push("abcd", 1000, 1010);
  ASSERT_TRUE(s.gatherer.newest(at_ms(1010)));
  for (std::int64_t time = 1200; time <= 2200; time += 200) {
    s.push("cd", time + 7'200'000, time + 10);
    s.push("ab", time, time + 10);
    const std::optional<GatheredViews> set = s.gatherer.newest(at_ms(time + 70));
    ASSERT_TRUE(set);
    EXPECT_EQ(set->instant, at_ms(time));
  }
  EXPECT_EQ(s.gatherer.counters().off_clock, 12u);
  EXPECT_EQ(s.gatherer.counters().late, 0u);
  EXPECT_THAT(s.gatherer.remark(), StartsWith("c, d: 71999"));
  s.push("abcd", 2400, 2410);
  const std::optional<GatheredViews> set = s.gatherer.newest(at_ms(2410));
  ASSERT_TRUE(set);
  EXPECT_TRUE(set->views[3]);
  EXPECT_EQ(s.gatherer.remark(), "");
}

TEST(ViewGatherer, SaysWhoseClockIsOffAndByHowMuch) {
  Studio s;
  const auto instant = [&](std::int64_t time) {
    s.push("ab", time, time + 5);
    s.push("cd", time + 20, time + 25);
    EXPECT_TRUE(s.gatherer.newest(at_ms(time + 65)));
    EXPECT_TRUE(s.gatherer.newest(at_ms(time + 85)));
  };
  for (std::int64_t time = 1000; time < 1800; time += 200) {
    instant(time);
    EXPECT_EQ(s.gatherer.remark(), "") << "not sure yet";
  }
  instant(1800);
  EXPECT_THAT(s.gatherer.remark(), StartsWith("c, d: 20 ms after the other cameras"));
  s.push("abcd", 2000, 2005);
  ASSERT_TRUE(s.gatherer.newest(at_ms(2005)));
  EXPECT_EQ(s.gatherer.remark(), "");
}

}  // namespace
}  // namespace floatstage::studio
