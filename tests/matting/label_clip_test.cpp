#include "matting/labels/label_clip.h"

#include <numeric>

#include "core/random.h"
#include "matting/labels/label_cut.h"
#include "tests/matting/clip_scores.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"

namespace floatstage::matting {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Gt;
using testing::HasSubstr;
using testing::Lt;

Image mask_of(const Image& alpha) {
  Image out = alpha;
  for (std::uint8_t& a : out.pixels) a = a > 127 ? 255 : 0;
  return out;
}

class LabelledClip : public testing::Test {
 protected:
  explicit LabelledClip(std::uint64_t seed = 1)
      : clip_(make_clip(studio_cutout(seed), cluttered_place(240, 160, seed),
                        {.width = 240, .height = 160, .frames = 10, .seed = seed})) {}

  LabelClip frames() const {
    return {static_cast<int>(clip_.frames.size()),
            [this](int f) -> Result<Image> { return clip_.frames[static_cast<std::size_t>(f)]; }};
  }
  Result<std::vector<Image>> follow(const std::map<int, LabelMasks>& keys, int labels = 1) const {
    std::vector<Image> out(clip_.frames.size());
    const auto done = [&](int f, const Image&, const Image& found) -> Result<void> {
      EXPECT_TRUE(out[static_cast<std::size_t>(f)].empty()) << "frame " << f << " comes once";
      out[static_cast<std::size_t>(f)] = found;
      return {};
    };
    const Result<std::vector<LabelReturn>> returns = follow_labels(frames(), keys, labels, done);
    if (!returns) return forward(returns);
    returns_ = *returns;
    return out;
  }
  std::vector<Image> masks(std::vector<Image> labels) const {
    for (Image& l : labels)
      for (std::uint8_t& v : l.pixels) v = v ? 255 : 0;
    return labels;
  }

