#include "capture/aravis/gige_link.h"

#include <gtest/gtest.h>

#include "capture/aravis/block_id.h"
#include "tests/support/matchers.h"

namespace floatstage::capture {
namespace {

TEST(GigeLink, CountsEveryByteOnTheWire) {
  const auto s = gige_schedule({.payload_bytes = 640 * 480, .frame_rate = 30, .packet_bytes = 1400});
  ASSERT_THAT(s, IsOk());
  EXPECT_EQ(s->packets, 226u + 2u);         // ceil(307200 / 1364), leader and trailer
  EXPECT_EQ(s->packet_time.count, 11'504);  // 1438 bytes at 1 Gbit/s
  EXPECT_EQ(s->packet_delay.count, 0);
  EXPECT_NEAR(s->link_share, 228 * 11'504e-9 * 30, 1e-6);
}

TEST(GigeLink, LetsEqualCamerasTakeTurnsOnALink) {
  const auto s =
      gige_schedule({.payload_bytes = 640 * 480, .frame_rate = 30, .cameras = 8, .packet_bytes = 9000});
  ASSERT_THAT(s, IsOk());
  EXPECT_EQ(s->packet_delay.count, 7 * s->packet_time.count);
  EXPECT_LT(s->picture_time, milliseconds(33));
  EXPECT_NEAR(s->link_share, 8 * 37 * 9038 * 8e-9 * 30, 1e-6);
}

TEST(GigeLink, RefusesWhatDoesNotFitAndSaysWhatWould) {
  const GigeDemand eight{.payload_bytes = 1024 * 768, .frame_rate = 30, .cameras = 8, .packet_bytes = 1500};
  EXPECT_THAT(gige_schedule(eight),
              FailsWith(ErrorCode::InvalidArgument, "use at most 17.8 pictures a second"));
  GigeDemand slower = eight;
  slower.frame_rate = 17.8;
  EXPECT_THAT(gige_schedule(slower), IsOk());
}

TEST(GigeLink, RefusesWhatCannotBe) {
  EXPECT_THAT(gige_schedule({}), FailsWith(ErrorCode::InvalidArgument, "cannot be"));
  EXPECT_THAT(gige_schedule({.payload_bytes = 1, .frame_rate = 1, .packet_bytes = 36}),
              FailsWith(ErrorCode::InvalidArgument, "packets above 36 bytes"));
}

TEST(BlockId, CountsFromTheFirstPicture) {
  BlockIdUnwrapper ids;
  EXPECT_EQ(ids.unwrap(1678), 0u);
  EXPECT_EQ(ids.unwrap(1679), 1u);
  EXPECT_EQ(ids.unwrap(1685), 7u);
}

TEST(BlockId, ComesRoundFrom65535To1BecauseZeroIsNoPicture) {
  BlockIdUnwrapper ids;
  ids.unwrap(65534);
  EXPECT_EQ(ids.unwrap(65535), 1u);
  EXPECT_EQ(ids.unwrap(1), 2u);
  EXPECT_EQ(ids.unwrap(4), 5u);
}

TEST(BlockId, OfSixtyFourBitsDoesNotComeRound) {
  BlockIdUnwrapper ids;
  ids.unwrap(65535);
  EXPECT_EQ(ids.unwrap(65536), 1u);
  EXPECT_EQ(ids.unwrap(70'000), 4465u);
  EXPECT_FALSE(ids.unwrap(1).has_value()) << "the camera began again";
}

TEST(BlockId, ThatGoesBackIsACameraThatBeganAgain) {
  BlockIdUnwrapper ids;
  ids.unwrap(500);
  EXPECT_FALSE(ids.unwrap(500).has_value());
  EXPECT_FALSE(ids.unwrap(3).has_value());
  EXPECT_EQ(ids.why_not(3), BlockIdUnwrapper::Late::Restarted);
  EXPECT_EQ(ids.unwrap(501), 1u) << "and what was refused changed nothing";
}

TEST(BlockId, ALittleBackIsAPictureThatWasOvertaken) {
  BlockIdUnwrapper ids(4);
  ids.unwrap(65534);
  ids.unwrap(2);
  for (const std::uint64_t id : {1ull, 65535ull}) {
    EXPECT_FALSE(ids.unwrap(id).has_value());
    EXPECT_EQ(ids.why_not(id), BlockIdUnwrapper::Late::Overtaken) << id;
  }
  EXPECT_EQ(ids.unwrap(3), 4u);
}

}  // namespace
}  // namespace floatstage::capture
