// Method:  labels of least energy: expansion moves, each a minimum cut
// Paper:   Y. Boykov, O. Veksler, R. Zabih, "Fast Approximate Energy Minimization via Graph Cuts", PAMI 2001;
//          contrast as in Y. Boykov, M.-P. Jolly, "Interactive graph cuts", 2001
// Differs: pixels that were not asked are fixed and cost nothing
// ADR:     0274

#include "matting/labels/label_cut.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/graph_cut.h"

namespace floatstage::matting {
namespace {

constexpr float kUnit = 1000;    // whole steps of the cut, which keep it exact and repeatable
constexpr float kFloor = 0.05f;  // of the smoothness: edges are never for nothing
constexpr int kRounds = 3;       // of expansions of all labels; the second hardly changes anything

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

// One move: every asked pixel keeps its label or takes `alpha`, whichever is cheapest for all together.
// Whether anything changed.
bool expand(int alpha, const LabelEvidence& e, const std::vector<Pair>& pairs, const std::vector<int>& node,
            int nodes, GraphCut& graph, Image& labels) {
  graph.reset(nodes);
  std::vector<std::int64_t> keep(static_cast<std::size_t>(nodes)), take(static_cast<std::size_t>(nodes));
  for (std::size_t p = 0; p < node.size(); ++p) {
    if (node[p] < 0) continue;
    const std::size_t n = static_cast<std::size_t>(node[p]);
    const float* costs = e.costs.data() + n * static_cast<std::size_t>(e.count);
    keep[n] += std::lround(kUnit * costs[labels.pixels[p]]);
    take[n] += std::lround(kUnit * costs[alpha]);
  }
  for (const Pair& pair : pairs) {
    const int a = labels.pixels[pair.p], b = labels.pixels[pair.q], np = node[pair.p], nq = node[pair.q];
    // What the pair costs when (p, q) keep or take: 00, 01, 10; both taking costs nothing.
    const int c00 = a != b ? pair.weight : 0, c01 = a != alpha ? pair.weight : 0,
              c10 = b != alpha ? pair.weight : 0;
    if (np >= 0 && nq >= 0) {
      // c00 + (c10 - c00) p + (0 - c10) q + (c01 + c10 - c00) (1 - p) q, of which the last is an edge.
      take[static_cast<std::size_t>(np)] += c10 - c00;
      take[static_cast<std::size_t>(nq)] -= c10;
      if (const int edge = c01 + c10 - c00; edge > 0) graph.add_edge(nq, np, edge, 0);
    } else if (np >= 0) {
      keep[static_cast<std::size_t>(np)] += c00;
      take[static_cast<std::size_t>(np)] += b != alpha ? pair.weight : 0;
    } else {
      keep[static_cast<std::size_t>(nq)] += c00;
      take[static_cast<std::size_t>(nq)] += a != alpha ? pair.weight : 0;
    }
  }
  // The source's side takes: cut off the source a pixel pays for keeping.
  for (int n = 0; n < nodes; ++n) {
    const std::int64_t k = keep[static_cast<std::size_t>(n)], t = take[static_cast<std::size_t>(n)],
                       least = std::min(k, t);
    graph.add_terminals(n, static_cast<std::int32_t>(std::min<std::int64_t>(k - least, 1'000'000'000)),
                        static_cast<std::int32_t>(std::min<std::int64_t>(t - least, 1'000'000'000)));
  }
  graph.solve();
  bool changed = false;
  for (std::size_t p = 0; p < node.size(); ++p)
    if (node[p] >= 0 && labels.pixels[p] != alpha && graph.on_source_side(node[p])) {
      labels.pixels[p] = static_cast<std::uint8_t>(alpha);
      changed = true;
    }
  return changed;
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
  const std::vector<Pair> pairs = pairs_of(picture, evidence.asked, smooth);
  GraphCut graph(nodes, pairs.size());
  for (int round = 0; round < kRounds; ++round) {
    bool changed = false;
    for (int alpha = 0; alpha < evidence.count; ++alpha)
      changed |= expand(alpha, evidence, pairs, node, nodes, graph, labels);
    if (!changed) break;
  }
  return labels;
}

}  // namespace floatstage::matting
