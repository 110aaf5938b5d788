// Labels that are followed through a clip from one mask, and what the run says of them.

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/matte_edits.h"
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
TEST_F(FollowedLabels, ThatDoNotComeBackFromTheEndAreNamedWithTheFrameWhereTheClipJumps) {
  const MatteClip clip = dancer(1), other = dancer(2);
  for (int f = 0; f < kFrames; ++f) add((f < kFrames / 2 ? clip : other).frames[static_cast<std::size_t>(f)]);
  const Result<MatteClipReport> report = follow(clip.truth[0]);
  ASSERT_THAT(report, IsOk());
  std::printf("lost %.3f, jump %.3f\n", report->labels[0].lost->share, report->labels[0].jump);
  EXPECT_THAT(report->doubts,
              ElementsAre(testing::AllOf(HasSubstr("followed from frame 0 to frame 7 and back"),
                                         HasSubstr("the clip jumps at frame 4"))));
  EXPECT_EQ(report->labels[0].lost->jumps_at, kFrames / 2);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out" / "doubts" / "dancer.png"));
}

// A dancer of whom the mask lacks the legs, and what a person says of that.
class StrokedLabels : public FollowedLabels {
 protected:
  static constexpr int kStroked = 3;
  void SetUp() override {
    for (const Image& frame : clip_.frames) add(frame);
    Image mask = clip_.truth[0];
    for (int y = cut(0); y < mask.height; ++y) std::fill_n(mask.at(0, y), mask.width, std::uint8_t{0});
    ASSERT_THAT(save_png(mask, folder_ / "mask.png"), IsOk());
  }
  // The row below which the mask of a frame lacks everything: the middle of the subject.
  int cut(std::size_t frame) const {
    const Image& truth = clip_.truth[frame];
    int top = truth.height, bottom = 0;
    for (int y = 0; y < truth.height; ++y)
      for (int x = 0; x < truth.width; ++x)
        if (*truth.at(x, y) > 127) top = std::min(top, y), bottom = y;
    return (top + bottom) / 2;
  }
  // What was forgotten, painted row by row with a fine brush.
  std::vector<MatteStroke> legs(const std::string& subject) const {
    const Image& truth = clip_.truth[kStroked];
    std::vector<MatteStroke> strokes;
    for (int y = cut(kStroked) + 1; y < truth.height; y += 2)
      for (int x = 0, run = 0; x < truth.width; ++x) {
        if (*truth.at(x, y) > 250) {
          ++run;
          continue;
        }
        if (run > 4)
          strokes.push_back(
              {MatteLabel::Foreground, 1, {{x - run + 1.5, y + 0.5}, {x - 1.5, y + 0.5}}, subject});
        run = 0;
      }
    return strokes;
  }
  void say(const CameraEdits& edits, const char* serial = "clip") {
    ASSERT_THAT(save_matte_edits({{{serial, edits}}}, folder_ / "edits.json"), IsOk());
  }
  Result<MatteClipReport> made(std::vector<ClipClick> clicks = {}) {
    std::filesystem::remove_all(folder_ / "out");
    return matte_clip({.media = folder_ / "frames",
                       .guides = {{"dancer", folder_ / "mask.png"}},
                       .edits = std::filesystem::exists(folder_ / "edits.json") ? folder_ / "edits.json"
                                                                                : std::filesystem::path(),
                       .clicks = std::move(clicks),
                       .out = folder_ / "out"});
  }
  double iou(int frame, const char* label = "dancer") const {
    const Result<Image> matte = load_png(folder_ / "out" / label / text("00000", frame, ".png"));
    EXPECT_THAT(matte, IsOk());
    return matte ? matte_iou(*matte, clip_.truth[static_cast<std::size_t>(frame)]) : 0;
  }
  const MatteClip clip_ = dancer(2);
};

TEST_F(StrokedLabels, AreCorrectedByAStrokeThatNamesThemOrNobody) {
  ASSERT_THAT(made(), IsOk());
  std::vector<double> before;
  for (int f = 0; f < kFrames; ++f) before.push_back(iou(f));
  for (const char* subject : {"dancer", ""}) {
    say({{{kStroked, legs(subject)}}, {}});
    const Result<MatteClipReport> report = made();
    ASSERT_THAT(report, IsOk());
    EXPECT_EQ(report->labels[0].keyframes, 1);
    EXPECT_EQ(report->labels[0].strokes, *subject ? static_cast<int>(legs("").size()) : 0);
    for (int f = kStroked; f < kFrames; ++f) {
      EXPECT_LT(before[static_cast<std::size_t>(f)], 0.7) << "frame " << f;
      EXPECT_GE(iou(f), 0.85) << "frame " << f << ", '" << subject << "'";
    }
  }
}

