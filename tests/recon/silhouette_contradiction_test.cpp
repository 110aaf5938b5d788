#include "recon/silhouette_contradiction.h"

#include <gmock/gmock.h>

namespace floatstage::recon {
namespace {

using Denied = SilhouetteContradiction::Denied;

// A frame of so many cameras, `many` of which are denied these shares.
std::vector<SilhouetteAgreement> checked(int cameras, int many, double surplus, double denied, double pieces,
                                         int frame = 0) {
  std::vector<SilhouetteAgreement> all;
  for (int c = 0; c < cameras; ++c) {
    const bool is = c < many;
    all.push_back(
        {"cam0" + std::to_string(c), frame, 1, is ? surplus : 0.01, is ? denied : 0.01, is ? pieces : 0});
  }
  return all;
}

TEST(SilhouetteContradiction, IsATwentiethOfTheSubjectInHalfOfTheCameras) {
  EXPECT_FALSE(contradiction_between(checked(6, 2, 0.4, 0.4, 0)));
  EXPECT_FALSE(contradiction_between(checked(6, 6, 0.05, 0.04, 0)));
  EXPECT_FALSE(contradiction_between(checked(2, 1, 0.4, 0.4, 0))) << "one accuses nobody";
  const auto found = contradiction_between(checked(6, 3, 0.08, 0.07, 0));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->what, Denied::Twentieth);
  EXPECT_THAT(found->shares, testing::SizeIs(3));
  EXPECT_THAT(describe(*found, " (a hint)"), testing::HasSubstr("denies 7 % of the subject"));
  EXPECT_THAT(describe(*found, " (a hint)"), testing::HasSubstr("show (a hint), or"));
}

TEST(SilhouetteContradiction, SaysWhatIsWorseAloneAndNamesTheFrameWhereMostAreDenied) {
  std::vector<SilhouetteAgreement> frames = checked(6, 3, 0.6, 0.6, 0.5, 7);
  const std::vector<SilhouetteAgreement> more = checked(6, 5, 0.7, 0.7, 0.5, 8),
                                         less = checked(6, 6, 0.2, 0.2, 0.2, 9);
  frames.insert(frames.end(), more.begin(), more.end());
  frames.insert(frames.end(), less.begin(), less.end());
  const auto found = contradiction_between(frames);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->what, Denied::Most);
  EXPECT_EQ(found->frames, 2);
  EXPECT_EQ(found->worst, 8);
  EXPECT_THAT(found->shares, testing::SizeIs(5));
}

TEST(SilhouetteContradiction, OfFewCamerasIsToldBySmallerPieces) {
  EXPECT_FALSE(contradiction_between(checked(8, 8, 0.02, 0.02, 0.02)));
  const auto found = contradiction_between(checked(5, 5, 0.02, 0.02, 0.02));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->what, Denied::Pieces);
}

}  // namespace
}  // namespace floatstage::recon
