#include "core/grid_cut.h"

#include <gtest/gtest.h>

#include "core/check.h"
#include "core/graph_cut.h"
#include "core/random.h"

namespace floatstage {
namespace {

struct Grid {
  int width = 1, height = 1;
  std::vector<std::uint8_t> members;      // with a border
  std::vector<std::int32_t> from_source;  // by place among `members`
  std::vector<GridCut::Room> prices;

  int stride() const { return width + 2; }
  std::array<int, 8> offsets() const {
    const int s = stride();
    return {1, -1, s, -s, s + 1, -s - 1, s - 1, -s + 1};
  }
  bool has(int node) const { return members[static_cast<std::size_t>(node)] != 0; }
};

// Regions that pull to either side, with noise, as pictures have them; `share` of the pixels are members.
Grid random_grid(Random& random, int width, int height, double share, int most) {
  Grid g{width, height, {}, {}, {}};
  const auto below = [&](int n) { return static_cast<int>(random.uniform(0, n - 1e-9)); };
  const std::size_t size = static_cast<std::size_t>(g.stride()) * static_cast<std::size_t>(height + 2);
  g.members.assign(size, 0);
  g.from_source.assign(size, 0);
  g.prices.assign(size, {});
  const int middle = below(width);
  for (int y = 1; y <= height; ++y)
    for (int x = 1; x <= width; ++x) {
      const auto p = static_cast<std::size_t>(y * g.stride() + x);
      g.members[p] = random.uniform() < share ? 1 : 0;
      if (g.members[p]) g.from_source[p] = below(2 * most + 1) - most + (x < middle ? most / 2 : -most / 2);
    }
  const auto offsets = g.offsets();
  for (std::size_t p = 0; p < size; ++p)
    for (std::size_t d = 0; d < 8; d += 2) {
      if (!g.members[p]) continue;
      const std::size_t q = p + static_cast<std::size_t>(offsets[d]);
      if (g.members[q]) g.prices[p][d] = g.prices[q][d + 1] = below(most);
    }
  return g;
}

void expect_the_cut_of_a_graph(const Grid& g) {
  std::vector<int> node(g.members.size(), -1);
  int nodes = 0;
  for (std::size_t p = 0; p < node.size(); ++p)
    if (g.members[p]) node[p] = nodes++;
  GraphCut graph(nodes);
  GridCut grid(g.width, g.height, g.members);
  const auto offsets = g.offsets();
  for (std::size_t p = 0; p < node.size(); ++p) {
    if (node[p] < 0) continue;
    grid.set(static_cast<int>(p), g.from_source[p], g.prices[p]);
    graph.add_terminals(node[p], std::max(g.from_source[p], 0), std::max(-g.from_source[p], 0));
    for (std::size_t d = 0; d < 8; d += 2) {
      const std::size_t q = p + static_cast<std::size_t>(offsets[d]);
      if (node[q] >= 0) graph.add_edge(node[p], node[q], g.prices[p][d], g.prices[p][d]);
    }
  }
  EXPECT_EQ(grid.solve(), graph.solve());
  for (std::size_t p = 0; p < node.size(); ++p) {
    if (node[p] < 0) continue;
    ASSERT_EQ(grid.on_source_side(static_cast<int>(p)), graph.on_source_side(node[p])) << p;
  }
}

TEST(GridCut, IsTheCutOfTheSameGraph) {
  Random random(11);
  for (int trial = 0; trial < 400; ++trial)
    expect_the_cut_of_a_graph(
        random_grid(random, 1 + trial % 13, 1 + trial % 7, trial % 3 ? 0.8 : 1, 2 + trial % 9));
  for (const int most : {3, 1000})
    for (const double share : {0.3, 1.0}) expect_the_cut_of_a_graph(random_grid(random, 90, 70, share, most));
}

TEST(GridCut, OfNobodyHasNoCost) {
  const std::vector<std::uint8_t> none(5 * 4, 0);
  EXPECT_EQ(GridCut(3, 2, none).solve(), 0);
}

TEST(GridCut, WithoutABorderIsOurBug) {
  const std::vector<std::uint8_t> members(3 * 2, 1);
  EXPECT_THROW(GridCut(3, 2, members), CheckFailure);
}

}  // namespace
}  // namespace floatstage
