#include <cstdio>
#include <ctime>
#include <iostream>

#include "core/file.h"
#include "core/jpeg.h"
#include "core/matte.h"
#include "core/png.h"
#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/guide/guided_matte.h"
#include "matting/keyers/keyer.h"
#include "matting/picture_scale.h"
#include "tests/matting/drawn_strokes.h"
#include "tests/matting/operator_strokes.h"
#include "tests/matting/traced_masks.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"
#include "tests/support/places.h"
#include "tests/support/real_data.h"

// Right strokes on recordings and clips: 240 sequences of four strokes in the long form, a fifth of them in
// the short one. Numbers were chosen on the clips and green-dome. Hair before black walls (green-dome-wd) and
// a person with a piece of floor (the court) were found here and gave two rules; the street gave none.
namespace floatstage::matting {
namespace {

constexpr int kStrokes = 4;
constexpr int kSide = 512;  // pictures are no larger

struct Example {
  std::string name;
  Image picture, truth, base;
};

struct Tally {
  int strokes = 0;
  double worst = 0, first = 0, last = 0;
};

Image print_of(const MatteStroke& stroke, const Image& matte) {
  Image print(matte.width, matte.height, 1, 128);
  paint_strokes({stroke}, 1, print);
  return print;
}

void draw(const Example& scene, std::uint64_t seed, Tally& tally) {
  StrokeDrawer drawer(scene.truth, seed);
  std::vector<MatteStroke> said;
  Image now = scene.base;
  tally.first += overlap(now, scene.truth);
  for (int i = 0; i < kStrokes; ++i) {
    said.push_back(drawer.next(now));
    const Result<GuidedMatte> made = guided_matte(scene.picture, scene.base, said);
    ASSERT_THAT(made, IsOk());
    const double gain = overlap(made->matte, scene.truth) - overlap(now, scene.truth);
    EXPECT_GE(gain, -0.01) << scene.name << ", seed " << seed << ", stroke " << i;
    tally.worst = std::min(tally.worst, gain), ++tally.strokes;
    const Image print = print_of(said.back(), now);
    for (std::size_t p = 0; p < print.pixels.size(); ++p)
      ASSERT_EQ(made->matte.pixels[p], print.pixels[p] == 128 ? made->matte.pixels[p] : print.pixels[p])
          << "where it was given";
    now = made->matte;
  }
  tally.last += overlap(now, scene.truth);
}

// `sequences` in the long form, spread over the scenes.
void draw_all(const std::vector<Example>& scenes, int sequences) {
  ASSERT_FALSE(scenes.empty());
  const int step = wants_long_tests() ? 1 : 5;
  Tally tally;
  int drawn = 0;
  const std::clock_t began = std::clock();
  for (int i = 0; i < sequences; i += step, ++drawn)
    draw(scenes[static_cast<std::size_t>(i) % scenes.size()], static_cast<std::uint64_t>(1000 + i), tally);
  std::cout << "  " << drawn << " sequences, " << tally.strokes << " strokes: worst " << tally.worst
            << "; IoU in the mean " << tally.first / drawn << " -> " << tally.last / drawn << "; "
            << 1000.0 * static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC / tally.strokes
            << " ms a replay\n";
}

Example small(std::string name, const Image& picture, const Image& truth, const Image& base = {}) {
  const double shrink = std::min(1.0, static_cast<double>(kSide) / std::max(picture.width, picture.height));
  const int w = static_cast<int>(picture.width * shrink), h = static_cast<int>(picture.height * shrink);
  return {std::move(name), scaled(picture, w, h), scaled(truth, w, h),
          base.empty() ? Image() : scaled(base, w, h)};
}

TEST(RightStrokesReal, OnClips) {
  std::vector<Example> scenes;
  for (std::uint64_t seed = 1; scenes.size() < 20; ++seed) {
    const Image place = seed % 2 ? green_cloth(360, 240, seed) : cluttered_place(360, 240, seed);
    MatteClip clip = make_clip(studio_cutout(seed, 240, 240), place, {.frames = 1, .seed = seed});
    Random random(seed);
    Image base = doubtful_matte(clip.frames[0], clip.truth[0], random);
    if (overlap(base, clip.truth[0]) < 0.1) continue;  // nothing of the dancer: no matte to be guided
    scenes.push_back({text("clip ", seed), clip.frames[0], clip.truth[0], std::move(base)});
  }
  draw_all(scenes, 60);
}

// What the editor waits for in the frame that it shows: 0.3 s at 1280x720 is what an artist does not notice.
// Printed, not asserted: CPU time of one machine is no property of the code.
TEST(RightStrokesReal, TakeATimeThatIsPrinted) {
  const MatteClip clip = make_clip(studio_cutout(3, 720, 720), green_cloth(1280, 720, 3),
                                   {.width = 1280, .height = 720, .frames = 1, .seed = 3, .scale = 0.8});
  Random random(3);
  const Image base = doubtful_matte(clip.frames[0], clip.truth[0], random);
  const Operator person(clip.truth[0]);
  std::vector<MatteStroke> said;
  Image now = base;
  for (int i = 0; i < 5; ++i) {
    said.push_back(person.next(now, i % 2 == 1));
    const std::clock_t began = std::clock();
    now = guided_matte(clip.frames[0], base, said)->matte;
    std::printf("  1280x720, %d strokes: %.0f ms CPU, IoU %.4f\n", i + 1,
                1000.0 * static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC,
                overlap(now, clip.truth[0]));
  }
  const std::clock_t began = std::clock();
  EXPECT_THAT(refine_matte(clip.frames[0], now, key_refinement()), IsOk());
  std::printf("  1280x720, closed form of the whole outline: %.0f ms CPU\n",
              1000.0 * static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC);
}

TEST(RightStrokesReal, OnABasketballCourt) {
  const auto folder = real_data("dynamic-basketball");
  FLOATSTAGE_NEEDS_DATA(folder);
  std::vector<Example> scenes;
  for (const char* camera : {"01", "07", "13", "19", "25"})
    for (const int frame : {45, 70}) {
      const Result<std::string> bytes = read_file(folder / "images" / camera / text("0", frame, ".jpg"));
      const Result<Image> mask = load_png(folder / "masks" / camera / text("0", frame, ".png"));
      if (!bytes || !mask) continue;
      const Result<Image> picture = decode_jpeg(std::as_bytes(std::span(*bytes)), 640, 360);
      ASSERT_THAT(picture, IsOk());
      Example scene = small(text("court ", camera, " ", frame), *picture, *mask);
      Random random(static_cast<std::uint64_t>(frame));
      scene.base = doubtful_matte(scene.picture, scene.truth, random);
      scenes.push_back(std::move(scene));
    }
  draw_all(scenes, 40);
}

class Dome : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { FLOATSTAGE_NEEDS_DATA(real_data(GetParam())); }
  static std::vector<Example> scenes(bool keyed) {
    std::vector<Example> all;
    for (int camera = keyed ? 0 : 1; camera < 20; camera += 2) {
      const std::string name = text(camera < 10 ? "0" : "", camera, ".png");
      const Result<Image> photograph = load_png(real_data(GetParam()) / "images" / name),
                          given = load_png(real_data(GetParam()) / "mattes" / name);
      if (!photograph || !given) continue;
      Image key;
      if (keyed) {
        const auto keyer = make_keyer("chroma", {*photograph});
        EXPECT_THAT(keyer, IsOk());
        key = to_image(*(*keyer)->key(make_frame({}, *photograph)));
      }
      Example scene = small(text(GetParam(), " ", name), *photograph, *given, key);
      Random random(static_cast<std::uint64_t>(camera));
      if (!keyed) scene.base = doubtful_matte(scene.picture, scene.truth, random);
      all.push_back(std::move(scene));
    }
    return all;
  }
};

TEST_P(Dome, WithTheKey) { draw_all(scenes(true), 20); }
TEST_P(Dome, WithoutAKey) { draw_all(scenes(false), 25); }
INSTANTIATE_TEST_SUITE_P(RightStrokesReal, Dome, testing::Values("green-dome", "green-dome-wd"),
                         [](const auto& suite) {
                           return suite.param == "green-dome" ? "Green" : "BlackWalls";
                         });

// Likewise, without what lies within 2 px of the outline of `truth`.
double overlap_beside_outline(const Image& matte, const Image& truth) {
  Image a = matte, b = truth;
  for (int y = 0; y < truth.height; ++y)
    for (int x = 0; x < truth.width; ++x) {
      bool outline = false;
      for (int v = std::max(0, y - 2); v <= std::min(truth.height - 1, y + 2); ++v)
        for (int u = std::max(0, x - 2); u <= std::min(truth.width - 1, x + 2); ++u)
          outline = outline || (*truth.at(u, v) >= 128) != (*truth.at(x, y) >= 128);
      if (outline) *a.at(x, y) = *b.at(x, y) = 0;
    }
  return overlap(a, b);
}

// What it gives today; 0.97 in the mean and 0.95 at worst are wanted with a click, 0.97 with five scribbles.
// The given mattes are 1 to 2 px wider than the person along arms and feet, which no stroke says.
TEST(AnOperatorBeforeBlackWalls, NeedsAClickOrFiveScribblesACamera) {
  const auto folder = real_data("green-dome-wd");
  FLOATSTAGE_NEEDS_DATA(folder);
  double none = 0, click = 0, five = 0, beside_rim = 0, worst_click = 1, worst_five = 1;
  int cameras = 0;
  const int step = wants_long_tests() ? 1 : 5;
  for (int camera = 0; camera < 20; camera += step, ++cameras) {
    const std::string name = text(camera < 10 ? "0" : "", camera, ".png");
    const Result<Image> photograph = load_png(folder / "images" / name),
                        given = load_png(folder / "mattes" / name);
    ASSERT_TRUE(photograph && given) << name;
    const auto keyer = make_keyer("chroma", {*photograph});
    ASSERT_THAT(keyer, IsOk());
    const Image base =
        *refine_matte(*photograph, to_image(*(*keyer)->key(make_frame({}, *photograph))), key_refinement());
    const Operator person(*given);
    const Image clicked = guided_matte(*photograph, base, {person.next(base, false)})->matte;
    std::vector<MatteStroke> said;
    Image now = base;
    for (int i = 0; i < 5; ++i) {
      said.push_back(person.next(now, true));
      if (said.back().points.empty()) break;
      now = guided_matte(*photograph, base, said)->matte;
    }
    const double a = overlap(base, *given), b = overlap(clicked, *given), c = overlap(now, *given);
    std::printf("  camera %02d: %.4f, a click %.4f, %zu scribbles %.4f\n", camera, a, b, said.size(), c);
    EXPECT_GE(b, a - 0.01);
    EXPECT_GE(c, a - 0.01);
    none += a, click += b, five += c;
    worst_click = std::min(worst_click, b), worst_five = std::min(worst_five, c);
    beside_rim += overlap_beside_outline(now, *given);
  }
  std::printf(
      "  mean %.4f, a click %.4f (worst %.4f), five scribbles %.4f (worst %.4f; without 2 px of outline, "
      "mean %.4f)\n",
      none / cameras, click / cameras, worst_click, five / cameras, worst_five, beside_rim / cameras);
  EXPECT_GE(click / cameras, 0.945);
  EXPECT_GE(worst_click, 0.91);
  EXPECT_GE(five / cameras, 0.96);
  EXPECT_GE(worst_five, 0.945);
}

TEST(RightStrokesReal, OnTwoPeopleInAStreet) {
  const auto folder = real_data("clip-two-persons");
  FLOATSTAGE_NEEDS_DATA(folder);
  std::vector<Example> scenes;
  for (const int frame : {0, 20, 40, 59})
    for (const int who : {1, 2, 3}) {
      char name[32];
      std::snprintf(name, sizeof name, "%04d.jpg", frame);
      const Result<std::string> bytes = read_file(folder / "frames" / name);
      ASSERT_THAT(bytes, IsOk());
      const Result<Image> picture = decode_jpeg(std::as_bytes(std::span(*bytes)), 960, 540);
      ASSERT_THAT(picture, IsOk());
      Image truth(960, 540, 1);
      for (const int person : {1, 2}) {
        if (!(who & person)) continue;
        std::snprintf(name, sizeof name, "%04d-person%d.txt", frame, person);
        const Image mask = frame == 0
                               ? *load_png(folder / text("mask_000_person", person, ".png"))
                               : traced_mask(source_folder() / "tests/matting/traced" / name, 960, 540);
        for (std::size_t p = 0; p < truth.pixels.size(); ++p)
          truth.pixels[p] = std::max(truth.pixels[p], mask.pixels[p]);
      }
      Example scene = small(text("frame ", frame, " persons ", who), *picture, truth);
      Random random(static_cast<std::uint64_t>(frame + who));
      scene.base = doubtful_matte(scene.picture, scene.truth, random);
      scenes.push_back(std::move(scene));
    }
  draw_all(scenes, 50);
}

}  // namespace
}  // namespace floatstage::matting
