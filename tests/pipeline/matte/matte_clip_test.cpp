// `matte` on clips whose truth is exact: what a click does, and what auto takes.

#include <algorithm>
#include <map>

#include "core/file.h"
#include "core/matte_edits.h"
#include "core/random.h"
#include "pipeline/matte/matte_take.h"
#include "pipeline/metrics/matte_metrics.h"
#include "tests/matting/small_scenes.h"
#include "tests/support/clip_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

double mean(const fs::path& take, int frames, double (*score)(const Image& matte, const Image& truth)) {
  double sum = 0;
  for (int f = 0; f < frames; ++f) {
    const Result<Image> matte = load_png(TakeLayout(take).matte("cam0", f)),
                        truth = load_png(TakeLayout(take / "truth").matte("cam0", f));
    EXPECT_THAT(matte, IsOk());
    EXPECT_THAT(truth, IsOk());
    if (matte && truth) sum += score(*matte, *truth) / frames;
  }
  return sum;
}
double mean_iou(const fs::path& take, int frames) { return mean(take, frames, matte_iou); }

void click(const fs::path& take, int frame, double x, double y, MatteLabel label = MatteLabel::Foreground) {
  MatteEdits edits;
  edits.cameras["cam0"].keyframes.push_back({frame, {{label, 3, {{x, y}}}}});
  ASSERT_THAT(make_folder(TakeLayout(take).mattes()), IsOk());
  ASSERT_THAT(save_matte_edits(edits, TakeLayout(take).edits()), IsOk());
}

// The middle of the subject's longest row.
std::pair<double, double> inside(const Image& truth) {
  int best = 0, bx = 0, by = 0;
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0, run = 0; x < truth.width; ++x)
      if (run = *truth.at(x, y) == 255 ? run + 1 : 0; run > best) best = run, bx = x - run / 2, by = y;
  return {bx + 0.5, by + 0.5};
}

MatteTakeOptions options_for(const fs::path& take, const std::string& method) {
  MatteTakeOptions options;
  options.take = take;
  options.how = method;
  options.threads = 2;
  options.hull_frames = 0;
  return options;
}

TEST(MatteClick, FindsTheDancerInAClutteredPlaceWithoutAPlate) {
  const MatteClip clip = make_clip(studio_cutout(2), cluttered_place(270, 180, 2),
                                   {.width = 270, .height = 180, .frames = 16, .seed = 2});
  TempFolder folder;
  const fs::path take = clip_take(folder, clip);
  const auto [x, y] = inside(clip.truth[0]);
  click(take, 0, x, y);
  for (const char* method : {"closed-form", "auto", "spectral"}) {
    MatteTakeOptions options = options_for(take, method);
    options.redo = true;
    const Result<MatteReport> report = matte_take(options);
    ASSERT_THAT(report, IsOk());
    EXPECT_EQ(report->cameras[0].key, "cut");
    EXPECT_EQ(report->cameras[0].clicks, 1);
    EXPECT_GE(mean_iou(take, 16), 0.93) << method;
  }
  const fs::path lost = TakeLayout(take).matte("cam0", 9);
  const Result<Image> before = load_png(lost);
  fs::remove(lost);
  const Result<MatteReport> again = matte_take(options_for(take, "spectral"));
  ASSERT_THAT(again, IsOk());
  EXPECT_EQ(again->made, 1);
  EXPECT_THAT(load_png(lost), IsOkAnd(*before)) << "the same bytes";
}

TEST(MatteClick, OnTheBackgroundAloneIsNoSubject) {
  const MatteClip clip = make_clip(studio_cutout(1, 240, 240), cluttered_place(160, 120, 1),
                                   {.width = 160, .height = 120, .frames = 6});
  TempFolder folder;
  const fs::path take = clip_take(folder, clip);
  click(take, 0, 5, 5, MatteLabel::Background);
  const Result<MatteReport> report = matte_take(options_for(take, "closed-form"));
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->cameras[0].key.substr(0, 5), "plate")
      << "found behind the performance, as without clicks";
}

// Seeds that nothing was tuned on.
class Auto : public testing::TestWithParam<std::uint64_t> {
 protected:
  static constexpr int kFrames = 5;
  MatteClip clip(const Image& backdrop) const {
    return make_clip(studio_cutout(GetParam(), 320, 320), backdrop,
                     {.width = 210, .height = 140, .frames = kFrames, .seed = GetParam()});
  }

  // Mean squared errors by method; every method sees the same take.
  static void expect_the_least_error(const fs::path& take, const std::string& key) {
    std::map<std::string, double> mse;
    for (const std::string& method :
         {key, std::string("closed-form"), std::string("spectral"), std::string("auto")}) {
      MatteTakeOptions options = options_for(take, method);
      options.redo = true;
      ASSERT_THAT(matte_take(options), IsOk()) << method;
      mse[method] = mean(take, kFrames, matte_mse);
      std::cout << "  " << method << ": MSE " << mse[method] << "\n";
    }
    EXPECT_LE(mse["auto"], std::min({mse[key], mse["closed-form"], mse["spectral"]}));
  }
};

