#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace floatstage {

/// The cheapest split of a graph's nodes into a source's and a sink's side: minimum cut by maximum flow, with
/// the two search trees of Y. Boykov and V. Kolmogorov, "An Experimental Comparison of Min-Cut/Max-Flow
/// Algorithms for Energy Minimization in Vision", PAMI 2004, which suit the shallow graphs of pictures.
///
/// Capacities are whole numbers >= 0, so that the cut is exact; round weights of your own to, say, 1/1000.
/// Of several cheapest cuts it is the one with the smallest source side, so the answer does not depend on the
/// order in which edges were added. Not for two threads at once. Memory: 24 bytes a node, 32 an edge.
class GraphCut {
 public:
  /// `nodes` >= 0, numbered from 0; `edges` is only a hint for memory.
  explicit GraphCut(int nodes, std::size_t edges = 0);

  /// Empties the graph, keeping its memory.
  void reset(int nodes);
  /// Added to what the node has: cutting it off the source costs `from_source` (the node is then on the
  /// sink's side), off the sink `to_sink`.
  void add_terminals(int node, std::int32_t from_source, std::int32_t to_sink);
  /// An edge between two different nodes: `there` is paid when `a` is on the source's side and `b` on the
  /// sink's, `back` for the opposite.
  void add_edge(int a, int b, std::int32_t there, std::int32_t back);

  /// The cost of the cheapest cut. To be called once after the graph is complete.
  std::int64_t solve();
  /// After solve().
  bool on_source_side(int node) const { return nodes_[static_cast<std::size_t>(node)].tree == Tree::Source; }

 private:
  enum class Tree : std::uint8_t { Free, Source, Sink };
  struct Node {
    std::int32_t first = -1;    // its newest arc
    std::int32_t parent = -1;   // arc towards the root of its tree; or one of the marks below
    std::int32_t stamp = 0;     // when `distance` was last right
    std::int32_t distance = 0;  // to the root, in arcs
    std::int32_t residual = 0;  // > 0: from the source; < 0: to the sink
    Tree tree = Tree::Free;
    bool active = false;  // waits in the queue
  };
  struct Arc {  // arc e and its way back, e ^ 1
    std::int32_t head, next, residual;
  };

  void start();
  std::int32_t grow(int node);
  void augment(std::int32_t bridge);
  std::int32_t bottleneck(std::int32_t bridge) const;
  void push(int node, Tree tree, std::int32_t flow);
  void orphan(int node);
  void adopt();
  bool find_parent(int node);
  int distance_to_root(int node);
  void wake(int node);

  Node& at(int node) { return nodes_[static_cast<std::size_t>(node)]; }
  const Node& at(int node) const { return nodes_[static_cast<std::size_t>(node)]; }
  Arc& arc(std::int32_t e) { return arcs_[static_cast<std::size_t>(e)]; }
  const Arc& arc(std::int32_t e) const { return arcs_[static_cast<std::size_t>(e)]; }

  std::vector<Node> nodes_;
  std::vector<Arc> arcs_;
  std::vector<int> queue_, orphans_;
  std::size_t queue_next_ = 0;
  std::int32_t now_ = 0;
  std::int64_t flow_ = 0;
};

}  // namespace floatstage
