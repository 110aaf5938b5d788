#include "matting/labels/label_strokes.h"

#include <algorithm>

#include "core/random.h"
#include "matting/labels/label_clip.h"
#include "tests/matting/drawn_strokes.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"

// Two people side by side, and strokes that say whose a part is: in one picture, and in a clip of them.
namespace floatstage::matting {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::Gt;

constexpr int kW = 200, kH = 120, kWoman = 1, kMan = 2;

struct Part {
  int label, x0, y0, x1, y1, r, g, b;
};
// Her coat and bag, his jacket and trousers. The bag hangs between them.
constexpr Part kCoat{kWoman, 40, 20, 80, 100, 180, 40, 50}, kBag{kWoman, 80, 50, 104, 76, 200, 170, 60},
    kJacket{kMan, 104, 20, 144, 64, 40, 60, 170}, kTrousers{kMan, 104, 64, 144, 104, 40, 35, 30};

// One frame, everybody `by` px further to the right.
struct TwoPeople {
  Image picture, truth{kW, kH, 1};
  explicit TwoPeople(int by = 0) : picture(cluttered_place(kW, kH, 5)) {
    Random random(static_cast<std::uint64_t>(11 + by));
    for (std::size_t p = 0; p < picture.pixels.size(); p += 3)  // a grey street
      std::fill_n(picture.pixels.data() + p, 3, static_cast<std::uint8_t>(90 + picture.pixels[p + 1] / 4));
    for (const Part& part : {kCoat, kBag, kJacket, kTrousers})
      for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0 + by; x < part.x1 + by; ++x) {
          const int rgb[] = {part.r, part.g, part.b};
          for (int c = 0; c < 3; ++c)
            picture.at(x, y)[c] =
                static_cast<std::uint8_t>(std::clamp(rgb[c] + 4 * random.normal(), 0.0, 255.0));
          *truth.at(x, y) = static_cast<std::uint8_t>(part.label);
        }
  }
};

void give(Image& labels, const Part& part, int to) {
  for (int y = part.y0; y < part.y1; ++y)
    std::fill_n(labels.at(part.x0, y), part.x1 - part.x0, static_cast<std::uint8_t>(to));
}
LabelStroke click_at(int label, double x, double y, MatteLabel side = MatteLabel::Foreground) {
  return {label, {side, 2, {{x, y}}}};
}
LabelStroke middle_of(int label, const Part& part, int by = 0) {
  return click_at(label, (part.x0 + part.x1) / 2.0 + by, (part.y0 + part.y1) / 2.0);
}
Image mask_of(const Image& labels, int label) {
  Image mask(labels.width, labels.height, 1);
  for (std::size_t p = 0; p < mask.pixels.size(); ++p) mask.pixels[p] = labels.pixels[p] == label ? 255 : 0;
  return mask;
}
double iou_of(const Image& labels, const Image& truth, int label) {
  return overlap(mask_of(labels, label), mask_of(truth, label));
}
Image stroked(const TwoPeople& seen, const Image& labels, const std::vector<LabelStroke>& strokes) {
  const Result<StrokedLabels> out = stroke_labels(seen.picture, labels, strokes);
  EXPECT_THAT(out, IsOk());
  return out ? out->labels : Image();
}

TEST(LabelStrokes, GiveALabelWhatItLacks) {
  const TwoPeople seen;
  Image labels = seen.truth;
  give(labels, kTrousers, 0);
  const Image now = stroked(seen, labels, {middle_of(kMan, kTrousers)});
  EXPECT_GE(iou_of(now, seen.truth, kMan), 0.98);
  EXPECT_EQ(mask_of(now, kWoman), mask_of(labels, kWoman)) << "who is not meant keeps every pixel";
}

TEST(LabelStrokes, TakeFromAnotherLabelWhatIsTheirs) {
  const TwoPeople seen;
  Image labels = seen.truth;
  give(labels, kBag, kMan);
  const Image now = stroked(seen, labels, {middle_of(kWoman, kBag)});
  EXPECT_GE(iou_of(now, seen.truth, kWoman), 0.98);
  EXPECT_GE(iou_of(now, seen.truth, kMan), 0.98);
}