TEST_P(Auto, IsNoWorseThanTheBestMethodOverGreenCloth) {
  TempFolder folder;
  expect_the_least_error(clip_take(folder, clip(green_cloth(210, 140, GetParam()))), "chroma");
}

TEST_P(Auto, IsNoWorseThanTheBestMethodBeforeAPlateThatWasShot) {
  const MatteClip made = clip(cluttered_place(210, 140, GetParam()));
  TempFolder folder;
  const fs::path take = clip_take(folder, made), plate = TakeLayout(take).plate("cam0");
  ASSERT_THAT(make_folder(plate.parent_path()), IsOk());
  ASSERT_THAT(save_png(made.plate, plate), IsOk());
  expect_the_least_error(take, "plate");
}

INSTANTIATE_TEST_SUITE_P(Seeds, Auto, testing::Values(41, 42, 44, 46));

TEST(AutoWithoutAKey, IsSpectral) {
  // Light that comes and goes on browns: no cloth, no plate, and nothing looks the same for long.
  MatteClip clip;
  for (const double light : {1.0, 0.5, 0.75, 0.3}) {
    const matting::DiscPicture disc = matting::disc_picture(90, 60, 0, 0);
    Image rgb(90, 60, 3);
    for (std::size_t p = 0; p < rgb.pixels.size(); p += 3) {
      const std::uint8_t* from = disc.rgb.pixels.data() + p;
      const double browns[3] = {from[1] * light, from[2] * light / 2, from[0] * light / 2};
      for (std::size_t c = 0; c < 3; ++c) rgb.pixels[p + c] = static_cast<std::uint8_t>(browns[c]);
    }
    clip.frames.push_back(std::move(rgb));
    clip.truth.push_back(disc.alpha);
  }
  TempFolder folder;
  const fs::path take = clip_take(folder, clip);
  EXPECT_THAT(matte_take(options_for(take, "closed-form")),
              FailsWith(ErrorCode::Unsupported, "no backdrop that stands still"));
  const Result<MatteReport> report = matte_take(options_for(take, "auto"));
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->cameras[0].method, "spectral");
  EXPECT_EQ(report->cameras[0].key, "none");
  EXPECT_EQ(report->cameras[0].made, 4);
  EXPECT_GE(mean_iou(take, 4), 0.9);
  EXPECT_EQ(matte_take(options_for(take, "auto"))->cameras[0].kept, 4) << "the choice is remembered";
}

// The same performance as a still camera saw it and as one held in the hand.
class Trust : public testing::Test {
 protected:
  static MatteClip still(int frames, const ClipOptions& options = {.width = 270, .height = 180, .seed = 3}) {
    ClipOptions o = options;
    o.frames = frames;
    return make_clip(studio_cutout(3), cluttered_place(o.width, o.height, 3), o);
  }
  static MatteClip hand_held() {
    MatteClip clip;
    for (int f = 0; f < 6; ++f) {
      const Image place = cluttered_place(320, 220, 3);
      Image seen(270, 180, 3);
      for (int y = 0; y < 180; ++y) std::copy_n(place.at(5 + 2 * f, y + 8 + f), 3 * 270, seen.at(0, y));
      for (std::size_t p = 0; p < seen.pixels.size(); p += 3) {  // browns: nothing there is cloth
        const int light = seen.pixels[p] + seen.pixels[p + 1] + seen.pixels[p + 2];
        for (std::size_t c = 0; c < 3; ++c)
          seen.pixels[p + c] = static_cast<std::uint8_t>(light / (3 + static_cast<int>(c)));
      }
      const MatteClip one =
          make_clip(studio_cutout(3), seen, {.width = 270, .height = 180, .frames = 6, .seed = 3});
      clip.frames.push_back(one.frames[static_cast<std::size_t>(f)]);
      clip.truth.push_back(one.truth[static_cast<std::size_t>(f)]);
    }
    return clip;
  }
  TempFolder folder_;
};

TEST_F(Trust, APlateOfACameraThatMovedIsRefusedByName) {
  const fs::path take = clip_take(folder_, hand_held());
  for (const char* method : {"plate", "difference"})
    EXPECT_THAT(matte_take(options_for(take, method)),
                FailsWith(ErrorCode::Unsupported, "camera 'cam0' moved: between frame 0 and frame"))
        << method;
  EXPECT_FALSE(fs::exists(TakeLayout(take).matte("cam0", 0)));
}

