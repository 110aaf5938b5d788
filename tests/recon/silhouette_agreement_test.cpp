#include "recon/silhouette_agreement.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace floatstage::recon {
namespace {

TEST(DeniedShare, LeavesOutWhatOutlinesAreOffBy) {
  Image square(100, 100, 1);
  for (int y = 20; y < 80; ++y) std::fill_n(square.at(20, y), 60, std::uint8_t{255});
  const auto shifted = [&](int by) {
    Image moved(100, 100, 1);
    for (int y = 20; y < 80; ++y) std::fill_n(moved.at(20 + by, y), 60, std::uint8_t{255});
    return make_matte({}, moved);
  };
  const Matte matte = make_matte({}, square);
  EXPECT_EQ(denied_share(matte, shifted(0)), 0);
  EXPECT_EQ(denied_share(matte, shifted(2)), 0);
  EXPECT_NEAR(denied_share(matte, shifted(8)), 0.1, 1e-9);
  EXPECT_EQ(denied_share(matte, make_matte({}, Image(100, 100, 1))), 1);
}

TEST(DeniedPieces, AreThickWhereOutlinesThatAreOffLeaveStrips) {
  Image square(100, 100, 1), most = square;
  for (int y = 20; y < 80; ++y) std::fill_n(square.at(20, y), 60, std::uint8_t{255});
  const Matte matte = make_matte({}, square);
  for (int y = 20; y < 80; ++y) std::fill_n(most.at(24, y), 52, std::uint8_t{255});  // 2 px beyond the slack
  EXPECT_GT(denied_share(matte, make_matte({}, most)), 0.06);
  EXPECT_EQ(denied_pieces(matte, make_matte({}, most)), 0);
  most = square;
  for (int y = 40; y < 60; ++y) std::fill_n(most.at(20, y), 60, std::uint8_t{0});  // a belt
  EXPECT_NEAR(denied_pieces(matte, make_matte({}, most)), 16 * 60 / 3600.0, 1e-9);
  EXPECT_EQ(denied_pieces(matte, make_matte({}, Image(100, 100, 1))), 1);
  EXPECT_EQ(denied_pieces(make_matte({}, Image(100, 100, 1)), matte), 0);
}

}  // namespace
}  // namespace floatstage::recon