  MatteClip clip_;
  mutable std::vector<LabelReturn> returns_;
};

TEST_F(LabelledClip, FollowsADancerThroughAClutteredPlaceFromTheFirstFrame) {
  const Result<std::vector<Image>> labels = follow({{0, {{1, mask_of(clip_.truth[0])}}}});
  ASSERT_THAT(labels, IsOk());
  const ClipScores s = score_clip(masks(*labels), clip_.truth);
  std::cout << "dancer, cluttered place: " << s << "\n";
  EXPECT_GE(s.iou, 0.9);
}

TEST_F(LabelledClip, HasKeyFramesMasksAsTheyAreAndEveryFrameBeforeBetweenAndBehind) {
  const Image a = mask_of(clip_.truth[2]), b = mask_of(clip_.truth[7]);
  const Result<std::vector<Image>> labels = follow({{2, {{1, a}}}, {7, {{1, b}}}});
  ASSERT_THAT(labels, IsOk());
  const std::vector<Image> found = masks(*labels);
  EXPECT_EQ(found[2], a);
  EXPECT_EQ(found[7], b);
  for (std::size_t f = 0; f < found.size(); ++f)
    EXPECT_GE(pipeline::matte_iou(found[f], clip_.truth[f]), 0.85) << "frame " << f;
}

TEST_F(LabelledClip, GoesBackFromEachEndToTheKeyFrameAndSaysWhatWasLost) {
  ASSERT_THAT(follow({{3, {{1, mask_of(clip_.truth[3])}}}}), IsOk());
  ASSERT_EQ(returns_.size(), 2U);
  EXPECT_EQ(returns_[0].key, 3);
  EXPECT_EQ(returns_[0].end, 0);
  EXPECT_EQ(returns_[1].end, 9);
  for (const LabelReturn& r : returns_) EXPECT_THAT(r.lost, ElementsAre(0, AllOf(Gt(0), Lt(0.14))));
  ASSERT_THAT(follow({{0, {{1, mask_of(clip_.truth[0])}}}, {9, {{1, mask_of(clip_.truth[9])}}}}), IsOk());
  EXPECT_TRUE(returns_.empty()) << "key frames say themselves how labels arrive";
}

TEST_F(LabelledClip, LeavesLabelsThatAKeyFrameDoesNotNameAsTheyWere) {
  Image corner(240, 160, 1);
  for (int y = 0; y < 20; ++y) std::fill_n(corner.at(0, y), 20, std::uint8_t{255});
  const Image dancer = mask_of(clip_.truth[0]);
  const Result<std::vector<Image>> labels = follow({{0, {{1, dancer}, {2, corner}}}, {3, {{2, corner}}}}, 2);
  ASSERT_THAT(labels, IsOk());
  EXPECT_EQ(std::count((*labels)[3].pixels.begin(), (*labels)[3].pixels.end(), 2), 400);
  EXPECT_GT(std::count((*labels)[3].pixels.begin(), (*labels)[3].pixels.end(), 1), 500);
}

TEST_F(LabelledClip, IsRefusedWithASentenceWhereMasksFitNothing) {
  const Image mask = mask_of(clip_.truth[0]);
  EXPECT_THAT(follow({}).error().message, HasSubstr("no frame's mask"));
  EXPECT_THAT(follow({{10, {{1, mask}}}}).error().message, HasSubstr("10 frames"));
  EXPECT_THAT(follow({{0, {{2, mask}}}}).error().message, HasSubstr("label 2 of 1"));
  EXPECT_THAT(follow({{0, {{1, Image(8, 8, 1)}}}}).error().message, HasSubstr("8x8"));
}

TEST_F(LabelledClip, HasMattesThatTogetherAreNeverMoreThanOpaque) {
  Image labels(240, 160, 1);
  for (int y = 0; y < 160; ++y)
    for (int x = 60; x < 180; ++x) *labels.at(x, y) = x < 120 ? 1 : 2;
  const Result<std::vector<Image>> mattes = label_mattes(clip_.frames[0], labels, 2);
  ASSERT_THAT(mattes, IsOk());
  ASSERT_EQ(mattes->size(), 2U);
  for (std::size_t p = 0; p < labels.pixels.size(); ++p)
    ASSERT_LE((*mattes)[0].pixels[p] + (*mattes)[1].pixels[p], 255);
  EXPECT_EQ(*(*mattes)[0].at(90, 80), 255);
  EXPECT_EQ(*(*mattes)[1].at(90, 80), 0);
}

// Two labels are one minimum cut: nothing else costs less.
TEST(CutLabels, CostsLeastOfAllLabellingsOfASmallPicture) {
  Random random(3);
  Image picture(3, 3, 3);
  for (std::uint8_t& v : picture.pixels) v = static_cast<std::uint8_t>(random.uniform(0, 255));
  LabelEvidence e{
      .count = 2, .labels = Image(3, 3, 1), .asked = std::vector<std::uint8_t>(9, 1), .costs = {}};
  for (int i = 0; i < 18; ++i) e.costs.push_back(static_cast<float>(random.uniform(0, 2)));
  const Image found = cut_labels(picture, e, 0);
  for (std::size_t p = 0; p < 9; ++p)
    EXPECT_EQ(found.pixels[p], e.costs[2 * p + 1] < e.costs[2 * p] ? 1 : 0)
        << "without smoothness each for itself";
  const Image smooth = cut_labels(picture, e, 100);
  double sums[2] = {};
  for (std::size_t i = 0; i < 18; ++i) sums[i % 2] += e.costs[i];
  EXPECT_EQ(smooth, Image(3, 3, 1, sums[1] < sums[0] ? 1 : 0)) << "with much of it all alike";
}

TEST(CutLabels, LeavesPixelsThatWereNotAsked) {
  const Image picture(4, 1, 3, 100);
  LabelEvidence e{.count = 3, .labels = Image(4, 1, 1, 2), .asked = {0, 1, 1, 1}, .costs = {}};
  for (int i = 0; i < 3; ++i) e.costs.insert(e.costs.end(), {0.0f, 5.0f, 5.0f});
  const Image found = cut_labels(picture, e, 0.5);
  EXPECT_EQ(found.pixels, (std::vector<std::uint8_t>{2, 0, 0, 0}));
}

}  // namespace
}  // namespace floatstage::matting
