#include "matting/video/closed_form_video.h"

#include "tests/matting/clip_scores.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"

namespace floatstage::matting {
namespace {

std::vector<Image> carried(const MatteClip& clip, const ClosedFormVideoOptions& options = {}) {
  Result<ClosedFormVideo> video = ClosedFormVideo::create(options);
  EXPECT_THAT(video, IsOk());
  EXPECT_THAT(video->keyframe(clip.frames[0], clip.truth[0]), IsOk());
  std::vector<Image> mattes = {clip.truth[0]};
  for (std::size_t f = 1; f < clip.frames.size(); ++f) {
    Result<Image> matte = video->next(clip.frames[f]);
    EXPECT_THAT(matte, IsOk());
    mattes.push_back(std::move(*matte));
  }
  return mattes;
}

class Clips : public testing::TestWithParam<std::uint64_t> {};

TEST_P(Clips, CarryADancerOverGreenClothFromTheFirstFrame) {
  const MatteClip clip =
      make_clip(studio_cutout(GetParam()), green_cloth(360, 240, GetParam()), {.seed = GetParam()});
  const ClipScores s = score_clip(carried(clip), clip.truth);
  std::cout << "green cloth, seed " << GetParam() << ": " << s << "\n";
  EXPECT_LE(s.mse, 3.1e-3);
  EXPECT_LE(s.dtssd, 4.9e-2);
  EXPECT_GE(s.iou, 0.956);
}

TEST_P(Clips, CarryADancerThroughAClutteredPlaceFromTheFirstFrame) {
  const MatteClip clip =
      make_clip(studio_cutout(GetParam()), cluttered_place(360, 240, GetParam()), {.seed = GetParam()});
  const ClipScores s = score_clip(carried(clip), clip.truth);
  std::cout << "cluttered place, seed " << GetParam() << ": " << s << "\n";
  EXPECT_LE(s.mse, 8.8e-3);
  EXPECT_GE(s.iou, 0.93);
}

INSTANTIATE_TEST_SUITE_P(Seeds, Clips, testing::Values(1, 2, 3));

TEST(ClosedFormVideo, GivesTheSameBytesAgain) {
  const MatteClip clip = make_clip(studio_cutout(1, 240, 240), cluttered_place(180, 120, 4),
                                   {.width = 180, .height = 120, .frames = 3, .scale = 0.4});
  EXPECT_EQ(carried(clip), carried(clip));
}

TEST(ClosedFormVideo, RefusesToBeginWithoutAKeyframeAndToChangeItsSize) {
  Result<ClosedFormVideo> video = ClosedFormVideo::create();
  EXPECT_THAT(video->next(Image(32, 24, 3)), FailsWith(ErrorCode::InvalidArgument, "keyframe"));
  EXPECT_THAT(video->keyframe(Image(32, 24, 3), Image(30, 24, 1)),
              FailsWith(ErrorCode::InvalidArgument, "30x24"));
  ASSERT_THAT(video->keyframe(Image(32, 24, 3, 9), Image(32, 24, 1)), IsOk());
  EXPECT_THAT(video->next(Image(64, 24, 3)), FailsWith(ErrorCode::InvalidArgument, "64x24"));
  EXPECT_THAT(video->next(Image(32, 24, 3, 9)), IsOkAnd(Image(32, 24, 1)))
      << "nobody was there, nobody comes";
}

}  // namespace
}  // namespace floatstage::matting
