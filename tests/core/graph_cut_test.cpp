#include "core/graph_cut.h"

#include <bit>

#include <gtest/gtest.h>

#include "core/check.h"
#include "core/random.h"

namespace floatstage {
namespace {

struct Edge {
  int a, b;
  std::int32_t there, back;
};
struct Graph {
  std::vector<std::int32_t> from_source, to_sink;
  std::vector<Edge> edges;
  int nodes() const { return static_cast<int>(from_source.size()); }
};

Graph random_graph(Random& random) {
  const auto below = [&](int n) { return static_cast<int>(random.uniform(0, n - 1e-9)); };
  Graph g;
  const int nodes = 1 + below(9);
  for (int i = 0; i < nodes; ++i) {
    g.from_source.push_back(below(3) ? below(10) : 0);
    g.to_sink.push_back(below(3) ? below(10) : 0);
  }
  for (int i = below(2 * nodes + 1); i > 0; --i) {
    const Edge e{below(nodes), below(nodes), below(8), below(8)};
    if (e.a != e.b) g.edges.push_back(e);
  }
  return g;
}

std::int64_t cost_of(const Graph& g, unsigned source_side) {
  std::int64_t cost = 0;
  for (int i = 0; i < g.nodes(); ++i)
    cost += (source_side >> i) & 1 ? g.to_sink[static_cast<std::size_t>(i)]
                                   : g.from_source[static_cast<std::size_t>(i)];
  for (const Edge& e : g.edges) {
    const bool a = (source_side >> e.a) & 1, b = (source_side >> e.b) & 1;
    if (a && !b) cost += e.there;
    if (b && !a) cost += e.back;
  }
  return cost;
}

TEST(GraphCut, IsTheCheapestSplitWithTheSmallestSourceSideOfEverySmallGraph) {
  Random random(7);
  for (int trial = 0; trial < 3000; ++trial) {
    const Graph g = random_graph(random);
    GraphCut cut(g.nodes());
    for (int i = 0; i < g.nodes(); ++i)
      cut.add_terminals(i, g.from_source[static_cast<std::size_t>(i)],
                        g.to_sink[static_cast<std::size_t>(i)]);
    for (const Edge& e : g.edges) cut.add_edge(e.a, e.b, e.there, e.back);
    const std::int64_t cost = cut.solve();
    unsigned best = 0, found = 0;
    for (unsigned side = 0; side < 1u << g.nodes(); ++side) {
      const std::int64_t c = cost_of(g, side), least = cost_of(g, best);
      if (c < least || (c == least && std::popcount(side) < std::popcount(best))) best = side;
    }
    for (int i = 0; i < g.nodes(); ++i) found |= static_cast<unsigned>(cut.on_source_side(i)) << i;
    ASSERT_EQ(cost, cost_of(g, best)) << trial;
    ASSERT_EQ(found, best) << trial;
  }
}

TEST(GraphCut, ForgetsItsGraphWhenItIsReset) {
  GraphCut cut(2);
  cut.add_terminals(0, 5, 0);
  cut.add_edge(0, 1, 3, 3);
  cut.add_terminals(1, 0, 4);
  EXPECT_EQ(cut.solve(), 3);
  cut.reset(1);
  cut.add_terminals(0, 2, 7);
  EXPECT_EQ(cut.solve(), 2);
  EXPECT_FALSE(cut.on_source_side(0));
}

TEST(GraphCut, OfNothingCostsNothing) { EXPECT_EQ(GraphCut(0).solve(), 0); }

TEST(GraphCut, TakesNoNegativeCapacityAndNoEdgeToItself) {
  GraphCut cut(2);
  EXPECT_THROW(cut.add_terminals(0, -1, 0), CheckFailure);
  EXPECT_THROW(cut.add_edge(0, 0, 1, 1), CheckFailure);
  EXPECT_THROW(cut.add_edge(0, 1, 1, -1), CheckFailure);
}

}  // namespace
}  // namespace floatstage
