#include "matting/video/segment_clip.h"

#include <gmock/gmock.h>

#include "core/random.h"
#include "matting/color_model.h"
#include "matting/keyers/backdrop_memory.h"
#include "tests/matting/clip_scores.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"

namespace floatstage::matting {
namespace {

MattingClip as_clip(const std::vector<Image>& frames) {
  MattingClip clip;
  clip.frames = static_cast<int>(frames.size());
  clip.photograph = [&frames](int f) -> Result<Image> { return frames[static_cast<std::size_t>(f)]; };
  return clip;
}

MatteConstraint dots(int width, int height, const std::vector<std::array<int, 3>>& x_y_opacity) {
  MatteConstraint o{Image(width, height, 1), Image(width, height, 1)};
  for (const auto& [x, y, opacity] : x_y_opacity)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        *o.opacity.at(x + dx, y + dy) = static_cast<std::uint8_t>(opacity),
                                  *o.weight.at(x + dx, y + dy) = 255;
  return o;
}

// A click on the pixel that lies deepest in the subject.
MatteConstraint click_on(const Image& truth) {
  int best = -1, bx = 1, by = 1;
  for (int y = 8; y < truth.height - 8; ++y)
    for (int x = 8; x < truth.width - 8; ++x) {
      int inside = 0;
      for (int r = 1; r <= 8; ++r)
        inside += *truth.at(x + r, y) == 255 && *truth.at(x - r, y) == 255 && *truth.at(x, y + r) == 255 &&
                  *truth.at(x, y - r) == 255;
      if (inside > best) best = inside, bx = x, by = y;
    }
  return dots(truth.width, truth.height, {{bx, by, 255}});
}

class SegmentClipClips : public testing::TestWithParam<std::uint64_t> {};

TEST_P(SegmentClipClips, FollowADancerThroughAClutteredPlaceFromOneClick) {
  FLOATSTAGE_LONG_FORM(GetParam() > 2);
  const MatteClip clip = make_clip(studio_cutout(GetParam()), cluttered_place(360, 240, GetParam()),
                                   {.frames = 24, .seed = GetParam()});
  const Result<std::vector<Image>> cut = segment_clip(as_clip(clip.frames), {{0, click_on(clip.truth[0])}});
  ASSERT_THAT(cut, IsOk());
  const ClipScores s = score_clip(*cut, clip.truth, 0);
  std::cout << "cluttered place, seed " << GetParam() << ": " << s << "\n";
  EXPECT_GE(s.iou, 0.9);
}

INSTANTIATE_TEST_SUITE_P(Seeds, SegmentClipClips, testing::Values(1, 2, 3, 4));

// Discs before stripes: the first is the subject and goes right, the second goes left, the third never moves.
constexpr int kWidth = 160, kHeight = 100, kFrames = 24;
struct Disc {
  double x, y, radius, speed;
  std::array<int, 3> color;
};
std::vector<Image> discs(const std::vector<Disc>& all) {
  std::vector<Image> frames;
  for (int f = 0; f < kFrames; ++f) {
    Random random(static_cast<std::uint64_t>(f) + 1);
    Image frame(kWidth, kHeight, 3);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        std::array<double, 3> c = {60.0 + 50 * (x / 11 % 2), 110.0 + 30 * (y / 13 % 2), 90};
        for (const Disc& d : all)
          if (std::hypot(x - d.x - d.speed * f, y - d.y) < d.radius)
            c = {d.color[0] + 2.0 * (y - d.y), d.color[1] + (x - d.x - d.speed * f),
                 static_cast<double>(d.color[2])};
        for (std::size_t k = 0; k < 3; ++k)
          frame.at(x, y)[k] = static_cast<std::uint8_t>(std::clamp(c[k] + 2 * random.normal(), 0.0, 255.0));
      }
    frames.push_back(std::move(frame));
  }
  return frames;
}
double share_of(const Image& matte, double cx, double cy, double radius) {
  int in = 0, set = 0;
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x)
      if (std::hypot(x - cx, y - cy) < radius) ++in, set += *matte.at(x, y) == 255;
  return static_cast<double>(set) / in;
}
constexpr Disc kSubject{45, 50, 18, 1.5, {200, 120, 90}};

TEST(SegmentClip, LeavesOthersWhoMoveAlone) {
  const std::vector<Image> frames = discs({kSubject, {140, 20, 12, -1, {60, 60, 200}}});
  const Result<std::vector<Image>> cut =
      segment_clip(as_clip(frames), {{12, dots(kWidth, kHeight, {{63, 50, 255}})}});
  ASSERT_THAT(cut, IsOk());
  for (const int f : {0, 12, 23}) {
    EXPECT_GE(share_of((*cut)[static_cast<std::size_t>(f)], 45 + 1.5 * f, 50, 17), 0.97) << f;
    EXPECT_EQ(share_of((*cut)[static_cast<std::size_t>(f)], 140 - f, 20, 12), 0) << f;
  }
}

