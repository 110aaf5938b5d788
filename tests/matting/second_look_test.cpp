#include "matting/keyers/second_look.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/imgproc.hpp>

#include "matting/color_model.h"
#include "matting/frame_cut.h"
#include "tests/matting/pictures.h"

namespace floatstage::matting {
namespace {

// second_look() over whole pictures.
namespace slow {

constexpr double kReach = 0.03;  // of the longer side: how far from the key's outline pixels are asked
constexpr float kWord = 2.5f;    // log-odds of the key's own word
constexpr float kMost = 4;       // log-odds of a colour, at most
constexpr double kSmooth = 3;    // as for clips (video/clip_cut.h)

Image square_roots(const Image& picture) {
  std::array<std::uint8_t, 256> table;
  for (std::size_t v = 0; v < table.size(); ++v)
    table[v] = static_cast<std::uint8_t>(std::lround(std::sqrt(255.0 * static_cast<double>(v))));
  Image roots = picture;
  for (std::uint8_t& v : roots.pixels) v = table[v];
  return roots;
}

cv::Mat square(int radius) {
  return cv::getStructuringElement(cv::MORPH_RECT, {2 * radius + 1, 2 * radius + 1});
}

Image second_look(const Image& picture, const Image& key) {
  const cv::Mat alpha(key.height, key.width, CV_8U, const_cast<std::uint8_t*>(key.pixels.data()));
  const cv::Mat subject = alpha >= 128;
  const int reach = std::max(1, static_cast<int>(std::lround(kReach * std::max(key.width, key.height))));
  cv::Mat inside, around;
  cv::erode(subject, inside, square(std::max(1, reach / 10)));
  cv::dilate(subject, around, square(reach));
  if (cv::countNonZero(inside) == 0 || cv::countNonZero(around == 0) == 0) return key;

  const Image roots = square_roots(picture);
  ColorModel of_subject, of_stage;
  const auto in_rim = [&](std::size_t p) {
    const int x = static_cast<int>(p % static_cast<std::size_t>(key.width)),
              y = static_cast<int>(p / static_cast<std::size_t>(key.width));
    return x < reach || y < reach || x >= key.width - reach || y >= key.height - reach;
  };
  for (std::size_t p = 0; p < key.pixels.size(); ++p) {
    const bool rim = in_rim(p);
    if (inside.data[p] && !rim) of_subject.add(roots.pixels.data() + 3 * p);
    if (rim || !around.data[p]) of_stage.add(roots.pixels.data() + 3 * p);
  }
  of_subject.finish();
  of_stage.finish();

  CutEvidence evidence;
  evidence.odds.assign(key.pixels.size(), -kWord);
  evidence.asked.assign(around.data, around.data + key.pixels.size());
  for (std::size_t p = 0; p < key.pixels.size(); ++p) {
    if (!evidence.asked[p]) continue;
    const std::uint8_t* c = roots.pixels.data() + 3 * p;
    const float word = in_rim(p) ? -kWord : kWord * (static_cast<float>(key.pixels[p]) / 127.5f - 1);
    evidence.odds[p] =
        word + std::clamp(std::log(of_subject.likelihood(c) / of_stage.likelihood(c)), -kMost, kMost);
  }
  const Image cut = cut_frame(roots, evidence, kSmooth);
  Image out = key;
  for (std::size_t p = 0; p < out.pixels.size(); ++p) {
    const bool was = key.pixels[p] >= 128, is = cut.pixels[p] >= 128;
    if (was != is) out.pixels[p] = is ? 255 : 0;
  }
  return out;
}

}  // namespace slow

// A subject before a backing, and a key of it that has bitten and bulged.
struct Doubtful {
  Image picture, key;
};

Doubtful doubtful(int width, int height, double noise, std::uint64_t seed) {
  Scene scene;
  scene.width = width;
  scene.height = height;
  scene.radius = height / 3.0;
  scene.noise = noise;
  Doubtful d{photograph(scene, seed), to_image(truth(scene))};
  Random random(seed);
  for (int i = 0; i < 12; ++i) {
    const int x0 = static_cast<int>(random.uniform(0, width)),
              y0 = static_cast<int>(random.uniform(0, height));
    const auto value = static_cast<std::uint8_t>(random.uniform(0, 256));
    for (int y = y0; y < std::min(y0 + height / 12 + 1, height); ++y)
      for (int x = x0; x < std::min(x0 + width / 12 + 1, width); ++x) *d.key.at(x, y) = value;
  }
  return d;
}

TEST(SecondLook, GivesTheBytesOfTheSlowMethod) {
  for (const auto& [width, height] :
       {std::pair(160, 120), std::pair(333, 200), std::pair(64, 64), std::pair(9, 30)})
    for (const double noise : {0.0, 4.0, 20.0}) {
      const Doubtful d = doubtful(width, height, noise, 3);
      EXPECT_EQ(second_look(d.picture, d.key), slow::second_look(d.picture, d.key)) << width << ' ' << noise;
    }
}

TEST(SecondLook, LeavesTheKeyWithoutSubjectOrWithoutStage) {
  const Image picture(40, 30, 3, 90);
  for (const int value : {0, 127, 255}) {
    const Image key(40, 30, 1, static_cast<std::uint8_t>(value));
    EXPECT_EQ(second_look(picture, key), key) << value;
  }
}

}  // namespace
}  // namespace floatstage::matting
