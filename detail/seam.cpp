// Optimal partitioning: M. Eisemann, section 4.3.2.1,
// after J. Jia, J. Sun, C. Tang, H. Shum, "Drag-and-Drop
// Pasting", SIGGRAPH 2006, solved as a minimum cut (V. Kwatra et al., "Graphcut Textures", SIGGRAPH 2003) by
// the solver in core/graph_cut.h. Differs: no object is drawn by the user, a core is the child's (ADR 0217).

#include "detail/seam.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/graph_cut.h"

namespace floatstage::detail {
namespace {

constexpr int kLongest = 512, kRim = 2, kMostRounds = 5;
constexpr double kCore = 0.15, kCosts = 1e5;  // steps of a whole difference
constexpr std::int32_t kNever = 1 << 28;

enum class Side : std::uint8_t { Parent, Child, Open };

struct Problem {
  int width = 0, height = 0;
  std::vector<Light> difference;  // parent - child, encoded
  std::vector<Side> sides;
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * width + x; }
};

Light mean_of(const Problem& p, const std::vector<std::uint8_t>& child) {
  double sum[3] = {}, count = 0;
  for (int y = 0; y + 1 < p.height; ++y)
    for (int x = 0; x + 1 < p.width; ++x) {
      const std::size_t i = p.at(x, y);
      for (const std::size_t j : {i + 1, p.at(x, y + 1)}) {
        if (child[i] == child[j]) continue;
        ++count;
        for (std::size_t k = 0; k < 3; ++k) sum[k] += 0.5 * (p.difference[i][k] + p.difference[j][k]);
      }
    }
  Light mean{};
  for (std::size_t k = 0; k < 3 && count > 0; ++k) mean[k] = static_cast<float>(sum[k] / count);
  return mean;
}

float off(const Light& d, const Light& mean) {
  float sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += (d[k] - mean[k]) * (d[k] - mean[k]);
  return sum;
}

double energy_of(const Problem& p, const std::vector<std::uint8_t>& child, const Light& mean) {
  double sum = 0;
  for (int y = 0; y + 1 < p.height; ++y)
    for (int x = 0; x + 1 < p.width; ++x) {
      const std::size_t i = p.at(x, y);
      for (const std::size_t j : {i + 1, p.at(x, y + 1)})
        if (child[i] != child[j]) sum += off(p.difference[i], mean) + off(p.difference[j], mean);
    }
  return sum;
}

// Only what is open becomes a node; a neighbour that is decided is a terminal.
std::vector<std::uint8_t> cut(const Problem& p, const Light& mean) {
  std::vector<std::int32_t> node(p.sides.size(), -1);
  int nodes = 0;
  for (std::size_t i = 0; i < node.size(); ++i)
    if (p.sides[i] == Side::Open) node[i] = nodes++;
  GraphCut graph(nodes, 2 * static_cast<std::size_t>(nodes));
  const auto join = [&](std::size_t i, std::size_t j) {
    if (node[i] < 0 && node[j] < 0) return;
    // A length of its own keeps a seam short where nothing differs.
    const auto cost =
        static_cast<std::int32_t>(std::lround(
            kCosts * static_cast<double>(off(p.difference[i], mean) + off(p.difference[j], mean)))) +
        4;
    if (node[i] >= 0 && node[j] >= 0) return graph.add_edge(node[i], node[j], cost, cost);
    const std::size_t open = node[i] >= 0 ? i : j, decided = node[i] >= 0 ? j : i;
    const bool child = p.sides[decided] == Side::Child;
    graph.add_terminals(node[open], child ? std::min(cost, kNever) : 0, child ? 0 : std::min(cost, kNever));
  };
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      if (x + 1 < p.width) join(p.at(x, y), p.at(x + 1, y));
      if (y + 1 < p.height) join(p.at(x, y), p.at(x, y + 1));
    }
  graph.solve();
  std::vector<std::uint8_t> child(p.sides.size());
  for (std::size_t i = 0; i < child.size(); ++i)
    child[i] = p.sides[i] == Side::Open ? graph.on_source_side(node[i]) : p.sides[i] == Side::Child;
  return child;
}

