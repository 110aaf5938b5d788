#include <atomic>

#include <gtest/gtest.h>

#include "calib/detect.h"
#include "tests/calib/detections.h"
#include "tests/support/board_picture.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

const CameraModel kCamera = test::simple_camera(640, 480, 60);

class DetectAll : public testing::Test {
 protected:
  DetectAll() {
    for (int i = 0; i < 6; ++i)
      images_.push_back(test::board_picture(
          design_, kCamera, test::before_camera(design_, i == 4 ? 30 : 0.8, {5.0 * i, 10, 0})));
    for (std::size_t i = 0; i < images_.size(); ++i)
      pictures_.push_back({text("picture ", i), text("key ", i),
                           [this, i]() -> Result<Image> { return ++loads_, images_[i]; }});
  }

  const TargetDesign design_ = target("charuco columns=5 rows=4 square=60mm marker=45mm dictionary=4x4_50");
  std::vector<Image> images_;
  std::vector<PictureToDetect> pictures_;
  std::atomic<int> loads_ = 0;
};

TEST_F(DetectAll, FindsTheSameOnAnyNumberOfThreads) {
  const std::vector<Detection> one = detect_all(design_, pictures_, {.threads = 1});
  EXPECT_EQ(detect_all(design_, pictures_, {.threads = 4}), one);
  EXPECT_EQ(std::count_if(one.begin(), one.end(),
                          [](const Detection& d) { return d.failure == DetectionFailure::None; }),
            5);
}

TEST_F(DetectAll, TakesWhatItKnowsFromTheCache) {
  const TempFolder folder;
  const DetectAllOptions options{.cache = folder / "cache"};
  const std::vector<Detection> first = detect_all(design_, pictures_, options);
  EXPECT_EQ(loads_, 6);
  EXPECT_EQ(detect_all(design_, pictures_, options), first);
  EXPECT_EQ(loads_, 6) << "nothing was loaded again";
  detect_all(target("charuco columns=5 rows=4 square=61mm marker=45mm dictionary=4x4_50"), pictures_,
             options);
  EXPECT_EQ(loads_, 12) << "another target is another search";
}

TEST_F(DetectAll, SearchesAgainWhereTheCacheIsDamaged) {
  const TempFolder folder;
  const DetectAllOptions options{.cache = folder.path()};
  const std::vector<Detection> first = detect_all(design_, pictures_, options);
  const std::vector<std::string> names = folder.names();
  ASSERT_EQ(names.size(), 6u);
  folder.write(names[0], "floatstage-detection 2\nnone\n\n0 nan 3 0.2\nend\n");
  folder.write(names[1], "");
  EXPECT_EQ(detect_all(design_, pictures_, options), first);
  EXPECT_EQ(loads_, 8);
}

TEST_F(DetectAll, GoesOnWithoutACacheThatCannotBeMade) {
  const TempFolder folder;
  folder.write("file", "");
  EXPECT_EQ(detect_all(design_, pictures_, {.cache = folder / "file"}), detect_all(design_, pictures_, {}));
}

TEST_F(DetectAll, SaysWhichPictureCouldNotBeRead) {
  const TempFolder folder;
  pictures_[2].load = []() -> Result<Image> { return fail(ErrorCode::BadData, "b.jpg: cut off"); };
  const std::vector<Detection> found = detect_all(design_, pictures_, {.cache = folder.path()});
  EXPECT_EQ(found[2].failure, DetectionFailure::Unreadable);
  EXPECT_EQ(found[2].reason, "b.jpg: cut off");
  EXPECT_EQ(folder.names().size(), 5u) << "it is tried again next time";
  EXPECT_EQ(found[3].failure, DetectionFailure::None);
}

TEST(DetectionFile, ComesBackBitByBit) {
  const Detection d{
      {{0, {1.0 / 3, 719.9999999}, 0.2}, {7, {1e-9, 2}, 0.123456789}}, DetectionFailure::None, ""};
  EXPECT_THAT(parse_detection(to_text(d), "d"), IsOkAnd(d));
  const Detection none{{}, DetectionFailure::CutOff, "at the rim"};
  EXPECT_THAT(parse_detection(to_text(none), "d"), IsOkAnd(none));
}

TEST(DetectionFile, RefusesEveryTruncation) {
  const std::string whole =
      to_text(Detection{{{0, {1.5, 2.5}, 0.2}, {7, {3, 4}, 0.2}}, DetectionFailure::None, ""});
  for (std::size_t size = 0; size < whole.size(); ++size)
    EXPECT_FALSE(parse_detection(whole.substr(0, size), "d")) << size;
}

TEST(ContentKey, KnowsAFileByWhatIsInIt) {
  const TempFolder folder;
  const auto a = content_key(folder.write("a", "same")), b = content_key(folder.write("b", "same")),
             c = content_key(folder.write("c", "some"));
  EXPECT_EQ(*a, *b);
  EXPECT_NE(*a, *c);
  EXPECT_THAT(content_key(folder / "none"), FailsWith(ErrorCode::NotFound, "none"));
}

}  // namespace
}  // namespace floatstage::calib
