// Method:  minimum cut by maximum flow with two search trees, over the pixels of a picture
// Paper:   Y. Boykov, V. Kolmogorov, "An Experimental Comparison of Min-Cut/Max-Flow Algorithms for Energy
//          Minimization in Vision", 2004; O. Jamriska, D. Sykora, A. Hornung, "Cache-efficient Graph Cuts on
//          Structured Grids", 2012, for neighbours that are not written down
// Differs: pixels among their like do not wait to grow at first
// ADR:     0347

#include "core/grid_cut.h"

#include <algorithm>
#include <limits>

#include "core/check.h"

namespace floatstage {
namespace {

constexpr int kFar = std::numeric_limits<int>::max();

constexpr unsigned back(unsigned direction) { return direction ^ 1U; }

}  // namespace

GridCut::GridCut(int width, int height, std::span<const std::uint8_t> members)
    : stride_(width + 2),
      size_(static_cast<std::size_t>(stride_) * (static_cast<std::size_t>(height) + 2)),
      offsets_{1, -1, stride_, -stride_, stride_ + 1, -stride_ - 1, stride_ - 1, -stride_ + 1},
      nodes_(std::make_unique_for_overwrite<Node[]>(size_)),
      trees_(size_) {
  FLOATSTAGE_CHECK(width > 0 && height > 0 && members.size() == size_, "a grid of pixels with a border");
  const int rows = height + 2;
  std::vector<std::uint8_t> near(static_cast<std::size_t>(stride_));
  for (int y = 0; y < rows; ++y) {
    const std::uint8_t* own = members.data() + static_cast<std::ptrdiff_t>(y) * stride_;
    const std::uint8_t *above = y > 0 ? own - stride_ : own, *below = y + 1 < rows ? own + stride_ : own;
    std::uint8_t* any = near.data();
    for (int x = 0; x < stride_; ++x) any[x] = above[x] | own[x] | below[x];
    for (int x = 0; x < stride_; ++x)
      if (own[x] == 0 && (any[x] != 0 || (x > 0 && any[x - 1] != 0) || (x + 1 < stride_ && any[x + 1] != 0)))
        at(y * stride_ + x) = {{}, 0, 0, 1, Tree::Free, kNone, false};
  }
}

void GridCut::wake(int node) {
  if (at(node).active) return;
  at(node).active = true;
  queue_.push_back(node);
}

// Nothing can grow from a root whose neighbours are roots of its tree, until one of them is an orphan; and
// whoever finds no parent wakes those around it. So such roots do not wait in the queue.
void GridCut::start() {
  const auto stride = static_cast<std::size_t>(stride_);
  std::vector<std::uint8_t> like(stride), other(stride);
  for (std::size_t row = stride; row + stride < size_; row += stride) {
    const std::uint8_t* t = trees_.data() + row;
    std::uint8_t *all = like.data(), *tree = other.data();
    // A set bit that all nine have says which tree they are in.
    for (std::size_t x = 0; x < stride; ++x) tree[x] = t[x - stride] & t[x] & t[x + stride];
    for (std::size_t x = 1; x + 1 < stride; ++x) all[x] = tree[x - 1] & tree[x] & tree[x + 1];
    for (std::size_t x = 1; x + 1 < stride; ++x)
      if (t[x] != 0 && all[x] == 0) wake(static_cast<int>(row + x));
  }
}

// Lets a node's tree grow over its edges that are not full; the direction in which it met the other tree, or
// kNone.
unsigned GridCut::grow(int node) {
  Node& own = at(node);
  for (unsigned d = 0; d < 8; ++d) {
    const int head = neighbour(node, d);
    Node& other = at(head);
    const std::int32_t room = own.tree == Tree::Source ? own.room[d] : other.room[back(d)];
    if (room == 0) continue;
    if (other.tree == Tree::Free) {
      other.tree = own.tree;
      other.parent = static_cast<std::uint8_t>(back(d));
      other.stamp = own.stamp;
      other.distance = own.distance + 1;
      wake(head);
    } else if (other.tree != own.tree) {
      return d;
    } else if (other.stamp <= own.stamp && other.distance > own.distance + 1 && other.parent != kRoot) {
      other.parent = static_cast<std::uint8_t>(back(d));  // a shorter way to the root
      other.stamp = own.stamp;
      other.distance = own.distance + 1;
    }
  }
  return kNone;
}

std::int32_t GridCut::bottleneck(int node, unsigned direction) {
  std::int32_t least = at(node).room[direction];
  int n = node;
  while (at(n).parent != kRoot) {
    const unsigned up = at(n).parent;
    n = neighbour(n, up);
    least = std::min(least, at(n).room[back(up)]);
  }
  least = std::min(least, at(n).excess);
  n = neighbour(node, direction);
  while (at(n).parent != kRoot) {
    const unsigned up = at(n).parent;
    least = std::min(least, at(n).room[up]);
    n = neighbour(n, up);
  }
  return std::min(least, -at(n).excess);
}

void GridCut::orphan(int node) {
  at(node).parent = kOrphan;
  orphans_.push_back(node);
}

// Sends flow along a node's way to the root of its tree.
void GridCut::push(int node, Tree tree, std::int32_t flow) {
  const bool source = tree == Tree::Source;
  while (at(node).parent != kRoot) {
    const unsigned up = at(node).parent;
    const int parent = neighbour(node, up);
    std::int32_t &to_parent = at(node).room[up], &from_parent = at(parent).room[back(up)];
    std::int32_t& used = source ? from_parent : to_parent;
    (source ? to_parent : from_parent) += flow;
    used -= flow;
    if (used == 0) orphan(node);
    node = parent;
  }
  at(node).excess += source ? -flow : flow;
  if (at(node).excess == 0) orphan(node);
}

// Along the edge from the source's tree to the sink's.
void GridCut::augment(int node, unsigned direction) {
  const std::int32_t flow = bottleneck(node, direction);
  const int head = neighbour(node, direction);
  at(node).room[direction] -= flow;
  at(head).room[back(direction)] += flow;
  push(node, Tree::Source, flow);
  push(head, Tree::Sink, flow);
  flow_ += flow;
}

int GridCut::distance_to_root(int node) {
  int steps = 0;
  for (int n = node;; n = neighbour(n, at(n).parent)) {
    if (at(n).stamp == now_) {
      steps += at(n).distance;
      break;
    }
    ++steps;
    if (at(n).parent == kRoot) {
      at(n).stamp = now_;
      at(n).distance = 1;
      break;
    }
    if (at(n).parent > kRoot) return kFar;  // an orphan, or cut off
  }
  // Those on the way now know theirs too.
  int left = steps;
  for (int n = node; at(n).stamp != now_; n = neighbour(n, at(n).parent)) {
    at(n).stamp = now_;
    at(n).distance = left--;
  }
  return steps;
}

bool GridCut::find_parent(int node) {
  const Tree tree = at(node).tree;
  unsigned best = kNone;
  int nearest = kFar;
  for (unsigned d = 0; d < 8; ++d) {
    const int head = neighbour(node, d);
    const Node& other = at(head);
    const std::int32_t room = tree == Tree::Source ? other.room[back(d)] : at(node).room[d];
    if (room == 0 || other.tree != tree || other.parent == kNone || other.parent == kOrphan) continue;
    const int distance = distance_to_root(head);
    if (distance < nearest) nearest = distance, best = d;
    if (nearest == 1) break;
  }
  if (best == kNone) return false;
  at(node).parent = static_cast<std::uint8_t>(best);
  at(node).stamp = now_;
  at(node).distance = nearest + 1;
  return true;
}

void GridCut::adopt() {
  for (std::size_t i = 0; i < orphans_.size(); ++i) {
    const int node = orphans_[i];
    if (find_parent(node)) continue;
    const Tree tree = at(node).tree;
    for (unsigned d = 0; d < 8; ++d) {
      const int head = neighbour(node, d);
      Node& other = at(head);
      if (other.tree != tree || other.parent == kNone) continue;
      const std::int32_t room = tree == Tree::Source ? other.room[back(d)] : at(node).room[d];
      if (room > 0) wake(head);
      if (other.parent == back(d)) orphan(head);
    }
    at(node).tree = Tree::Free;
    at(node).parent = kNone;
  }
  orphans_.clear();
}

std::int64_t GridCut::solve() {
  start();
  while (queue_next_ < queue_.size()) {
    const int node = queue_[queue_next_];
    const unsigned met = at(node).tree == Tree::Free ? kNone : grow(node);
    if (met == kNone) {
      at(node).active = false;
      ++queue_next_;
      continue;
    }
    ++now_;
    if (at(node).tree == Tree::Source)
      augment(node, met);
    else
      augment(neighbour(node, met), back(met));
    adopt();
    if (queue_next_ > size_) {  // what is done is forgotten now and then
      queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(queue_next_));
      queue_next_ = 0;
    }
  }
  return flow_;
}

}  // namespace floatstage
