#include "calib/board.h"

#include <gtest/gtest.h>

#include "calib/target_sheet.h"
#include "tests/calib/detections.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const char* const kLines[] = {
    "chessboard columns=8 rows=5 square=30mm",
    "charuco columns=4 rows=5 square=54mm marker=40.5mm dictionary=4x4_1000 inverted",
    "charuco columns=6 rows=4 square=25.4mm marker=19mm dictionary=6x6_250 first=7 white-first",
    "apriltags columns=6 rows=5 tag=88mm gap=26.4mm dictionary=apriltag_36h11 first=3 border=2",
    "two-sided columns=5 rows=6 square=40mm marker=30mm dictionary=5x5_100 thickness=4.8mm back-first=15",
    "wand positions=0mm,150mm,450mm ball=25mm",
    "wand positions=0mm,500mm tag=80mm dictionary=apriltag_36h11 first=2",
};

TEST(TargetLine, IsWrittenAsItWasRead) {
  for (const char* line : kLines) EXPECT_EQ(to_text(target(line)), line);
}

TEST(TargetLine, KeepsEveryBitOfALength) {
  for (const double square : {0.1 / 3, 0.0254 * 1.37, 0.030000000000000002}) {
    const Chessboard board{.columns = 7, .rows = 4, .square = square};
    EXPECT_EQ(target(to_text(board)), TargetDesign(board));
  }
}

TEST(TargetLine, UnderstandsUnitsAndOpenCvNames) {
  EXPECT_EQ(target("chessboard columns=8 rows=5 square=3cm"),
            target("chessboard columns=8 rows=5 square=0.03m"));
  EXPECT_DOUBLE_EQ(std::get<Chessboard>(target("chessboard columns=8 rows=5 square=1in")).square, 0.0254);
  EXPECT_EQ(std::get<CharucoBoard>(
                target("charuco columns=4 rows=5 square=54mm marker=40mm dictionary=DICT_4X4_1000"))
                .dictionary,
            "4x4_1000");
}

TEST(TargetLine, NamesTheWordThatIsWrong) {
  const std::pair<const char*, const char*> wrong[] = {
      {"checkers columns=8", "begins with 'checkers'"},
      {"", "begins with ''"},
      {"chessboard columns=8 rows=5 square=30", "'square=30' is no length"},
      {"chessboard columns=8 rows=5 square=nanmm", "is no length"},
      {"chessboard columns=8 rows=5 square=1e999mm", "is no length"},
      {"chessboard columns=8 rows=5", "'square=…' is missing"},
      {"chessboard columns=8.5 rows=5 square=30mm", "'columns=8.5' is no whole number"},
      {"chessboard columns=8 rows=5 square=30mm colour=red", "'colour' is not a word of 'chessboard'"},
      {"chessboard columns=8 columns=9 rows=5 square=30mm", "'columns' is there twice"},
      {"chessboard columns=2 rows=5 square=30mm", "not inner corners"},
      {"chessboard columns=100000 rows=5 square=30mm", "each must be"},
      {"charuco columns=4 rows=5 square=54mm marker=54mm dictionary=4x4_50", "does not fit into a square"},
      {"charuco columns=4 rows=5 square=54mm marker=40mm dictionary=9x9_50",
       "dictionary '9x9_50' is not known"},
      {"charuco columns=40 rows=5 square=54mm marker=40mm dictionary=4x4_50", "take a larger dictionary"},
      {"charuco columns=4 rows=5 square=54mm marker=40mm dictionary=4x4_50 first=-1",
       "10 markers from number -1"},
      {"charuco columns=4 rows=5 square=54mm marker=40mm dictionary=4x4_50 inverted=yes",
       "'inverted' takes no value"},
      {"two-sided columns=4 rows=5 square=54mm marker=40mm dictionary=4x4_50 thickness=4mm back-first=5",
       "share markers"},
      {"wand positions=0mm ball=25mm", "two or three positions"},
      {"wand positions=0mm,20mm,450mm ball=25mm", "must ascend"},
      {"wand positions=0mm,,450mm ball=25mm", "is no length"},
  };
  for (const auto& [line, complaint] : wrong)
    EXPECT_THAT(parse_target(line), FailsWith(ErrorCode::BadData, complaint)) << line;
}

TEST(Ambiguity, IsToldOfTargetsThatLookTheSameFromTwoSides) {
  EXPECT_TRUE(ambiguity(target("chessboard columns=8 rows=6 square=30mm")));
  EXPECT_FALSE(ambiguity(target("chessboard columns=8 rows=5 square=30mm")));
  EXPECT_TRUE(ambiguity(target("wand positions=0mm,500mm ball=25mm")));
  EXPECT_TRUE(ambiguity(target("wand positions=0mm,240mm,500mm ball=25mm")));
  EXPECT_FALSE(ambiguity(target("wand positions=0mm,150mm,450mm ball=25mm")));
  EXPECT_FALSE(ambiguity(target("wand positions=0mm,500mm tag=80mm dictionary=4x4_50")));
}