TEST(LabelStrokes, OfTheBackgroundTakeFromWhomTheyLieOn) {
  const TwoPeople seen;
  Image labels = seen.truth;
  const Part street{0, 144, 30, 176, 60, 0, 0, 0};
  give(labels, street, kMan);
  const Image now = stroked(seen, labels, {click_at(0, 160, 45, MatteLabel::Background)});
  EXPECT_GE(iou_of(now, seen.truth, kMan), 0.97);
  EXPECT_EQ(mask_of(now, kWoman), mask_of(labels, kWoman));
}

TEST(LabelStrokes, ThatNameNobodyAreOfWhomTheyAreNearest) {
  const TwoPeople seen;
  Image labels = seen.truth;
  give(labels, kTrousers, 0);
  const Image now = stroked(seen, labels, {middle_of(0, kTrousers)});
  EXPECT_GE(iou_of(now, seen.truth, kMan), 0.98);
}

TEST(LabelStrokes, MarkExactlyWhatTheySayAndTheLaterOneCounts) {
  const TwoPeople seen;
  const LabelStroke first = middle_of(kWoman, kJacket), second = middle_of(kMan, kJacket);
  Image print(kW, kH, 1, 128);
  paint_strokes({first.stroke}, 1, print);
  for (const auto& [strokes, label] :
       {std::pair(std::vector{first}, kWoman), std::pair(std::vector{first, second}, kMan)}) {
    const Image now = stroked(seen, seen.truth, strokes);
    for (std::size_t p = 0; p < print.pixels.size(); ++p) {
      if (print.pixels[p] != 255) continue;
      ASSERT_EQ(now.pixels[p], label);
    }
  }
}

TEST(LabelStrokes, ThatSayWhatIsSoChangeNothingAndSayIt) {
  const TwoPeople seen;
  const Result<StrokedLabels> out =
      stroke_labels(seen.picture, seen.truth,
                    {middle_of(kWoman, kCoat), click_at(0, 20, 20, MatteLabel::Background),
                     middle_of(0, kTrousers), click_at(kMan, 500, 20), middle_of(kMan, kBag)});
  ASSERT_THAT(out, IsOk());
  EXPECT_THAT(out->effects, ElementsAre(StrokeEffect::Already, StrokeEffect::Already, StrokeEffect::Already,
                                        StrokeEffect::Outside, StrokeEffect::Acted));
  EXPECT_EQ(stroked(seen, seen.truth, {middle_of(kWoman, kCoat)}), seen.truth);
}

TEST(LabelStrokes, BeginALabelOfWhichThereIsNothing) {
  const TwoPeople seen;
  const Image none(kW, kH, 1);
  LabelStroke along = middle_of(kWoman, kCoat);
  along.stroke.points = {{60, 30}, {60, 90}};
  EXPECT_GE(overlap(mask_of(stroked(seen, none, {along}), kWoman),
                    [] {
                      Image coat(kW, kH, 1);
                      give(coat, kCoat, 255);
                      return coat;
                    }()),
            0.95);
}

