// Approximate nearest neighbours with a kd-tree: S. Arya and D. Mount, "Algorithms for Fast Vector
// Quantization" (DCC 1993; distances to boxes kept a dimension at a time, a slack that leaves boxes out),
// cells cut in the middle of what their points span, as the FLANN library's single tree does. Different: the
// points of a leaf lie side by side, dimension by dimension, so that sixteen distances are made at once, by
// the widest instructions there are (docs/adr/0161, 0249).

#include "detail/synthesis/nearest_points.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "detail/synthesis/nearest_points.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace floatstage::detail::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
constexpr std::size_t kLanes = 16;

// Squared distances of the sixteen points of a block; false when none is below `limit`.
bool distances_of_block(const float* block, const float* place, int dimensions, float limit, float* out) {
  const hn::CappedTag<float, kLanes> d;
  const std::size_t lanes = hn::Lanes(d);
  bool any = false;
  for (std::size_t at = 0; at < kLanes; at += lanes) {
    auto sum = hn::Zero(d);
    for (int k = 0; k < dimensions; ++k) {
      const auto off =
          hn::Sub(hn::LoadU(d, block + static_cast<std::size_t>(k) * kLanes + at), hn::Set(d, place[k]));
      sum = hn::MulAdd(off, off, sum);
    }
    hn::StoreU(sum, d, out + at);
    any = any || !hn::AllFalse(d, hn::Lt(sum, hn::Set(d, limit)));
  }
  return any;
}

}  // namespace
}  // namespace floatstage::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>

#include "core/check.h"

namespace floatstage::detail {
HWY_EXPORT(distances_of_block);

namespace {
constexpr std::size_t kLanes = 16;
constexpr std::size_t kLeaf = 32;  // points at most
constexpr float kFar = 1e18F;      // a coordinate that no point has
}  // namespace

class NearestPointsBuilder {
 public:
  NearestPointsBuilder(const std::vector<float>& points, NearestPoints& tree) : points_(points), tree_(tree) {
    order_.resize(tree.count_);
    std::iota(order_.begin(), order_.end(), 0U);
    build(0, order_.size());
  }

 private:
  float at(std::uint32_t point, int k) const {
    return points_[static_cast<std::size_t>(point) * static_cast<std::size_t>(tree_.dimensions_) +
                   static_cast<std::size_t>(k)];
  }

  void leaf(std::size_t begin, std::size_t end, NearestPoints::Node& node) {
    const auto dimensions = static_cast<std::size_t>(tree_.dimensions_);
    node.first = static_cast<std::uint32_t>(tree_.indices_.size() / kLanes);
    node.blocks = static_cast<std::uint32_t>((end - begin + kLanes - 1) / kLanes);
    tree_.indices_.resize(tree_.indices_.size() + node.blocks * kLanes, 0);
    tree_.blocks_.resize(tree_.blocks_.size() + node.blocks * kLanes * dimensions, kFar);
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t block = node.first + (i - begin) / kLanes, lane = (i - begin) % kLanes;
      tree_.indices_[block * kLanes + lane] = order_[i];
      for (std::size_t k = 0; k < dimensions; ++k)
        tree_.blocks_[(block * dimensions + k) * kLanes + lane] = at(order_[i], static_cast<int>(k));
    }
  }

  // The dimension along which points differ most, and between which values.
  int widest(std::size_t begin, std::size_t end, float& low, float& high) const {
    std::array<float, NearestPoints::kMostDimensions> least{}, most{};
    least.fill(std::numeric_limits<float>::max());
    most.fill(std::numeric_limits<float>::lowest());
    for (std::size_t i = begin; i < end; ++i)
      for (int k = 0; k < tree_.dimensions_; ++k) {
        const float v = at(order_[i], k);
        const auto d = static_cast<std::size_t>(k);
        least[d] = std::min(least[d], v);
        most[d] = std::max(most[d], v);
      }
    std::size_t best = 0;
    for (std::size_t k = 1; k < static_cast<std::size_t>(tree_.dimensions_); ++k)
      if (most[k] - least[k] > most[best] - least[best]) best = k;
    low = least[best];
    high = most[best];
    if (begin == 0 && end == order_.size()) {
      tree_.lowest_.assign(least.begin(), least.begin() + tree_.dimensions_);
      tree_.highest_.assign(most.begin(), most.begin() + tree_.dimensions_);
    }
    return static_cast<int>(best);
  }

