// Labels that are followed through a clip from one mask, and what the run says of them.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/matte/matte_clip.h"
#include "pipeline/metrics/matte_metrics.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int kFrames = 8;

MatteClip dancer(std::uint64_t seed) {
  return make_clip(studio_cutout(seed), cluttered_place(240, 160, seed),
                   {.width = 240, .height = 160, .frames = kFrames, .seed = seed});
}

class FollowedLabels : public testing::Test {
 protected:
  void add(const Image& picture) {
    ASSERT_THAT(make_folder(folder_ / "frames"), IsOk());
    ASSERT_THAT(save_png(picture, folder_ / "frames" / text("00", count_++, ".png")), IsOk());
  }
  Result<MatteClipReport> follow(const Image& mask) {
    EXPECT_THAT(save_png(mask, folder_ / "mask.png"), IsOk());
    return matte_clip(
        {.media = folder_ / "frames", .guides = {{"dancer", folder_ / "mask.png"}}, .out = folder_ / "out"});
  }
  TempFolder folder_;
  int count_ = 0;
};

// Two dancers whose mattes hold to the end, and one whose does not.
TEST_F(FollowedLabels, AreDoubtedWhereTheirMattesAreWrongAtTheEnd) {
  for (const std::uint64_t seed : {2, 3, 4}) {
    const MatteClip clip = dancer(seed);
    std::filesystem::remove_all(folder_ / "frames");
    std::filesystem::remove_all(folder_ / "out");
    count_ = 0;
    for (const Image& frame : clip.frames) add(frame);
    const Result<MatteClipReport> report = follow(clip.truth[0]);
    ASSERT_THAT(report, IsOk());
    const Result<Image> last = load_png(folder_ / "out" / "dancer" / "000007.png");
    ASSERT_THAT(last, IsOk());
    const double iou = matte_iou(*last, clip.truth[kFrames - 1]);
    ASSERT_TRUE(report->labels[0].lost);
    EXPECT_EQ(report->labels[0].lost->end, kFrames - 1);
    EXPECT_EQ(report->doubts.empty(), iou > 0.93) << "seed " << seed << ": IoU " << iou;
  }
}

// A cut: the second half shows somebody else, elsewhere. Neither area nor border need show it.
TEST_F(FollowedLabels, ThatDoNotComeBackFromTheEndAreNamedWithAPictureOfTheEnd) {
  const MatteClip clip = dancer(1), other = dancer(2);
  for (int f = 0; f < kFrames; ++f) add((f < kFrames / 2 ? clip : other).frames[static_cast<std::size_t>(f)]);
  const Result<MatteClipReport> report = follow(clip.truth[0]);
  ASSERT_THAT(report, IsOk());
  std::printf("lost %.3f, jump %.3f\n", report->labels[0].lost->share, report->labels[0].jump);
  EXPECT_THAT(report->doubts, ElementsAre(HasSubstr("followed from frame 0 to frame 7 and back")));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "doubts" / "dancer.png"));
}

}  // namespace
}  // namespace floatstage::pipeline