// They walk 2 px a frame.
class StrokedClip : public testing::Test {
 protected:
  static constexpr int kFrames = 9;
  StrokedClip() {
    for (int f = 0; f < kFrames; ++f) seen_.emplace_back(2 * f);
  }
  LabelMasks masks_of(const Image& labels) const {
    return {{kWoman, mask_of(labels, kWoman)}, {kMan, mask_of(labels, kMan)}};
  }
  // Labels of all frames, each handed out once.
  std::vector<Image> follow(const std::map<int, LabelMasks>& keys, const LabelStrokes& strokes) {
    std::vector<Image> out(kFrames);
    const auto done = [&](int f, const Image&, const Image& labels) -> Result<void> {
      EXPECT_TRUE(out[static_cast<std::size_t>(f)].empty()) << "frame " << f << " comes once";
      out[static_cast<std::size_t>(f)] = labels;
      return {};
    };
    const Result<LabelsFollowed> followed = follow_labels(
        {kFrames, [&](int f) -> Result<Image> { return seen_[static_cast<std::size_t>(f)].picture; }}, keys,
        strokes, 2, done);
    EXPECT_THAT(followed, IsOk());
    if (followed) followed_ = *followed;
    return out;
  }
  double iou(const std::vector<Image>& labels, int label, int frame) const {
    const auto f = static_cast<std::size_t>(frame);
    return iou_of(labels[f], seen_[f].truth, label);
  }
  // As somebody gave them who forgot his trousers.
  std::map<int, LabelMasks> without_trousers(int frame) const {
    Image labels = seen_[static_cast<std::size_t>(frame)].truth;
    Part trousers = kTrousers;
    trousers.x0 += 2 * frame, trousers.x1 += 2 * frame;
    give(labels, trousers, 0);
    return {{frame, masks_of(labels)}};
  }

  std::vector<TwoPeople> seen_;
  LabelsFollowed followed_;
};

TEST_F(StrokedClip, IsCorrectedByOneClickFromItsFrameOnToBothSides) {
  const std::vector<Image> before = follow(without_trousers(0), {}),
                           after = follow(without_trousers(0), {{4, {middle_of(kMan, kTrousers, 8)}}});
  for (int f = 1; f < kFrames; ++f) {
    EXPECT_LE(iou(before, kMan, f), 0.65) << "frame " << f;
    EXPECT_GE(iou(after, kMan, f), f < 4 ? iou(before, kMan, f) : 0.95) << "frame " << f;
    EXPECT_GE(iou(after, kWoman, f), iou(before, kWoman, f) - 0.01) << "frame " << f;
  }
  EXPECT_GE(iou(after, kMan, 3), iou(before, kMan, 3) + 0.1) << "and before it, on the way to the mask";
  EXPECT_EQ(before[0], after[0]) << "which stays as somebody gave it";
}

TEST_F(StrokedClip, IsCorrectedBeforeTheFirstMaskToo) {
  const std::vector<Image> before = follow(without_trousers(7), {}),
                           after = follow(without_trousers(7), {{2, {middle_of(kMan, kTrousers, 4)}}});
  for (int f = 0; f <= 2; ++f) {
    EXPECT_LE(iou(before, kMan, f), 0.65) << "frame " << f;
    EXPECT_GE(iou(after, kMan, f), 0.95) << "frame " << f;
  }
  EXPECT_GE(iou(after, kMan, 3), iou(before, kMan, 3) + 0.1);
}

TEST_F(StrokedClip, IsCorrectedBetweenTwoMasks) {
  std::map<int, LabelMasks> keys = without_trousers(0);
  keys[8] = masks_of(seen_[8].truth);
  keys[8][kMan] = without_trousers(8)[8][kMan];
  const std::vector<Image> before = follow(keys, {}),
                           after = follow(keys, {{4, {middle_of(kMan, kTrousers, 8)}}});
  EXPECT_LE(iou(before, kMan, 4), 0.65);
  EXPECT_GE(iou(after, kMan, 4), 0.95);
  for (const int f : {3, 5}) EXPECT_GE(iou(after, kMan, f), iou(before, kMan, f) + 0.1) << "frame " << f;
  EXPECT_EQ(after[8], before[8]);
}

TEST_F(StrokedClip, KeepsEveryPixelWhereStrokesSayWhatIsSo) {
  std::map<int, LabelMasks> keys{{0, masks_of(seen_[0].truth)}};
  for (const bool two : {false, true}) {
    if (two) keys[8] = masks_of(seen_[8].truth);
    const std::vector<Image> before = follow(keys, {});
    const std::vector<Image> after = follow(keys, {{2, {middle_of(kWoman, kCoat, 4)}},
                                                   {5, {middle_of(0, kJacket, 10)}},
                                                   {6, {click_at(0, 10, 10, MatteLabel::Background)}}});
    EXPECT_EQ(before, after);
    ASSERT_EQ(followed_.heard.size(), 3U);
    for (const auto& [frame, heard] : followed_.heard)
      EXPECT_THAT(heard.effects, Each(StrokeEffect::Already)) << "frame " << frame;
  }
}

