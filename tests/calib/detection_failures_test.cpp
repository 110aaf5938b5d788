#include <gtest/gtest.h>

#include "calib/detect.h"
#include "tests/calib/detections.h"
#include "tests/support/board_picture.h"
#include "tests/support/matchers.h"

namespace floatstage::calib {
namespace {

using test::before_camera;
using test::board_picture;
using test::simple_camera;
using testing::HasSubstr;

const CameraModel kCamera = simple_camera(1280, 720, 60);
constexpr const char* kCharuco = "charuco columns=5 rows=7 square=50mm marker=37.5mm dictionary=4x4_100";
constexpr const char* kChessboard = "chessboard columns=8 rows=5 square=60mm";

struct Mistake {
  const char* shown;
  const char* searched;
  DetectionFailure failure;
  const char* advice;
};

TEST(WhyNothingWasFound, NamesWhatIsWrongInTheDescription) {
  const Mistake mistakes[] = {
      {"charuco columns=5 rows=7 square=50mm marker=37.5mm dictionary=4x4_100 inverted", kCharuco,
       DetectionFailure::InvertedPrint, "add the word 'inverted'"},
      {kCharuco, "charuco columns=5 rows=7 square=50mm marker=37.5mm dictionary=4x4_100 inverted",
       DetectionFailure::InvertedPrint, "leave the word"},
      {kCharuco, "charuco columns=7 rows=5 square=50mm marker=37.5mm dictionary=4x4_100",
       DetectionFailure::SwappedRowsAndColumns, "other way round"},
      {kCharuco, "charuco columns=5 rows=7 square=50mm marker=37.5mm dictionary=5x5_100",
       DetectionFailure::WrongDictionary, "dictionary=4x4_50"},
      {kCharuco, "charuco columns=5 rows=7 square=50mm marker=37.5mm dictionary=apriltag_36h11",
       DetectionFailure::WrongDictionary, "of dictionary 4x4_50"},
      {kCharuco, "charuco columns=5 rows=7 square=50mm marker=37.5mm dictionary=4x4_100 first=60",
       DetectionFailure::OtherNumbers, "another board"},
      {"apriltags columns=4 rows=3 tag=66mm gap=19.8mm", "apriltags columns=3 rows=4 tag=66mm gap=19.8mm",
       DetectionFailure::SwappedRowsAndColumns, "other way round"},
      {kChessboard, "chessboard columns=6 rows=3 square=60mm", DetectionFailure::WrongCount,
       "not inner corners"},
      {kChessboard, "chessboard columns=9 rows=6 square=60mm", DetectionFailure::WrongCount,
       "8 by 5 squares is in the picture"},
  };
  for (const Mistake& m : mistakes) {
    const TargetDesign shown = target(m.shown);
    const Image picture =
        board_picture(shown, kCamera, before_camera(shown, 0.9, {20, 15, 5}), {.blur = 0.7, .noise = 2});
    const Detection found = detect(target(m.searched), picture);
    EXPECT_STREQ(name_of(found.failure), name_of(m.failure)) << m.searched << ": " << found.reason;
    EXPECT_THAT(found.reason, HasSubstr(m.advice)) << m.searched;
    EXPECT_THAT(found.points, testing::IsEmpty());
  }
}

TEST(WhyNothingWasFound, NamesAMirroredPicture) {
  const TargetDesign design = target(kCharuco);
  const Image picture = board_picture(design, kCamera, before_camera(design, 0.9, {20, 15, 5}));
  Image mirrored = picture;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) *mirrored.at(x, y) = *picture.at(picture.width - 1 - x, y);
  EXPECT_EQ(detect(design, mirrored).failure, DetectionFailure::MirroredPrint);
}

TEST(WhyNothingWasFound, NamesBlur) {
  for (const auto& [line, blur] : {std::pair{kCharuco, 9.0}, std::pair{kChessboard, 18.0}}) {
    const TargetDesign design = target(line);
    const Detection found = detect(
        design, board_picture(design, kCamera, before_camera(design, 1.2, {10, 0, 0}), {.blur = blur}));
    EXPECT_STREQ(name_of(found.failure), "blurred") << line << ": " << found.reason;
  }
}

TEST(WhyNothingWasFound, NamesATargetThatIsCutOff) {
  for (const auto& [line, shift] : {std::pair{kCharuco, 0.585}, std::pair{kChessboard, 0.5}}) {
    const TargetDesign design = target(line);
    const Detection found =
        detect(design, board_picture(design, kCamera, before_camera(design, 0.9, {5, 0, 0}, {shift, 0, 0})));
    EXPECT_STREQ(name_of(found.failure), "cut-off") << line << ": " << found.reason;
  }
}

TEST(WhyNothingWasFound, NamesATargetThatIsPartlyHidden) {
  const TargetDesign design = target(kChessboard);
  Image picture = board_picture(design, kCamera, before_camera(design, 0.9));
  for (int y = 250; y < 500; ++y)
    for (int x = 560; x < 700; ++x) *picture.at(x, y) = 120;  // an arm
  const Detection found = detect(design, picture);
  EXPECT_STREQ(name_of(found.failure), "partly-hidden") << found.reason;
}

TEST(WhyNothingWasFound, NamesDarkness) {
  const TargetDesign design = target(kCharuco);
  const Detection found = detect(design, board_picture(design, kCamera, before_camera(design, 0.9),
                                                       {.noise = 1, .paper = 14, .ink = 4, .background = 8}));
  EXPECT_EQ(found.failure, DetectionFailure::TooDark) << found.reason;
}

TEST(WhyNothingWasFound, FindsNothingInNothing) {
  const TargetDesign other = target("wand positions=0mm,100mm,300mm ball=25mm");
  Image noise = board_picture(other, kCamera, before_camera(other, 2.0), {.noise = 25});
  for (const char* line :
       {kCharuco, kChessboard, "apriltags columns=4 rows=3 tag=66mm gap=19.8mm",
        "two-sided columns=5 rows=6 square=50mm marker=37mm dictionary=5x5_100 thickness=5mm"})
    EXPECT_STREQ(name_of(detect(target(line), noise).failure), "nothing-like-it") << line;
  const TargetDesign board = target(kChessboard);
  EXPECT_NE(detect(other, board_picture(board, kCamera, before_camera(board, 0.9))).failure,
            DetectionFailure::None);
  EXPECT_EQ(detect(board, Image(8, 8, 1)).failure, DetectionFailure::Unreadable);
}

TEST(Summary, NamesTheLikelyCause) {
  std::vector<Detection> detections(
      10, Detection{{}, DetectionFailure::SwappedRowsAndColumns, "write it the other way round"});
  detections[3] = {{}, DetectionFailure::Blurred, "focus"};
  EXPECT_EQ(summary(detections),
            "the target was found in 0 of 10 pictures: 1 are blurred, 9 show it with rows and columns "
            "exchanged; likely cause: "
            "write it the other way round");
}

TEST(Summary, DoesNotBlameTheDescriptionForOneMisreadPicture) {
  std::vector<Detection> detections(9, Detection{{SeenPoint{}}, DetectionFailure::None, ""});
  detections.push_back({{}, DetectionFailure::WrongDictionary, "write dictionary=…"});
  EXPECT_THAT(summary(detections), testing::Not(HasSubstr("likely cause")));
}

}  // namespace
}  // namespace floatstage::calib