TEST(TargetPoints, OfAChessboardAreItsInnerCornersFromTheUpperLeft) {
  const auto points = target_points(target("chessboard columns=4 rows=3 square=10mm"));
  ASSERT_EQ(points.size(), 6u);
  EXPECT_TRUE(points[0].isApprox(Eigen::Vector3d(0.01, 0.02, 0)));
  EXPECT_TRUE(points[2].isApprox(Eigen::Vector3d(0.03, 0.02, 0)));
  EXPECT_TRUE(points[3].isApprox(Eigen::Vector3d(0.01, 0.01, 0)));
}

TEST(TargetPoints, OfTheBackLieBehindTheFrontAndRunTheOtherWay) {
  const auto points = target_points(
      target("two-sided columns=3 rows=4 square=10mm marker=7mm dictionary=4x4_50 thickness=5mm"));
  ASSERT_EQ(points.size(), 12u);
  EXPECT_TRUE(points[0].isApprox(Eigen::Vector3d(0.01, 0.03, 0)));
  EXPECT_TRUE(points[6].isApprox(Eigen::Vector3d(0.02, 0.03, -0.005))) << points[6].transpose();
}

TEST(TargetPoints, OfTagsAreTheirCornersFromTheLowerLeft) {
  const auto points = target_points(target("apriltags columns=2 rows=2 tag=80mm gap=20mm"));
  ASSERT_EQ(points.size(), 16u);
  EXPECT_TRUE(points[0].isApprox(Eigen::Vector3d(0.02, 0.02, 0)));
  EXPECT_TRUE(points[2].isApprox(Eigen::Vector3d(0.10, 0.10, 0)));
  EXPECT_TRUE(points[8].isApprox(Eigen::Vector3d(0.02, 0.12, 0)));
}

TEST(MakeTarget, KnowsFacesLatticeAndLengths) {
  const Target board = make_target(
      target("two-sided columns=3 rows=4 square=10mm marker=7mm dictionary=4x4_50 thickness=5mm"), "b");
  EXPECT_EQ(board.kind, TargetKind::Board);
  EXPECT_TRUE(board.points[0].normal.isApprox(Eigen::Vector3d(0, 0, 1)));
  EXPECT_TRUE(board.points[6].normal.isApprox(Eigen::Vector3d(0, 0, -1)));
  EXPECT_EQ(board.points[6].id, 6);
  EXPECT_EQ(
      make_target(target("charuco columns=4 rows=5 square=54mm marker=40mm dictionary=4x4_50"), "c").grid,
      (TargetGrid{3, 4, 0.054}));
  const Target wand = make_target(target("wand positions=0mm,150mm,450mm ball=25mm"), "w", 2e-4);
  EXPECT_EQ(wand.kind, TargetKind::Wand);
  EXPECT_THAT(wand.lengths,
              testing::UnorderedElementsAre(TargetLength{0, 1, 0.15, 2e-4}, TargetLength{0, 2, 0.45, 2e-4},
                                            TargetLength{1, 2, 0.45 - 0.15, 2e-4}));
}

TEST(Print, HoldsItsTarget) {
  const TempFolder folder;
  for (const char* line : kLines) {
    for (const char* name : {"target.svg", "target.pdf"}) {
      const auto files = write_sheets(target(line), folder / name);
      ASSERT_THAT(files, IsOk()) << line;
      for (const auto& file : *files) EXPECT_THAT(load_target(file), IsOkAnd(target(line))) << file;
    }
  }
  EXPECT_THAT(load_target(folder.write("other.svg", "<svg/>")),
              FailsWith(ErrorCode::BadData, "floatstage-target:"));
}

TEST(Print, OfATwoSidedBoardIsTwoDrawingsOrTwoPages) {
  const TempFolder folder;
  EXPECT_THAT(write_sheets(target(kLines[4]), folder / "b.svg"),
              IsOkAnd(ElementsAre(folder / "b-front.svg", folder / "b-back.svg")));
  EXPECT_THAT(write_sheets(target(kLines[4]), folder / "b.pdf"), IsOkAnd(ElementsAre(folder / "b.pdf")));
  EXPECT_THAT(to_pdf(target_sheets(target(kLines[4]))), HasSubstr("/Count 2"));
}

TEST(Print, IsRefusedForWhatIsNoPrint) {
  const TempFolder folder;
  EXPECT_THAT(write_sheets(target(kLines[0]), folder / "b.png"),
              FailsWith(ErrorCode::InvalidArgument, ".pdf or a .svg"));
  EXPECT_THAT(write_sheets(Chessboard{}, folder / "b.pdf"), FailsWith(ErrorCode::InvalidArgument, "columns"));
  EXPECT_THAT(folder.names(), testing::IsEmpty());
}

}  // namespace
}  // namespace floatstage::calib
