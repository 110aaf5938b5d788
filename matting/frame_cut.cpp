// Method:  the cheapest split of a frame into subject and background: a minimum cut
// Paper:   Y. Boykov, M.-P. Jolly, "Interactive graph cuts", 2001; J. Sun and others, "Background cut",
//          2006
// Differs: edges that the backdrop has itself cost nothing extra
// ADR:     0102

#include "matting/frame_cut.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/graph_cut.h"

namespace floatstage::matting {
namespace {

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

}  // namespace

Image cut_frame(const Image& picture, const CutEvidence& evidence, double smooth) {
  const int w = picture.width, h = picture.height;
  FLOATSTAGE_CHECK(picture.channels == 3 && evidence.odds.size() == evidence.asked.size() &&
                       evidence.odds.size() == static_cast<std::size_t>(w) * static_cast<std::size_t>(h),
                   "evidence of the picture's size");
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

}  // namespace floatstage::matting
