#include <cstdio>
#include <ctime>
#include <iostream>

#include "core/file.h"
#include "core/jpeg.h"
#include "core/png.h"
#include "core/text.h"
#include "matting/labels/label_clip.h"
#include "pipeline/metrics/matte_metrics.h"
#include "tests/matting/traced_masks.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/real_data.h"

// Two people in a street before a hand-held camera, cars behind them; the masks of the first frame are given.
// What is compared with, of frames 20, 40 and 59, was traced by eye, before anything was tuned: it is good to
// about 2 px, hair less.
namespace floatstage::matting {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 960, kHeight = 540;

class TwoPersons : public testing::Test {
 protected:
  void SetUp() override { FLOATSTAGE_NEEDS_DATA(folder()); }
  static fs::path folder() { return real_data("clip-two-persons"); }

  static Result<Image> frame(int f) {
    char name[16];
    std::snprintf(name, sizeof name, "%04d.jpg", f);
    const Result<std::string> bytes = read_file(folder() / "frames" / name);
    if (!bytes) return forward(bytes);
    return decode_jpeg(std::as_bytes(std::span(*bytes)), kWidth, kHeight);
  }
  static Image given(int person) { return *load_png(folder() / text("mask_000_person", person, ".png")); }
  static Image traced(int f, int person) {
    return traced_mask(source_folder() / "tests/matting/traced" / text("00", f, "-person", person, ".txt"),
                       kWidth, kHeight);
  }
  // IoU with what was traced, of both people in the frames that were traced and are no key frames.
  static std::map<int, std::array<double, 2>> score(int frames, const std::map<int, LabelMasks>& keys) {
    std::map<int, std::array<double, 2>> out;
    const std::clock_t start = std::clock();
    const auto done = [&](int f, const Image&, const Image& labels) -> Result<void> {
      if (keys.contains(f) || (f != 20 && f != 40 && f != 59)) return {};
      for (int person : {1, 2}) {
        Image mask(kWidth, kHeight, 1);
        for (std::size_t p = 0; p < mask.pixels.size(); ++p)
          mask.pixels[p] = labels.pixels[p] == person ? 255 : 0;
        out[f][static_cast<std::size_t>(person - 1)] = pipeline::matte_iou(mask, traced(f, person));
      }
      return {};
    };
    EXPECT_THAT(follow_labels({frames, frame}, keys, 2, done), IsOk());
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC / frames / 2;
    for (const auto& [f, iou] : out)
      std::cout << "frame " << f << ": woman " << iou[0] << ", man " << iou[1] << "\n";
    std::cout << seconds << " CPU s a frame and label\n";
    return out;
  }
};

TEST_F(TwoPersons, AreFollowedFromMasksOfTheFirstFrame) {
  // Wanted are 0.93 of both. The clip jumps between frames 24 and 25, where the woman loses part of her
  // trousers and gains a wall.
  constexpr double kWoman = 0.97, kWomanBehindTheJump = 0.905, kMan = 0.975;
  const int frames = wants_long_tests() ? 60 : 21;
  for (const auto& [f, iou] : score(frames, {{0, {{1, given(1)}, {2, given(2)}}}})) {
    EXPECT_GE(iou[0], f < 25 ? kWoman : kWomanBehindTheJump) << "frame " << f;
    EXPECT_GE(iou[1], kMan) << "frame " << f;
  }
}

TEST_F(TwoPersons, AreFollowedBetterFromAKeyFrameMore) {
  FLOATSTAGE_LONG_FORM(true);
  // Wanted are 0.96 of both, and nobody worse than without it by 0.01: the man at 20 has 0.985 without.
  constexpr double kWoman = 0.97, kMan = 0.975;
  const std::map<int, LabelMasks> keys = {{0, {{1, given(1)}, {2, given(2)}}},
                                          {40, {{1, traced(40, 1)}, {2, traced(40, 2)}}}};
  for (const auto& [f, iou] : score(60, keys)) {
    EXPECT_GE(iou[0], kWoman) << "frame " << f;
    EXPECT_GE(iou[1], kMan) << "frame " << f;
  }
}

}  // namespace
}  // namespace floatstage::matting
