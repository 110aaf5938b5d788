// Method:  pairs of triangles that pass through each other, over a
//          tree of boxes along a Morton curve
// Paper:   none: an edge of one pierces the inside of the other, by signs of tetrahedra
// Differs: touching is not crossing; the number of pairs of one triangle is limited
// ADR:     0078

#include "recon/mesh/crossings.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <Eigen/Geometry>

#include "core/parallel.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<Vector3d, 3>;

// Sign of the volume of the tetrahedron (o, a, b, c); 0 within rounding.
int orientation(const Vector3d& o, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d u = a - o, v = b - o, w = c - o;
  const double volume = u.dot(v.cross(w));
  const double rounding = 1e-14 * u.cwiseAbs().sum() * v.cwiseAbs().sum() * w.cwiseAbs().sum();
  return volume > rounding ? 1 : volume < -rounding ? -1 : 0;
}

bool pierces(const Vector3d& p, const Vector3d& q, const Triangle& t) {
  const int first = orientation(p, q, t[0], t[1]);
  return first != 0 && first == orientation(p, q, t[1], t[2]) && first == orientation(p, q, t[2], t[0]);
}

// Which side of b's plane the corners of a lie on.
std::array<int, 3> sides(const Triangle& a, const Triangle& b) {
  std::array<int, 3> s;
  for (std::size_t i = 0; i < 3; ++i) s[i] = orientation(a[i], b[0], b[1], b[2]);
  return s;
}

bool some_edge_pierces(const Triangle& a, const std::array<int, 3>& side, const Triangle& b) {
  for (std::size_t i = 0; i < 3; ++i)
    if (side[i] * side[(i + 1) % 3] < 0 && pierces(a[i], a[(i + 1) % 3], b)) return true;
  return false;
}

// Boxes over triangles sorted along a Morton curve; node k's children are 2k + 1 and 2k + 2, each half of its
// range.
class BoxTree {
 public:
  BoxTree(std::span<const Vector3d> positions, std::span<const std::array<std::uint32_t, 3>> triangles)
      : order_(triangles.size()), boxes_(triangles.size()) {
    Eigen::AlignedBox3d all;
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      for (std::uint32_t v : triangles[i]) boxes_[i].extend(positions[v]);
      all.extend(boxes_[i]);
    }
    std::vector<std::uint32_t> code(triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
      code[i] =
          morton((boxes_[i].center() - all.min()).cwiseQuotient((all.sizes().array() + 1e-300).matrix()));
    std::iota(order_.begin(), order_.end(), 0u);
    std::sort(order_.begin(), order_.end(), [&](std::uint32_t a, std::uint32_t b) {
      return code[a] != code[b] ? code[a] < code[b] : a < b;
    });
    if (!order_.empty()) build(0, 0, order_.size());
  }

  const Eigen::AlignedBox3d& box(std::uint32_t triangle) const { return boxes_[triangle]; }

  template <class Visit>
  void visit_overlaps(const Eigen::AlignedBox3d& box, Visit visit) const {
    if (!order_.empty()) descend(0, 0, order_.size(), box, visit);
  }

 private:
  static constexpr std::size_t kLeaf = 4;

  static std::uint32_t morton(const Vector3d& p) {
    std::uint32_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const std::uint32_t cell = static_cast<std::uint32_t>(std::clamp(p[axis], 0.0, 1.0) * 1023);
      for (int bit = 0; bit < 10; ++bit) code |= ((cell >> bit) & 1u) << (3 * bit + axis);
    }
    return code;
  }

  void build(std::size_t node, std::size_t first, std::size_t last) {
    if (nodes_.size() <= node) nodes_.resize(node + 1);
    Eigen::AlignedBox3d box;
    for (std::size_t i = first; i < last; ++i) box.extend(boxes_[order_[i]]);
    nodes_[node] = box;
    if (last - first <= kLeaf) return;
    const std::size_t middle = (first + last) / 2;
    build(2 * node + 1, first, middle);
    build(2 * node + 2, middle, last);
  }

  template <class Visit>
  void descend(std::size_t node, std::size_t first, std::size_t last, const Eigen::AlignedBox3d& box,
               Visit& visit) const {
    if (!nodes_[node].intersects(box)) return;
    if (last - first <= kLeaf) {
      for (std::size_t i = first; i < last; ++i)
        if (boxes_[order_[i]].intersects(box)) visit(order_[i]);
      return;
    }
    const std::size_t middle = (first + last) / 2;
    descend(2 * node + 1, first, middle, box, visit);
    descend(2 * node + 2, middle, last, box, visit);
  }

  std::vector<std::uint32_t> order_;
  std::vector<Eigen::AlignedBox3d> boxes_, nodes_;
};

}  // namespace

bool triangles_cross(const Triangle& a, const Triangle& b) {
  const std::array<int, 3> a_sides = sides(a, b);
  if (std::abs(a_sides[0] + a_sides[1] + a_sides[2]) == 3) return false;
  const std::array<int, 3> b_sides = sides(b, a);
  if (std::abs(b_sides[0] + b_sides[1] + b_sides[2]) == 3) return false;
  return some_edge_pierces(a, a_sides, b) || some_edge_pierces(b, b_sides, a);
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> crossing_pairs(
    std::span<const Vector3d> positions, std::span<const std::array<std::uint32_t, 3>> triangles,
    std::size_t limit_each, int threads) {
  const BoxTree tree(positions, triangles);
  auto corners = [&](std::uint32_t t) {
    return Triangle{positions[triangles[t][0]], positions[triangles[t][1]], positions[triangles[t][2]]};
  };
  constexpr std::size_t kChunk = 4096;
  std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> found((triangles.size() + kChunk - 1) /
                                                                          kChunk);
  parallel_for(found.size(), threads, [&](std::size_t chunk) {
    std::vector<std::uint32_t> others;
    for (std::size_t i = chunk * kChunk; i < std::min(triangles.size(), (chunk + 1) * kChunk); ++i) {
      const std::uint32_t self = static_cast<std::uint32_t>(i);
      const std::array<std::uint32_t, 3>& mine = triangles[i];
      others.clear();
      tree.visit_overlaps(tree.box(self), [&](std::uint32_t other) {
        if (other <= self) return;
        for (std::uint32_t v : triangles[other])
          if (v == mine[0] || v == mine[1] || v == mine[2]) return;
        if (others.size() < limit_each && triangles_cross(corners(self), corners(other)))
          others.push_back(other);
      });
      std::sort(others.begin(), others.end());
      for (std::uint32_t other : others) found[chunk].push_back({self, other});
    }
  });
  std::vector<std::pair<std::uint32_t, std::uint32_t>> all;
  for (const auto& part : found) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace floatstage::recon
