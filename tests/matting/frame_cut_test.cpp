#include "matting/frame_cut.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/graph_cut.h"
#include "core/random.h"

namespace floatstage::matting {
namespace {

Image noise(int width, int height, Random& random) {
  Image picture(width, height, 3);
  for (std::uint8_t& v : picture.pixels) v = static_cast<std::uint8_t>(random.uniform() * 255);
  return picture;
}

// cut_frame() as a graph of nodes and edges that are written down, one by one.
namespace slow {

constexpr float kUnit = 1000;  // whole steps of the cut, which keep it exact and repeatable
constexpr std::uint8_t kSubject = 2;
constexpr float kFloor = 0.05f;  // of the smoothness: edges are never for nothing

struct Step {
  int dx, dy;
  float length;
};
constexpr Step kSteps[] = {{1, 0, 1}, {0, 1, 1}, {1, 1, 1.41421356f}, {-1, 1, 1.41421356f}};

float difference(const std::uint8_t* a, const std::uint8_t* b) {
  const float r = static_cast<float>(a[0] - b[0]), g = static_cast<float>(a[1] - b[1]),
              u = static_cast<float>(a[2] - b[2]);
  return r * r + g * g + u * u;
}

bool is_asked(const CutEvidence& evidence, std::size_t p) {
  return evidence.asked[p] != 0 && evidence.asked[p] != kSubject;
}

int whole(float v) { return static_cast<int>(std::lround(kUnit * v)); }

Image cut_frame(const Image& picture, const CutEvidence& evidence, double smooth) {
  const int w = picture.width, h = picture.height;
  std::vector<int> node(evidence.odds.size(), -1);
  int nodes = 0;
  double contrast = 0;
  long pairs = 0;
  const auto each_pair = [&](const auto& what) {
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x)
        for (const Step& s : kSteps) {
          if (x + s.dx < 0 || x + s.dx >= w || y + s.dy >= h) continue;
          const std::size_t p = static_cast<std::size_t>(y) * w + x,
                            q = static_cast<std::size_t>(y + s.dy) * w + static_cast<std::size_t>(x + s.dx);
          if (is_asked(evidence, p) || is_asked(evidence, q)) what(p, q, s.length);
        }
  };
  for (std::size_t p = 0; p < node.size(); ++p)
    if (is_asked(evidence, p)) node[p] = nodes++;
  Image out(w, h, 1);
  for (std::size_t p = 0; p < node.size(); ++p)
    if (evidence.asked[p] == kSubject) out.pixels[p] = 255;
  if (nodes == 0) return out;
  const auto colour = [&](std::size_t p) { return picture.pixels.data() + 3 * p; };
  each_pair(
      [&](std::size_t p, std::size_t q, float) { contrast += difference(colour(p), colour(q)), ++pairs; });
  const float beta = contrast > 0 ? static_cast<float>(static_cast<double>(pairs) / (2 * contrast)) : 0;

  GraphCut graph(nodes, static_cast<std::size_t>(nodes) * 4);
  std::vector<float> odds(static_cast<std::size_t>(nodes));
  for (std::size_t p = 0; p < node.size(); ++p)
    if (node[p] >= 0) odds[static_cast<std::size_t>(node[p])] = evidence.odds[p];
  each_pair([&](std::size_t p, std::size_t q, float length) {
    const float calm = evidence.calm.empty() ? 1 : std::min(evidence.calm[p], evidence.calm[q]);
    const float alike = std::exp(-beta * calm * difference(colour(p), colour(q)));
    const float weight = static_cast<float>(smooth) * std::max(alike, kFloor) / length;
    if (node[p] >= 0 && node[q] >= 0)
      graph.add_edge(node[p], node[q], whole(weight), whole(weight));
    else  // the other one is settled
      odds[static_cast<std::size_t>(std::max(node[p], node[q]))] +=
          evidence.asked[node[p] >= 0 ? q : p] == kSubject ? weight : -weight;
  });
  for (int i = 0; i < nodes; ++i)
    graph.add_terminals(i, whole(std::max(0.0f, odds[static_cast<std::size_t>(i)])),
                        whole(std::max(0.0f, -odds[static_cast<std::size_t>(i)])));
  graph.solve();
  for (std::size_t p = 0; p < node.size(); ++p)
    if (node[p] >= 0 && graph.on_source_side(node[p])) out.pixels[p] = 255;
  return out;
}

}  // namespace slow

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

// A picture with noise of two colours; what is asked, settled and calm in patches.
struct Patches {
  Image picture;
  CutEvidence evidence;
};

Patches patches(int width, int height, double noise, Random& random) {
  Patches s{Image(width, height, 3), {}};
  const auto pixel = [&](int x, int y) { return static_cast<std::size_t>(y * width + x); };
  s.evidence.odds.resize(pixel(0, height));
  s.evidence.asked.resize(pixel(0, height));
  const double u = random.uniform(), v = random.uniform();
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool left = x < u * width, above = y < v * height;
      for (int c = 0; c < 3; ++c)
        s.picture.at(x, y)[c] =
            static_cast<std::uint8_t>(std::clamp((left ? 60 : 140) + noise * random.normal(), 0.0, 255.0));
      s.evidence.odds[pixel(x, y)] = static_cast<float>((left ? 1 : -1) + 2 * random.normal());
      s.evidence.asked[pixel(x, y)] =
          static_cast<std::uint8_t>(x % 17 == 3 && above                               ? 2
                                    : (x + y) % 23 == 5 || (!above && x > 0.9 * width) ? 0
                                                                                       : 1 + 2 * (x % 2));
    }
  return s;
}

TEST(FrameCut, IsTheCutOfAGraphThatIsWrittenDown) {
  Random random(5);
  for (const auto& [width, height] : {std::pair(1, 1), std::pair(2, 40), std::pair(31, 1), std::pair(70, 50)})
    for (const double noise : {0.0, 3.0, 60.0})
      for (const double smooth : {0.0, 3.0, 100.0}) {
        Patches s = patches(width, height, noise, random);
        EXPECT_EQ(cut_frame(s.picture, s.evidence, smooth), slow::cut_frame(s.picture, s.evidence, smooth))
            << width << ' ' << noise << ' ' << smooth;
        for (std::size_t i = 0; i < s.evidence.odds.size(); ++i)
          s.evidence.calm.push_back(static_cast<float>(random.uniform()));
        EXPECT_EQ(cut_frame(s.picture, s.evidence, smooth), slow::cut_frame(s.picture, s.evidence, smooth))
            << "calm, " << width << ' ' << noise << ' ' << smooth;
      }
}

}  // namespace
}  // namespace floatstage::matting