TEST_F(Trust, WhatWasGuessedForACameraThatMovedIsSaidEveryTimeAndShown) {
  const fs::path take = clip_take(folder_, hand_held());
  for (const int made : {6, 0}) {
    const Result<MatteReport> report = matte_take(options_for(take, "auto"));
    ASSERT_THAT(report, IsOk());
    EXPECT_EQ(report->made, made);
    ASSERT_EQ(report->doubts.size(), 1u);
    EXPECT_EQ(report->doubts[0].frames, 6);
    EXPECT_THAT(sentence(report->doubts[0]),
                testing::AllOf(testing::StartsWith("camera 'cam0', frame"),
                               testing::HasSubstr("(camera 'cam0' moved: between frame 0 and")));
    EXPECT_THAT(load_png(report->doubts[0].picture), IsOk());
  }
  click(take, 0, 135, 90);
  MatteTakeOptions clicked = options_for(take, "auto");
  clicked.redo = true;
  const Result<MatteReport> report = matte_take(clicked);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->cameras[0].key, "none")
      << "what follows a click through clutter needs a still camera too";
  EXPECT_TRUE(report->doubts.empty()) << "a person has said where the subject is";
}

TEST_F(Trust, WhereThePlaceIsNeverSeenWithoutTheSubjectItsMattesAreSaidToBeUnknown) {
  const fs::path take =
      clip_take(folder_, still(4, {.width = 270, .height = 180, .seed = 3, .turn = 2, .speed = 2}));
  const Result<MatteReport> report = matte_take(options_for(take, "plate"));
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->doubts.size(), 1u);
  EXPECT_THAT(report->doubts[0].why, testing::HasSubstr("no picture shows the place without it"));
  MatteTakeOptions other = options_for(take, "plate");
  other.frames = {2};
  EXPECT_EQ(matte_take(other)->doubts.at(0).frames, 1) << "of the frames asked for";
}

TEST_F(Trust, APlateThatHoldsWhoeverStoodStillIsNamed) {
  MatteClip clip = still(4);
  Random random(5);
  for (Image& frame : clip.frames) {  // she stands still
    frame = clip.frames.front();
    for (std::uint8_t& v : frame.pixels)
      v = static_cast<std::uint8_t>(std::clamp(v + std::lround(random.normal()), 0L, 255L));
  }
  const Result<MatteReport> report = matte_take(options_for(clip_take(folder_, clip), "plate"));
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->doubts.size(), 1u);
  EXPECT_THAT(report->doubts[0].why, testing::HasSubstr("who hardly moves is in it"));
  EXPECT_EQ(report->doubts[0].frames, 4);
  EXPECT_TRUE(fs::exists(report->doubts[0].picture));
}

// A flash in frame 2: most of the backdrop is subject, without touching the picture's border.
TEST_F(Trust, SubjectsThatComeOrGoAtOnceAreNamedWithTheirFrame) {
  MatteClip clip = still(5);
  const Image plate = clip.plate;
  for (int y = 20; y < 160; ++y) std::fill_n(clip.frames[2].at(20, y), 3 * 230, std::uint8_t{255});
  const fs::path take = clip_take(folder_, clip);
  ASSERT_THAT(make_folder(TakeLayout(take).plate("cam0").parent_path()), IsOk());
  ASSERT_THAT(save_png(plate, TakeLayout(take).plate("cam0")), IsOk());
  const Result<MatteReport> report = matte_take(options_for(take, "plate"));
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->doubts.size(), 2u);
  for (const MatteDoubt& doubt : report->doubts) {
    const bool comes = doubt.why.find("more than half of the subject comes") != std::string::npos;
    EXPECT_TRUE(comes || doubt.why.find("more than half of the subject goes") != std::string::npos)
        << doubt.why;
    EXPECT_EQ(doubt.worst, comes ? 2 : 3);
    EXPECT_EQ(doubt.frames, 1);
  }
}

TEST_F(Trust, IsThereWhereMattesAreRight) {
  MatteClip green =
      make_clip(studio_cutout(4), green_cloth(270, 180, 4), {.width = 270, .height = 180, .frames = 4});
  const fs::path cloth = clip_take(folder_, green, "green"), clear = clip_take(folder_, still(4), "plate");
  ASSERT_THAT(make_folder(TakeLayout(clear).plate("cam0").parent_path()), IsOk());
  ASSERT_THAT(save_png(still(4).plate, TakeLayout(clear).plate("cam0")), IsOk());
  for (const fs::path& take : {cloth, clear}) {
    const Result<MatteReport> report = matte_take(options_for(take, "auto"));
    ASSERT_THAT(report, IsOk());
    EXPECT_TRUE(report->doubts.empty()) << sentence(report->doubts[0]);
    EXPECT_FALSE(fs::exists(doubts_folder(TakeLayout(take))));
  }
}

}  // namespace
}  // namespace floatstage::pipeline