// Cut, take the mean along the cut, and again while that makes it cheaper.
Seam best_cut(const Problem& p, Light mean, int rounds) {
  Seam best;
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::uint8_t> child = cut(p, mean);
    mean = mean_of(p, child);
    const double energy = energy_of(p, child, mean);
    if (round > 0 && energy >= 0.999 * best.energy) break;
    best = {std::move(child), energy};
  }
  return best;
}

Problem problem_of(const LightPicture& child, const LightPicture& parent,
                   const std::vector<std::uint8_t>& same) {
  Problem p{child.width, child.height, {}, {}};
  p.difference.resize(child.pixels.size());
  p.sides.resize(child.pixels.size());
  const double core = kCore * std::min(p.width, p.height);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      const std::size_t i = p.at(x, y);
      for (std::size_t k = 0; k < 3; ++k)
        p.difference[i][k] = encoded(parent.pixels[i][k]) - encoded(child.pixels[i][k]);
      const int depth = std::min({x, y, p.width - 1 - x, p.height - 1 - y});
      p.sides[i] = depth < kRim || same[i] == 0 ? Side::Parent : depth > core ? Side::Child : Side::Open;
    }
  return p;
}

// Means over blocks; a block with something else in it is the parent's.
Problem shrunk(const Problem& p, int factor) {
  Problem s{(p.width + factor - 1) / factor, (p.height + factor - 1) / factor, {}, {}};
  s.difference.resize(static_cast<std::size_t>(s.width) * s.height, Light{});
  s.sides.resize(s.difference.size(), Side::Child);
  std::vector<float> count(s.difference.size(), 0);
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      const std::size_t i = p.at(x, y), to = s.at(x / factor, y / factor);
      for (std::size_t k = 0; k < 3; ++k) s.difference[to][k] += p.difference[i][k];
      count[to] += 1;
      if (p.sides[i] == Side::Parent) s.sides[to] = Side::Parent;
      if (p.sides[i] == Side::Open && s.sides[to] == Side::Child) s.sides[to] = Side::Open;
    }
  for (std::size_t i = 0; i < count.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) s.difference[i][k] /= count[i];
  return s;
}

// Decides what lies farther from the coarse seam than a block: only the band stays open.
void narrow(Problem& p, const Problem& coarse, const std::vector<std::uint8_t>& child, int factor) {
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      Side& side = p.sides[p.at(x, y)];
      if (side != Side::Open) continue;
      const int u = x / factor, v = y / factor;
      const std::uint8_t here = child[coarse.at(u, v)];
      bool near = false;
      for (int b = std::max(0, v - 1); b <= std::min(coarse.height - 1, v + 1); ++b)
        for (int a = std::max(0, u - 1); a <= std::min(coarse.width - 1, u + 1); ++a)
          near = near || child[coarse.at(a, b)] != here;
      if (!near) side = here != 0 ? Side::Child : Side::Parent;
    }
}

}  // namespace

Seam find_seam(const LightPicture& child, const LightPicture& parent, const std::vector<std::uint8_t>& same) {
  FLOATSTAGE_CHECK(child.pixels.size() == parent.pixels.size() && same.size() == child.pixels.size(),
                   "one size");
  Problem whole = problem_of(child, parent, same);
  const int factor = (std::max(whole.width, whole.height) + kLongest - 1) / kLongest;
  if (factor <= 1) return best_cut(whole, {}, kMostRounds);
  const Problem coarse = shrunk(whole, factor);
  const Seam first = best_cut(coarse, {}, kMostRounds);
  const Light mean = mean_of(coarse, first.child);
  narrow(whole, coarse, first.child, factor);
  return best_cut(whole, mean, 1);
}

}  // namespace floatstage::detail
