#include "matting/frame_cut.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/random.h"

namespace floatstage::matting {
namespace {

Image noise(int width, int height, Random& random) {
  Image picture(width, height, 3);
  for (std::uint8_t& v : picture.pixels) v = static_cast<std::uint8_t>(random.uniform() * 255);
  return picture;
}

// What frame_cut.h promises to minimise, written down again, pixel pair by pixel pair.
double energy(const Image& picture, const CutEvidence& e, double smooth, unsigned labels) {
  const int w = picture.width, h = picture.height;
  const auto square = [&](int p, int q) {
    double sum = 0;
    for (int c = 0; c < 3; ++c)
      sum += std::pow(picture.pixels[static_cast<std::size_t>(3 * p + c)] -
                          picture.pixels[static_cast<std::size_t>(3 * q + c)],
                      2);
    return sum;
  };
  double contrast = 0, cost = 0;
  int pairs = 0;
  for (int pass = 0; pass < 2; ++pass)
    for (int p = 0; p < w * h; ++p)
      for (int q = p + 1; q < w * h; ++q) {
        const int dx = std::abs(p % w - q % w), dy = q / w - p / w;
        if (dx > 1 || dy > 1) continue;
        if (pass == 0) contrast += square(p, q), ++pairs;
        if (pass == 1 && (labels >> p & 1) != (labels >> q & 1))
          cost +=
              smooth * std::max(0.05, std::exp(-pairs / (2 * contrast) * square(p, q))) / std::hypot(dx, dy);
      }
  for (int p = 0; p < w * h; ++p)
    cost += (labels >> p & 1) ? std::max(0.0f, -e.odds[static_cast<std::size_t>(p)])
                              : std::max(0.0f, e.odds[static_cast<std::size_t>(p)]);
  return cost;
}

TEST(FrameCut, FindsTheCheapestOfAllSplits) {
  Random random(3);
  for (int trial = 0; trial < 30; ++trial) {
    const Image picture = noise(4, 3, random);
    CutEvidence e{std::vector<float>(12), std::vector<std::uint8_t>(12, 1), {}};
    for (float& o : e.odds) o = static_cast<float>(4 * random.uniform() - 2);
    const double smooth = 1.5;
    double least = 1e9;
    for (unsigned labels = 0; labels < 1u << 12; ++labels)
      least = std::min(least, energy(picture, e, smooth, labels));
    const Image cut = cut_frame(picture, e, smooth);
    unsigned found = 0;
    for (unsigned p = 0; p < 12; ++p) found |= cut.pixels[p] ? 1u << p : 0;
    EXPECT_NEAR(energy(picture, e, smooth, found), least, 0.02) << "trial " << trial;
  }
}

TEST(FrameCut, WhoIsNotAskedIsBackground) {
  CutEvidence e{std::vector<float>(16, 5), std::vector<std::uint8_t>(16, 1), {}};
  e.asked[5] = 0;
  const Image cut = cut_frame(Image(4, 4, 3, 90), e, 0.1);
  for (std::size_t p = 0; p < 16; ++p) EXPECT_EQ(cut.pixels[p], p == 5 ? 0 : 255) << p;
  e.asked.assign(16, 0);
  EXPECT_EQ(cut_frame(Image(4, 4, 3, 90), e, 1), Image(4, 4, 1)) << "nobody is asked";
}

TEST(FrameCut, WhoIsSettledPullsThoseWhoAreAsked) {
  CutEvidence e{std::vector<float>(16, -0.2f), std::vector<std::uint8_t>(16, 1), {}};
  EXPECT_EQ(cut_frame(Image(4, 4, 3, 90), e, 2), Image(4, 4, 1));
  for (std::size_t p = 0; p < 16; p += 4) e.asked[p] = 2;
  EXPECT_EQ(cut_frame(Image(4, 4, 3, 90), e, 2), Image(4, 4, 1, 255));
}

TEST(FrameCut, TheBackdropsOwnEdgesDoNotAttractTheOutline) {
  // Columns 0-3 dark, 4-7 bright; certain background at the left, certain subject at the right, the rest is
  // open.
  Image picture(8, 6, 3, 40);
  CutEvidence e{std::vector<float>(48), std::vector<std::uint8_t>(48, 1), std::vector<float>(48, 1)};
  for (int y = 0; y < 6; ++y)
    for (int x = 0; x < 8; ++x) {
      for (int c = 0; c < 3 && x >= 4; ++c) picture.at(x, y)[c] = 200;
      e.odds[static_cast<std::size_t>(8 * y + x)] = x == 0 ? -100.0f : x == 7 ? 100.0f : x < 6 ? -0.2f : 0.2f;
    }
  EXPECT_EQ(*cut_frame(picture, e, 3).at(4, 3), 255) << "a step of the picture is where the outline goes";
  e.calm.assign(48, 0);
  EXPECT_EQ(*cut_frame(picture, e, 3).at(4, 3), 0) << "unless the backdrop has it too";
}

}  // namespace
}  // namespace floatstage::matting
