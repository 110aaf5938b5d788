#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>

#include "core/file.h"
#include "core/jpeg.h"
#include "core/matte.h"
#include "core/png.h"
#include "core/text.h"
#include "matting/guide/guided_matte.h"
#include "matting/keyers/keyer.h"
#include "matting/picture_scale.h"
#include "tests/matting/drawn_strokes.h"
#include "tests/matting/traced_masks.h"
#include "tests/support/matchers.h"
#include "tests/support/matte_clips.h"
#include "tests/support/real_data.h"

namespace floatstage::matting {
namespace {
struct Scene { std::string name; Image picture, truth, base; };
struct Tally { int n = 0, drops = 0; double worst = 0, first = 0, last = 0; };

void dump(const std::string& name, const Scene& s, const Image& before, const Image& after, const MatteStroke& k) {
  Image out(s.picture.width * 2, s.picture.height, 3);
  Image print(s.truth.width, s.truth.height, 1, 128);
  paint_strokes({k}, 1, print);
  for (int y = 0; y < s.picture.height; ++y)
    for (int x = 0; x < s.picture.width; ++x)
      for (int i = 0; i < 2; ++i) {
        const Image& m = i ? after : before;
        const std::uint8_t* c = s.picture.at(x, y);
        std::uint8_t* o = out.at(x + i * s.picture.width, y);
        const bool a = *m.at(x, y) >= 128, t = *s.truth.at(x, y) >= 128;
        for (int j = 0; j < 3; ++j) o[j] = a ? c[j] : c[j] / 3;
        if (a && !t) o[0] = 255;
        if (!a && t) o[2] = 255;
        if (*print.at(x, y) != 128) { o[0] = 0; o[1] = 255; o[2] = *print.at(x, y) ? 255 : 0; }
      }
  (void)save_png(out, "/tmp/guide/" + name + ".png");
}

Tally play(const Scene& s, std::uint64_t seed, int strokes) {
  Tally t;
  StrokeDrawer drawer(s.truth, seed);
  std::vector<MatteStroke> said;
  Image now = s.base;
  double before = overlap(now, s.truth);
  t.first = before;
  for (int i = 0; i < strokes; ++i) {
    said.push_back(drawer.next(now));
    const auto made = guided_matte(s.picture, s.base, said);
    EXPECT_THAT(made, IsOk());
    const double after = overlap(made->matte, s.truth);
    t.worst = std::min(t.worst, after - before);
    ++t.n;
    if (after < before - 0.01) {
      ++t.drops;
      std::printf("  %s seed %d stroke %d %s: %.4f -> %.4f\n", s.name.c_str(), (int)seed, i,
                  said.back().label == MatteLabel::Foreground ? "fg" : "bg", before, after);
      dump(text(s.name, "-", seed, "-", i), s, now, made->matte, said.back());
    }
    if (std::getenv("SHOW")) dump(text(s.name, "-", seed, "-", i), s, now, made->matte, said.back());
    now = made->matte;
    before = after;
  }
  t.last = before;
  std::printf("   %s: %.3f -> %.3f\n", s.name.c_str(), t.first, t.last);
  return t;
}

std::vector<Scene> synthetic(int n) {
  std::vector<Scene> all;
  for (int i = 0; i < n; ++i) {
    const std::uint64_t seed = 100 + i;
    const bool green = i % 2;
    const MatteClip c = make_clip(studio_cutout(seed, 240, 240), green ? green_cloth(360, 240, seed) : cluttered_place(360, 240, seed),
                                  {.width = 360, .height = 240, .frames = 2, .seed = seed});
    Random random(seed);
    all.push_back({text("syn", i), c.frames[0], c.truth[0], doubtful_matte(c.frames[0], c.truth[0], random)});
  }
  return all;
}
std::vector<Scene> dome(const std::string& set, bool keyed, int step) {
  std::vector<Scene> all;
  for (int camera = 0; camera < 20; camera += step) {
    const std::string name = text(camera < 10 ? "0" : "", camera, ".png");
    const auto photograph = load_png(real_data(set) / "images" / name), given = load_png(real_data(set) / "mattes" / name);
    if (!photograph || !given) continue;
    Scene s{text(set, keyed ? "-key" : "-cut", camera), *photograph, *given, {}};
    if (!keyed) {
      s.picture = scaled(s.picture, 512, 384), s.truth = scaled(s.truth, 512, 384);
      Random random(camera);
      s.base = doubtful_matte(s.picture, s.truth, random);
    } else {
      if (set == "green-dome-wd") {
        s.base = *load_png(text("/tmp/gwd/take/mattes/", camera < 10 ? "0" : "", camera, "/000000.png"));
      } else {
        s.base = to_image(*(*make_keyer("chroma", {*photograph}))->key(make_frame({}, *photograph)));
      }
    }
    all.push_back(std::move(s));
  }
  return all;
}
std::vector<Scene> persons() {
  std::vector<Scene> all;
  int i = 0;
  for (int f : {0, 20, 40, 59})
    for (int who : {1, 2, 3}) {
      char name[16];
      std::snprintf(name, sizeof name, "%04d.jpg", f);
      const auto folder = real_data("clip-two-persons");
      const auto bytes = read_file(folder / "frames" / name);
      Image picture = *decode_jpeg(std::as_bytes(std::span(*bytes)), 960, 540);
      Image truth(960, 540, 1);
      for (int p : {1, 2})
        if (who & p) {
          char mask[32];
          std::snprintf(mask, sizeof mask, "%04d-person%d.txt", f, p);
          const Image m = f == 0 ? *load_png(folder / text("mask_000_person", p, ".png"))
                                 : traced_mask(std::filesystem::path("/work/wt-guide/tests/matting/traced") / mask, 960, 540);
          for (std::size_t q = 0; q < truth.pixels.size(); ++q) truth.pixels[q] = std::max(truth.pixels[q], m.pixels[q]);
        }
      picture = scaled(picture, 640, 360), truth = scaled(truth, 640, 360);
      Random random(++i);
      Image base = doubtful_matte(picture, truth, random);
      all.push_back({text("two", f, "-", who), std::move(picture), std::move(truth), std::move(base)});
    }
  return all;
}
void run(const std::vector<Scene>& scenes, int each, int strokes) {
  Tally sum;
  const std::clock_t begin = std::clock();
  for (const Scene& s : scenes)
    for (int i = 0; i < each; ++i) {
      const Tally t = play(s, 1000 + i, strokes);
      sum.n += t.n, sum.drops += t.drops, sum.worst = std::min(sum.worst, t.worst);
      sum.first += t.first / (scenes.size() * each), sum.last += t.last / (scenes.size() * each);
    }
  std::printf("%zu scenes: %d strokes, %d drops, worst %.4f; IoU %.4f -> %.4f; %.0f ms a replay\n", scenes.size(), sum.n,
              sum.drops, sum.worst, sum.first, sum.last,
              1000.0 * (std::clock() - begin) / CLOCKS_PER_SEC / sum.n);
}
TEST(GuideExperiment, Synthetic) { run(synthetic(20), 3, 6); }
TEST(GuideExperiment, DomeKey) { run(dome("green-dome", true, 3), 2, 6); }
TEST(GuideExperiment, DomeCut) { run(dome("green-dome", false, 2), 2, 6); }
TEST(GuideExperiment, WdShow) {
  for (const Scene& s : dome("green-dome-wd", true, 1)) {
    std::printf("%s %.4f\n", s.name.c_str(), overlap(s.base, s.truth));
    dump(s.name, s, s.base, s.base, {});
  }
}
TEST(GuideExperiment, WdKey) { run(dome("green-dome-wd", true, 4), 1, 6); }
TEST(GuideExperiment, Persons) { run(persons(), 2, 6); }
}  // namespace
}  // namespace floatstage::matting