TEST_F(StrokedLabels, AreCorrectedByAClick) {
  ASSERT_THAT(made(), IsOk());
  const double before = iou(kStroked);
  const std::vector<MatteStroke> painted = legs("dancer");
  const Eigen::Vector2d at = painted[painted.size() / 4].points[0];
  const Result<MatteClipReport> report = made({{"dancer", kStroked, at.x(), at.y()}});
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->labels[0].strokes, 1);
  EXPECT_GT(iou(kStroked), before);
}

TEST_F(StrokedLabels, SayWhichStrokesChangeNothing) {
  ASSERT_THAT(made(), IsOk());
  const Image before = *load_png(folder_ / "out/dancer/000005.png");
  const Image& truth = clip_.truth[2];
  int x = 0;
  while (*truth.at(x, cut(2) - 8) < 255) ++x;
  say({{{2, {{MatteLabel::Foreground, 1, {{x + 3.5, cut(2) - 7.5}}, "dancer"}}}}, {}});
  const Result<MatteClipReport> report = made();
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->idle, ElementsAre(testing::AllOf(HasSubstr("frame 2: the click of 'dancer'"),
                                                       HasSubstr("changes nothing"))));
  EXPECT_EQ(*load_png(folder_ / "out/dancer/000005.png"), before);
}

TEST_F(StrokedLabels, MayBeNamedByStrokesAlone) {
  say({{{kStroked, legs("trousers")}}, {}});
  const Result<MatteClipReport> report = made();
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->labels.size(), 2U);
  EXPECT_EQ(report->labels[1].name, "trousers");
  EXPECT_EQ(report->labels[1].keyframes, 0);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/trousers/000007.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/all/000007.png"));
}

TEST_F(StrokedLabels, AreSaidToBeNothingButWhatWasMarkedWhereNothingHangsTogetherWithIt) {
  Image backdrop(240, 160, 3, 90);
  for (int f = 0; f < kFrames; ++f)
    ASSERT_THAT(save_png(backdrop, folder_ / "frames" / text("00", f, ".png")), IsOk());
  const Result<MatteClipReport> report = made({{"ghost", kStroked, 200, 20}});
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->doubts, testing::Contains(HasSubstr("ghost: in frame 3 nothing hangs together")));
}

TEST_F(StrokedLabels, AreNobodysUnderGarbage) {
  say({{}, {{MatteLabel::Background, {{0, 0}, {240, 0}, {240, 80}, {0, 80}}, 4, {}}}});
  ASSERT_THAT(made(), IsOk());
  const auto above = [&](int frame) {
    const Image matte = *load_png(folder_ / "out/dancer" / text("00000", frame, ".png"));
    return std::any_of(matte.pixels.begin(), matte.pixels.begin() + 240 * 80,
                       [](std::uint8_t a) { return a > 0; });
  };
  EXPECT_TRUE(above(3));
  EXPECT_FALSE(above(4));
}

TEST_F(StrokedLabels, AreRefusedWithASentence) {
  const auto refused = [&](const CameraEdits& edits) {
    say(edits);
    return made();
  };
  EXPECT_THAT(refused({{{1, {{MatteLabel::Foreground, 2, {{900, 20}}, "dancer"}}}}, {}}),
              FailsWith(ErrorCode::InvalidArgument,
                        "the click of 'dancer' at 900,20 in frame 1 is outside the picture of 240x160"));
  EXPECT_THAT(refused({{{8, {{MatteLabel::Foreground, 2, {{90, 20}}, "dancer"}}}}, {}}),
              FailsWith(ErrorCode::InvalidArgument, "frame 8: the clip has no such frame; it has 8"));
  EXPECT_THAT(refused({{}, {{MatteLabel::Foreground, {{0, 0}, {9, 0}, {9, 9}}, 0, {}}}}),
              FailsWith(ErrorCode::InvalidArgument, "draw a stroke in its place"));
  EXPECT_THAT(refused({{{1, {{MatteLabel::Foreground, 2, {{90, 20}}, "all"}}}}, {}}),
              FailsWith(ErrorCode::InvalidArgument, "'all' cannot be a label"));
  const CameraEdits one{{{1, {{MatteLabel::Foreground, 2, {{90, 20}}, "dancer"}}}}, {}};
  ASSERT_THAT(save_matte_edits({{{"cam0", one}, {"cam1", one}}}, folder_ / "edits.json"), IsOk());
  EXPECT_THAT(made(), FailsWith(ErrorCode::InvalidArgument, "is about 2 cameras; a clip has one"));
  EXPECT_THAT(matte_clip({.media = folder_ / "frames",
                          .guides = {{"dancer", folder_ / "mask.png"}},
                          .edits = folder_ / "nowhere.json",
                          .out = folder_ / "out"}),
              FailsWith(ErrorCode::NotFound, "nowhere.json is not there"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out")) << "whole or not at all";
}

}  // namespace
}  // namespace floatstage::pipeline
