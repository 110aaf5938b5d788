#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace floatstage {

/// GraphCut (core/graph_cut.h) of pixels, each joined with its 8 neighbours at a price that is the same both
/// ways: the same method and the same cut in half the memory, since who is whose neighbour need not be
/// written down.
class GridCut {
 public:
  /// `members`: width + 2 by height + 2 bytes, 1 for the pixels that are to be cut, 0 for others and along
  /// the border. Others take memory (49 bytes), but no time. Both sides > 0.
  GridCut(int width, int height, std::span<const std::uint8_t> members);

  /// A pixel's name: its place among `members`.
  int node(int x, int y) const { return (y + 1) * stride_ + x + 1; }
  /// What more may flow to the neighbours: right, left, down, up, down right, up left, down left, up right.
  using Room = std::array<std::int32_t, 8>;
  /// Tells of a member, once. `from_source` > 0: what cutting it off the source costs; < 0: off the sink.
  /// `prices` of parting it from its neighbours: >= 0, 0 where they are no members, and what they say
  /// themselves.
  void set(int node, std::int32_t from_source, const Room& prices) {
    const Tree tree = from_source > 0 ? Tree::Source : from_source < 0 ? Tree::Sink : Tree::Free;
    at(node) = {prices, from_source, 0, 1, tree, from_source != 0 ? kRoot : kNone, false};
    trees_.data()[node] = static_cast<std::uint8_t>(tree);
  }

  /// The flow, which is what the cheapest cut costs. To be called once.
  std::int64_t solve();
  /// After solve(), of a member.
  bool on_source_side(int node) const { return at(node).tree == Tree::Source; }

 private:
  enum class Tree : std::uint8_t { Free, Source, Sink };
  static constexpr std::uint8_t kRoot = 8, kNone = 9, kOrphan = 10;  // of Node::parent, beside directions
  struct Node {
    Room room;
    std::int32_t excess;    // > 0: from the source; < 0: to the sink
    std::int32_t stamp;     // when `distance` was last right
    std::int32_t distance;  // to the root, in edges
    Tree tree;
    std::uint8_t parent;  // direction of it, or a mark
    bool active;          // waits in the queue
  };

  Node& at(int node) { return nodes_[static_cast<std::size_t>(node)]; }
  const Node& at(int node) const { return nodes_[static_cast<std::size_t>(node)]; }
  int neighbour(int node, unsigned direction) const { return node + offsets_[direction]; }
  void start();
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
  std::size_t size_;
  std::array<int, 8> offsets_;
  std::unique_ptr<Node[]> nodes_;    // written where members and their neighbours are
  std::vector<std::uint8_t> trees_;  // of all pixels at first; 0: none
  std::vector<int> queue_, orphans_;
  std::size_t queue_next_ = 0;
  std::int32_t now_ = 0;
  std::int64_t flow_ = 0;
};

}  // namespace floatstage
