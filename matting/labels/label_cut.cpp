// Method:  labels of least energy, which core/label_energy.h finds
// Paper:   contrast as in Y. Boykov, M.-P. Jolly, "Interactive graph cuts", 2001
// Differs: pixels that were not asked are fixed and cost nothing
// ADR:     0274

#include "matting/labels/label_cut.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/label_energy.h"

namespace floatstage::matting {
namespace {

constexpr float kUnit = 1000;    // whole steps of the cut, which keep it exact and repeatable
constexpr float kFloor = 0.05f;  // of the smoothness: edges are never for nothing

struct Pair {
  std::size_t p, q;  // at least one of them is asked
  int weight;
};

float difference(const std::uint8_t* a, const std::uint8_t* b) {
  const float r = static_cast<float>(a[0] - b[0]), g = static_cast<float>(a[1] - b[1]),
              u = static_cast<float>(a[2] - b[2]);
  return r * r + g * g + u * u;
}

std::vector<Pair> pairs_of(const Image& picture, const std::vector<std::uint8_t>& asked, double smooth) {
  struct Step {
    int dx, dy;
    float length;
  };
  constexpr Step kSteps[] = {{1, 0, 1}, {0, 1, 1}, {1, 1, 1.41421356f}, {-1, 1, 1.41421356f}};
  const int w = picture.width, h = picture.height;
  double contrast = 0;
  std::vector<Pair> out;
  std::vector<std::pair<float, float>> looks;  // difference, length
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      for (const Step& s : kSteps) {
        if (x + s.dx < 0 || x + s.dx >= w || y + s.dy >= h) continue;
        const std::size_t p = static_cast<std::size_t>(y) * static_cast<std::size_t>(w) +
                              static_cast<std::size_t>(x),
                          q = static_cast<std::size_t>(y + s.dy) * static_cast<std::size_t>(w) +
                              static_cast<std::size_t>(x + s.dx);
        if (!asked[p] && !asked[q]) continue;
        looks.push_back({difference(picture.at(x, y), picture.at(x + s.dx, y + s.dy)), s.length});
        out.push_back({p, q, 0});
        contrast += looks.back().first;
      }
  const float beta =
      contrast > 0 ? static_cast<float>(static_cast<double>(out.size()) / (2 * contrast)) : 0.0f;
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i].weight =
        static_cast<int>(std::lround(kUnit * static_cast<float>(smooth) *
                                     std::max(std::exp(-beta * looks[i].first), kFloor) / looks[i].second));
  return out;
}

}  // namespace

Image cut_labels(const Image& picture, const LabelEvidence& evidence, double smooth) {
  std::vector<int> node(evidence.asked.size(), -1);
  int nodes = 0;
  for (std::size_t p = 0; p < node.size(); ++p)
    if (evidence.asked[p]) node[p] = nodes++;
  FLOATSTAGE_CHECK(
      picture.channels == 3 && evidence.asked.size() == picture.pixels.size() / 3 &&
          evidence.labels.pixels.size() == evidence.asked.size() &&
          evidence.costs.size() == static_cast<std::size_t>(nodes) * static_cast<std::size_t>(evidence.count),
      "evidence of the picture's size");
  Image labels = evidence.labels;
  if (nodes == 0) return labels;
  LabelEnergy energy{evidence.count, {}, {}};
  energy.costs.reserve(evidence.costs.size());
  for (const float cost : evidence.costs) energy.costs.push_back(std::lround(kUnit * cost));
  std::vector<std::uint8_t> found(static_cast<std::size_t>(nodes));
  for (std::size_t p = 0; p < node.size(); ++p)
    if (node[p] >= 0) found[static_cast<std::size_t>(node[p])] = labels.pixels[p];
  const auto beside = [&](std::size_t p, std::size_t fixed, int weight) {
    for (int l = 0; l < evidence.count; ++l)
      if (l != labels.pixels[fixed])
        energy.costs[static_cast<std::size_t>(node[p]) * static_cast<std::size_t>(evidence.count) +
                     static_cast<std::size_t>(l)] += weight;
  };
  for (const Pair& pair : pairs_of(picture, evidence.asked, smooth)) {
    if (node[pair.p] >= 0 && node[pair.q] >= 0)
      energy.pairs.push_back({node[pair.p], node[pair.q], pair.weight});
    else if (node[pair.p] >= 0)
      beside(pair.p, pair.q, pair.weight);
    else
      beside(pair.q, pair.p, pair.weight);
  }
  minimize(energy, found);
  for (std::size_t p = 0; p < node.size(); ++p)
    if (node[p] >= 0) labels.pixels[p] = found[static_cast<std::size_t>(node[p])];
  return labels;
}

}  // namespace floatstage::matting