  void build(std::size_t begin, std::size_t end) {
    const std::size_t here = tree_.nodes_.size();
    tree_.nodes_.emplace_back();
    float low = 0, high = 0;
    const int dimension = widest(begin, end, low, high);
    if (end - begin <= kLeaf || !(high > low)) return leaf(begin, end, tree_.nodes_[here]);
    const auto first = order_.begin() + static_cast<std::ptrdiff_t>(begin),
               last = order_.begin() + static_cast<std::ptrdiff_t>(end);
    const float cut = low + (high - low) / 2;
    auto middle = std::partition(first, last, [&](std::uint32_t p) { return at(p, dimension) <= cut; });
    // Outliers would make the tree as deep as there are points.
    const std::ptrdiff_t least = std::max<std::ptrdiff_t>(1, (last - first) / 32);
    const std::ptrdiff_t place = std::clamp(middle - first, least, (last - first) - least);
    if (place != middle - first) {
      middle = first + place;
      std::nth_element(first, middle, last, [&](std::uint32_t a, std::uint32_t b) {
        const float x = at(a, dimension), y = at(b, dimension);
        return x < y || (x == y && a < b);
      });
    }
    const auto value = [&](std::uint32_t p) { return at(p, dimension); };
    float left_end = low, right_begin = high;
    for (auto i = first; i != middle; ++i) left_end = std::max(left_end, value(*i));
    for (auto i = middle; i != last; ++i) right_begin = std::min(right_begin, value(*i));
    tree_.nodes_[here].dimension = dimension;
    tree_.nodes_[here].low = left_end;
    tree_.nodes_[here].high = right_begin;
    build(begin, begin + static_cast<std::size_t>(middle - first));
    tree_.nodes_[here].right = static_cast<std::uint32_t>(tree_.nodes_.size());
    build(begin + static_cast<std::size_t>(middle - first), end);
  }

  const std::vector<float>& points_;
  NearestPoints& tree_;
  std::vector<std::uint32_t> order_;
};

NearestPoints::NearestPoints(const std::vector<float>& points, int dimensions) : dimensions_(dimensions) {
  FLOATSTAGE_CHECK(dimensions >= 1 && dimensions <= kMostDimensions, "dimensions of points");
  count_ = points.size() / static_cast<std::size_t>(dimensions);
  if (count_ > 0) NearestPointsBuilder(points, *this);
}

struct NearestPointsSearch {
  using Found = NearestPoints::Found;
  using Distances = bool (*)(const float*, const float*, int, float, float*);
  const NearestPoints& tree;
  const float* place;
  int k;
  float slack;  // 1 + the slack
  Found* found;
  Distances distances;
  int count = 0;
  float limit = std::numeric_limits<float>::max();
  std::array<float, NearestPoints::kMostDimensions> to_box{};

  void insert(Found one) {
    int i = count < k ? count++ : k - 1;
    for (; i > 0 && one.distance < found[i - 1].distance; --i) found[i] = found[i - 1];
    found[i] = one;
    if (count == k) limit = found[k - 1].distance;
  }

  void scan(const NearestPoints::Node& node) {
    std::array<float, kLanes> out;
    for (std::size_t b = node.first; b < node.first + node.blocks; ++b) {
      const auto dimensions = static_cast<std::size_t>(tree.dimensions_);
      if (!distances(&tree.blocks_[b * dimensions * kLanes], place, tree.dimensions_, limit, out.data()))
        continue;
      for (std::size_t lane = 0; lane < kLanes; ++lane)
        if (out[lane] < limit && out[lane] < kFar) insert({tree.indices_[b * kLanes + lane], out[lane]});
    }
  }

  void search(std::uint32_t at, float distance) {
    const NearestPoints::Node& node = tree.nodes_[at];
    if (node.dimension < 0) return scan(node);
    const auto dimension = static_cast<std::size_t>(node.dimension);
    const float beyond_low = place[dimension] - node.low, beyond_high = place[dimension] - node.high;
    const bool left = beyond_low + beyond_high < 0;
    search(left ? at + 1 : node.right, distance);
    const float cut = left ? beyond_high * beyond_high : beyond_low * beyond_low;
    const float old = to_box[dimension];
    const float other = distance + cut - old;
    if (other * slack > limit) return;
    to_box[dimension] = cut;
    search(left ? node.right : at + 1, other);
    to_box[dimension] = old;
  }
};

int NearestPoints::find(const float* place, int k, float slack, Found* found) const {
  if (count_ == 0) return 0;
  NearestPointsSearch search{*this,     place, std::min(k, kMostAsked),
                             1 + slack, found, HWY_DYNAMIC_DISPATCH(distances_of_block)};
  float distance = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(dimensions_); ++i) {
    const float off = std::max({lowest_[i] - place[i], place[i] - highest_[i], 0.0F});
    search.to_box[i] = off * off;
    distance += off * off;
  }
  search.search(0, distance);
  return search.count;
}

}  // namespace floatstage::detail
#endif
