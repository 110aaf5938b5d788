#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace floatstage {

/// GraphCut (core/graph_cut.h) of pixels, each joined with its 8 neighbours at a price that is the same both
/// ways: the same method and the same cut in half the memory, since who is whose neighbour need not be
/// written down. Pixels without terminals and edges cost nothing but 48 bytes.
class GridCut {
 public:
  enum Step : std::uint8_t { Right = 0, Down = 2, DownRight = 4, DownLeft = 6 };

  /// Both > 0.
  GridCut(int width, int height);

  /// A pixel's name.
  int node(int x, int y) const { return (y + 1) * stride_ + x + 1; }
  int next(int node, Step step) const { return node + offsets_[step]; }
  /// > 0: what cutting it off the source costs; < 0: off the sink. To be called once a pixel.
  void set_terminal(int node, std::int32_t from_source) {
    excess_[static_cast<std::size_t>(node)] = from_source;
  }
  /// The edge to a neighbour that lies within; >= 0. To be called once a pair.
  void set_edge(int node, Step step, std::int32_t weight) {
    at(node).room[step] = weight;
    at(node + offsets_[step]).room[step + 1] = weight;
  }
  /// A place to keep a number for an edge until it is set.
  std::int32_t& kept(int node, Step step) { return at(node).room[step]; }

  /// The flow, which is what the cheapest cut costs. To be called once.
  std::int64_t solve();
  /// After solve().
  bool on_source_side(int node) const { return nodes_[static_cast<std::size_t>(node)].tree == Tree::Source; }

 private:
  enum class Tree : std::uint8_t { Free, Source, Sink };
  struct Node {
    // What more may flow to the neighbours: right, left, down, up, down right, up left, down left, up right.
    std::array<std::int32_t, 8> room{};
    std::int32_t stamp = 0;     // when `distance` was last right
    std::int32_t distance = 0;  // to the root
    Tree tree = Tree::Free;
    std::uint8_t parent = 0;  // direction of it; or one of the marks in grid_cut.cpp
    bool active = false;      // waits in the queue
  };

  Node& at(int node) { return nodes_[static_cast<std::size_t>(node)]; }
  const Node& at(int node) const { return nodes_[static_cast<std::size_t>(node)]; }
  std::int32_t& excess(int node) { return excess_[static_cast<std::size_t>(node)]; }
  int neighbour(int node, unsigned direction) const { return node + offsets_[direction]; }
  void start();
  bool among_its_like(int node) const;
  unsigned grow(int node);
  void augment(int node, unsigned direction);
  std::int32_t bottleneck(int node, unsigned direction);
  void push(int node, Tree tree, std::int32_t flow);
  void orphan(int node);
  void adopt();
  bool find_parent(int node);
  int distance_to_root(int node);
  void wake(int node);

  int stride_;
  std::array<int, 8> offsets_;
  std::vector<Node> nodes_;           // with a border that nothing is joined to
  std::vector<std::int32_t> excess_;  // > 0: from the source; < 0: to the sink
  std::vector<int> queue_, orphans_;
  std::size_t queue_next_ = 0;
  std::int32_t now_ = 0;
  std::int64_t flow_ = 0;
};

}  // namespace floatstage
