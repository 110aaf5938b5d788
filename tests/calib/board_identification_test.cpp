#include "calib/board_identification.h"

#include <gtest/gtest.h>

#include "tests/support/board_picture.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

// Three pictures of a board, near, tilted and turned.
std::vector<Image> pictures_of(const char* words) {
  const Result<TargetDesign> design = parse_target(words);
  EXPECT_THAT(design, IsOk());
  const CameraModel camera = test::simple_camera(640, 480, 50);
  std::vector<Image> out;
  for (const Eigen::Vector3d& turn : {Eigen::Vector3d(0, 0, 0), {25, 10, 5}, {-15, 30, -20}})
    out.push_back(
        test::board_picture(*design, camera, test::before_camera(*design, 0.45, turn), {.noise = 2}));
  return out;
}

void expect_told(const char* words, double square) {
  const auto board = identify_board(pictures_of(words), square);
  ASSERT_TRUE(board) << words;
  EXPECT_EQ(to_text(board->design), words) << board->how;
  EXPECT_EQ(board->pictures, 3);
}

TEST(IdentifyBoard, TellsACharucoBoardWithItsSmallestDictionary) {
  expect_told("charuco columns=5 rows=7 square=30mm marker=22.5mm dictionary=5x5_50", 0.03);
  expect_told("charuco columns=6 rows=4 square=30mm marker=21mm dictionary=4x4_50", 0.03);
}

TEST(IdentifyBoard, TellsAnInvertedPrint) {
  expect_told("charuco columns=4 rows=5 square=40mm marker=30mm dictionary=4x4_50 inverted", 0.04);
}

TEST(IdentifyBoard, TellsAChessboardByItsCrossings) {
  expect_told("chessboard columns=5 rows=8 square=25mm", 0.025);
}

TEST(IdentifyBoard, SeesNoneInNoise) {
  Image noise(320, 240, 1);
  unsigned state = 1;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x)
      *noise.at(x, y) = static_cast<std::uint8_t>((state = state * 1664525U + 1013904223U) >> 24);
  EXPECT_FALSE(identify_board(std::vector<Image>{noise, noise}, 0.03));
}

}  // namespace
}  // namespace floatstage::calib