TEST_F(StrokedClip, BeginsWithStrokesAlone) {
  LabelStroke coat = middle_of(kWoman, kCoat, 6), jacket = middle_of(kMan, kJacket, 6);
  coat.stroke.points = {{66, 30}, {66, 90}};
  jacket.stroke.points = {{130, 28}, {130, 56}};
  const std::vector<Image> labels =
      follow({}, {{3, {coat, jacket, middle_of(kMan, kTrousers, 6), middle_of(kWoman, kBag, 6)}}});
  for (int f = 0; f < kFrames; ++f)
    for (const int label : {kWoman, kMan})
      EXPECT_GE(iou(labels, label, f), 0.9) << "label " << label << ", frame " << f;
  EXPECT_THAT(followed_.heard.at(3).turned, Each(Gt(100)));
}

TEST_F(StrokedClip, HearsAStrokeInEachOfSeveralFrames) {
  std::map<int, LabelMasks> keys = without_trousers(0);
  for (std::uint8_t& p : keys[0][kWoman].pixels) p = 0;
  give(keys[0][kWoman], kCoat, 255);  // the bag is nobody's
  const LabelStrokes strokes{{3, {middle_of(kMan, kTrousers, 6)}}, {6, {middle_of(kWoman, kBag, 12)}}};
  const std::vector<Image> after = follow(keys, strokes);
  for (int f = 6; f < kFrames; ++f)
    for (const int label : {kWoman, kMan})
      EXPECT_GE(iou(after, label, f), 0.95) << "label " << label << ", frame " << f;
  for (int f = 3; f < 6; ++f) EXPECT_GE(iou(after, kMan, f), 0.95) << "frame " << f;
}

// Strokes that are right, wherever they are drawn, in a clip whose first mask is not.
TEST_F(StrokedClip, IsNeverMadeWorseByStrokesThatAreRight) {
  const std::map<int, LabelMasks> keys = without_trousers(0);
  const std::vector<Image> before = follow(keys, {});
  Random random(9);
  int acted = 0;
  for (std::uint64_t sequence = 0; sequence < 8; ++sequence) {
    const int frame = static_cast<int>(random.uniform(1, kFrames)),
              label = random.uniform() < 0.5 ? kWoman : kMan;
    const Image& real = seen_[static_cast<std::size_t>(frame)].truth;
    const Image truth = mask_of(real, label);
    StrokeDrawer drawer(truth, sequence);
    const MatteStroke stroke = drawer.next(mask_of(before[static_cast<std::size_t>(frame)], label));
    const bool subject = stroke.label == MatteLabel::Foreground;
    Image print(kW, kH, 1, 128);
    paint_strokes({stroke}, 1, print);
    bool right = true;  // what is not hers may be his
    for (std::size_t p = 0; p < print.pixels.size(); ++p)
      right = right && (print.pixels[p] == 128 || real.pixels[p] == (subject ? label : 0));
    if (!right) continue;
    const std::vector<Image> after = follow(keys, {{frame, {{subject ? label : 0, stroke}}}});
    acted += after != before;
    for (const int l : {kWoman, kMan}) {
      double was = 0, is = 0;
      for (int f = 0; f < kFrames; ++f) was += iou(before, l, f) / kFrames, is += iou(after, l, f) / kFrames;
      EXPECT_GE(is, was - 0.01) << "sequence " << sequence << ", label " << l << ", frame " << frame;
    }
  }
  EXPECT_GE(acted, 3);
}

}  // namespace
}  // namespace floatstage::matting