TEST(SegmentClip, HoldsSomebodyWhoHardlyMoves) {
  Disc resting = kSubject;
  resting.speed = 0.4;
  const Result<std::vector<Image>> cut =
      segment_clip(as_clip(discs({resting})), {{0, dots(kWidth, kHeight, {{45, 50, 255}, {100, 50, 0}})}});
  ASSERT_THAT(cut, IsOk());
  for (const int f : {0, 12, 23}) {
    EXPECT_GE(share_of((*cut)[static_cast<std::size_t>(f)], 45 + 0.4 * f, 50, 16), 0.97) << f;
    EXPECT_LE(share_of((*cut)[static_cast<std::size_t>(f)], 120, 50, 30), 0.01) << f;
  }
}

TEST(SegmentClip, ObeysStrokesInAnyFrame) {
  const std::vector<Image> frames = discs({kSubject});
  const Result<std::vector<Image>> cut =
      segment_clip(as_clip(frames), {{0, dots(kWidth, kHeight, {{45, 50, 255}})},
                                     {10, dots(kWidth, kHeight, {{60, 50, 0}, {140, 90, 255}})}});
  ASSERT_THAT(cut, IsOk());
  EXPECT_EQ(*(*cut)[10].at(60, 50), 0);
  EXPECT_EQ(*(*cut)[10].at(140, 90), 255);
}

TEST(SegmentClip, GivesTheSameBytesAgainAndWorksSmall) {
  const std::vector<Image> frames = discs({kSubject});
  SegmentClipOptions options;
  options.working_pixels = 5000;
  const std::map<int, MatteConstraint> click = {{0, dots(kWidth, kHeight, {{45, 50, 255}})}};
  const Result<std::vector<Image>> once = segment_clip(as_clip(frames), click, options),
                                   again = segment_clip(as_clip(frames), click, options);
  ASSERT_THAT(once, IsOk());
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(*once, *again);
  EXPECT_EQ(once->front().width, 89);
  EXPECT_EQ(once->front().height, 56);
}

TEST(SegmentClip, NamesWhatIsWrong) {
  std::vector<Image> frames = discs({kSubject});
  const MatteConstraint click = dots(kWidth, kHeight, {{45, 50, 255}});
  EXPECT_THAT(segment_clip(as_clip(frames), {}),
              FailsWith(ErrorCode::InvalidArgument, "no stroke marks the subject"));
  EXPECT_THAT(segment_clip(as_clip(frames), {{0, dots(kWidth, kHeight, {{45, 50, 0}})}}),
              FailsWith(ErrorCode::InvalidArgument, "no stroke marks the subject"));
  EXPECT_THAT(segment_clip(as_clip(frames), {{99, click}}),
              FailsWith(ErrorCode::InvalidArgument, "no frame 99"));
  EXPECT_THAT(segment_clip(as_clip(frames), {{0, click}}, {.rounds = 0}),
              FailsWith(ErrorCode::InvalidArgument, "rounds"));
  EXPECT_THAT(segment_clip(as_clip(frames), {{0, click}}, {}, [](int, int frame) { return frame < 5; }),
              FailsWith(ErrorCode::Cancelled, "stopped"));
  frames[7] = Image(kWidth / 2, kHeight, 3);
  EXPECT_THAT(segment_clip(as_clip(frames), {{0, click}}),
              FailsWith(ErrorCode::BadData, "frame 7: the photograph is 80x100"));
}

TEST(BackdropMemory, KnowsShadowsAndNothingOfPlacesItNeverSaw) {
  BackdropMemory memory(2, 1);
  Image picture(2, 1, 3), near(2, 1, 1);
  for (std::size_t c = 0; c < 3; ++c)
    picture.pixels[c] = picture.pixels[3 + c] = static_cast<std::uint8_t>(100 + 40 * c);
  near.pixels[1] = 255;
  for (int i = 0; i < 8; ++i) memory.observe(picture, near);
  const std::uint8_t same[] = {100, 140, 180}, shadow[] = {88, 123, 158}, other[] = {180, 140, 100};
  EXPECT_LT(memory.odds(0, same), -1.5);
  EXPECT_LT(memory.odds(0, shadow), 0) << "a little darker is shadow";
  EXPECT_GT(memory.odds(0, other), 3);
  EXPECT_FALSE(memory.known(1));
  EXPECT_EQ(memory.odds(1, other), 0);
}

TEST(BackdropMemory, ForgetsWhatIsContradictedOften) {
  BackdropMemory memory(1, 1);
  const Image before(1, 1, 3, 40), after(1, 1, 3, 160), nobody(1, 1, 1);
  for (int i = 0; i < 3; ++i) memory.observe(before, nobody);
  EXPECT_GT(memory.odds(0, after.pixels.data()), 1);
  for (int i = 0; i < 8; ++i) memory.observe(after, nobody);
  EXPECT_LT(memory.odds(0, after.pixels.data()), -1);
}

TEST(ColorModel, TellsSeenColoursFromOthers) {
  ColorModel model;
  const std::uint8_t red[] = {200, 40, 40}, nearly[] = {206, 44, 38}, blue[] = {30, 30, 220};
  for (int i = 0; i < 100; ++i) model.add(red);
  model.finish();
  EXPECT_GT(model.likelihood(red), 100);
  EXPECT_GT(model.likelihood(nearly), 10);
  EXPECT_LT(model.likelihood(blue), 1);
  EXPECT_GT(model.likelihood(blue), 0);
  ColorModel empty;
  empty.finish();
  EXPECT_EQ(empty.likelihood(red), 1);
}

}  // namespace
}  // namespace floatstage::matting
