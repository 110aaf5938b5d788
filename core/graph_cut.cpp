#include "core/graph_cut.h"

#include <algorithm>
#include <limits>

#include "core/check.h"

namespace floatstage {
namespace {

constexpr std::int32_t kNone = -1, kRoot = -2, kOrphan = -3;  // of Node::parent
constexpr int kFar = std::numeric_limits<int>::max();

}  // namespace

GraphCut::GraphCut(int nodes, std::size_t edges) {
  arcs_.reserve(2 * edges);
  reset(nodes);
}

void GraphCut::reset(int nodes) {
  FLOATSTAGE_CHECK(nodes >= 0, "a graph's nodes");
  nodes_.assign(static_cast<std::size_t>(nodes), {});
  arcs_.clear();
  flow_ = 0;
}

void GraphCut::add_terminals(int node, std::int32_t from_source, std::int32_t to_sink) {
  FLOATSTAGE_CHECK(from_source >= 0 && to_sink >= 0, "capacities are not negative");
  std::int32_t& residual = at(node).residual;
  if (residual > 0)
    from_source += residual;
  else
    to_sink -= residual;
  flow_ += std::min(from_source, to_sink);  // what runs straight through
  residual = from_source - to_sink;
}

void GraphCut::add_edge(int a, int b, std::int32_t there, std::int32_t back) {
  FLOATSTAGE_CHECK(a != b && there >= 0 && back >= 0,
                   "an edge joins two nodes at a cost that is not negative");
  const auto e = static_cast<std::int32_t>(arcs_.size());
  arcs_.push_back({b, at(a).first, there});
  arcs_.push_back({a, at(b).first, back});
  at(a).first = e;
  at(b).first = e + 1;
}

void GraphCut::wake(int node) {
  if (at(node).active) return;
  at(node).active = true;
  queue_.push_back(node);
}

void GraphCut::start() {
  queue_.clear();
  orphans_.clear();
  queue_next_ = 0;
  now_ = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    Node& n = nodes_[i];
    n.active = false;
    n.stamp = 0;
    n.distance = 1;
    n.tree = n.residual > 0 ? Tree::Source : n.residual < 0 ? Tree::Sink : Tree::Free;
    n.parent = n.residual != 0 ? kRoot : kNone;
    if (n.residual != 0) wake(static_cast<int>(i));
  }
}

// Lets a node's tree grow over its arcs that are not full; the arc where it met the other tree, from the
// source's side to the sink's, or kNone.
std::int32_t GraphCut::grow(int node) {
  const Tree tree = at(node).tree;
  for (std::int32_t e = at(node).first; e >= 0; e = arc(e).next) {
    const std::int32_t room = tree == Tree::Source ? arc(e).residual : arc(e ^ 1).residual;
    if (room == 0) continue;
    const int head = arc(e).head;
    Node& other = at(head);
    if (other.tree == Tree::Free) {
      other.tree = tree;
      other.parent = e ^ 1;
      other.stamp = at(node).stamp;
      other.distance = at(node).distance + 1;
      wake(head);
    } else if (other.tree != tree) {
      return tree == Tree::Source ? e : e ^ 1;
    } else if (other.stamp <= at(node).stamp && other.distance > at(node).distance + 1 &&
               other.parent != kRoot) {
      other.parent = e ^ 1;  // a shorter way to the root
      other.stamp = at(node).stamp;
      other.distance = at(node).distance + 1;
    }
  }
  return kNone;
}

std::int32_t GraphCut::bottleneck(std::int32_t bridge) const {
  std::int32_t least = arc(bridge).residual;
  int node = arc(bridge ^ 1).head;
  for (; at(node).parent != kRoot; node = arc(at(node).parent).head)
    least = std::min(least, arc(at(node).parent ^ 1).residual);
  least = std::min(least, at(node).residual);
  node = arc(bridge).head;
  for (; at(node).parent != kRoot; node = arc(at(node).parent).head)
    least = std::min(least, arc(at(node).parent).residual);
  return std::min(least, -at(node).residual);
}

void GraphCut::orphan(int node) {
  at(node).parent = kOrphan;
  orphans_.push_back(node);
}

// Sends flow along a node's way to the root of its tree.
void GraphCut::push(int node, Tree tree, std::int32_t flow) {
  while (at(node).parent != kRoot) {
    const std::int32_t up = at(node).parent, down = up ^ 1;
    const int parent = arc(up).head;
    arc(tree == Tree::Source ? down : up).residual -= flow;
    arc(tree == Tree::Source ? up : down).residual += flow;
    if (arc(tree == Tree::Source ? down : up).residual == 0) orphan(node);
    node = parent;
  }
  at(node).residual += tree == Tree::Source ? -flow : flow;
  if (at(node).residual == 0) orphan(node);
}

void GraphCut::augment(std::int32_t bridge) {
  const std::int32_t flow = bottleneck(bridge);
  arc(bridge).residual -= flow;
  arc(bridge ^ 1).residual += flow;
  push(arc(bridge ^ 1).head, Tree::Source, flow);
  push(arc(bridge).head, Tree::Sink, flow);
  flow_ += flow;
}

int GraphCut::distance_to_root(int node) {
  int steps = 0;
  for (int n = node;; n = arc(at(n).parent).head) {
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
    if (at(n).parent < 0) return kFar;  // an orphan, or cut off
  }
  // Those on the way now know theirs too.
  int left = steps;
  for (int n = node; at(n).stamp != now_; n = arc(at(n).parent).head) {
    at(n).stamp = now_;
    at(n).distance = left--;
  }
  return steps;
}

bool GraphCut::find_parent(int node) {
  const Tree tree = at(node).tree;
  std::int32_t best = kNone;
  int nearest = kFar;
  for (std::int32_t e = at(node).first; e >= 0; e = arc(e).next) {
    const std::int32_t room = tree == Tree::Source ? arc(e ^ 1).residual : arc(e).residual;
    const Node& other = at(arc(e).head);
    if (room == 0 || other.tree != tree || other.parent == kNone || other.parent == kOrphan) continue;
    const int distance = distance_to_root(arc(e).head);
    if (distance < nearest) nearest = distance, best = e;
  }
  if (best == kNone) return false;
  at(node).parent = best;
  at(node).stamp = now_;
  at(node).distance = nearest + 1;
  return true;
}

void GraphCut::adopt() {
  for (std::size_t i = 0; i < orphans_.size(); ++i) {
    const int node = orphans_[i];
    if (find_parent(node)) continue;
    const Tree tree = at(node).tree;
    for (std::int32_t e = at(node).first; e >= 0; e = arc(e).next) {
      const int head = arc(e).head;
      if (at(head).tree != tree || at(head).parent == kNone) continue;
      const std::int32_t room = tree == Tree::Source ? arc(e ^ 1).residual : arc(e).residual;
      if (room > 0) wake(head);
      if (at(head).parent >= 0 && arc(at(head).parent).head == node) orphan(head);
    }
    at(node).tree = Tree::Free;
    at(node).parent = kNone;
  }
  orphans_.clear();
}

std::int64_t GraphCut::solve() {
  start();
  while (queue_next_ < queue_.size()) {
    const int node = queue_[queue_next_];
    if (at(node).tree == Tree::Free) {
      at(node).active = false;
      ++queue_next_;
      continue;
    }
    const std::int32_t bridge = grow(node);
    if (bridge == kNone) {
      at(node).active = false;
      ++queue_next_;
      continue;
    }
    ++now_;
    augment(bridge);
    adopt();
    if (queue_next_ > nodes_.size()) {  // what is done is forgotten now and then
      queue_.erase(queue_.begin(), queue_.begin() + static_cast<std::ptrdiff_t>(queue_next_));
      queue_next_ = 0;
    }
  }
  return flow_;
}

}  // namespace floatstage
