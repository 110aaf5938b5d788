// Method:  an octree whose nodes are carved by integral images of the mattes
// Paper:   R. Szeliski, "Rapid octree construction from image sequences", 1993; thesis, section 2.8.2
// Differs: conservative bounds for whole nodes in the place of a distance threshold; what no camera sees is
//          not hull
// ADR:     0052

#include "recon/octree/octree_carve.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/parallel.h"

namespace floatstage::recon {
namespace {

constexpr int kRootPoints =
    16;  // per side of the octrees' roots: coarse enough to skip, fine enough to share out

// What all views together say of a box, and which of them must be asked again inside it.
struct Joint {
  bool carved = false;
  bool witnessed = false;  // some camera sees all of it as subject
  bool unseen = true;      // no camera sees any of it
  bool may_carve = false;  // some camera may see background in it
  std::vector<std::uint32_t> undecided;

  bool solid() const { return witnessed && !may_carve; }
};

Joint judge(std::span<const OctreeView> views, std::span<const std::uint32_t> candidates, bool witnessed,
            const Eigen::AlignedBox3d& box) {
  Joint joint;
  joint.witnessed = witnessed;
  joint.unseen = !witnessed;
  for (std::uint32_t i : candidates) {
    const BoxVerdict verdict = views[i].over(box);
    if (verdict == BoxVerdict::Background) {
      joint.carved = true;
      return joint;
    }
    if (verdict == BoxVerdict::Subject) joint.witnessed = true;
    if (verdict == BoxVerdict::Mixed) joint.may_carve = true;
    if (verdict != BoxVerdict::Unseen) joint.unseen = false;
    // A camera that never carves here may still be the only witness.
    if (verdict == BoxVerdict::Mixed || verdict == BoxVerdict::NotBackground) joint.undecided.push_back(i);
  }
  return joint;
}

std::vector<std::uint32_t> everyone(std::span<const OctreeView> views) {
  std::vector<std::uint32_t> all(views.size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::uint32_t>(i);
  return all;
}

class Carver {
 public:
  Carver(std::span<const OctreeView> views, CarvedGrid& grid)
      : views_(views), grid_(grid), all_(everyone(views)) {}

  // All points of the rows y, z of one root column. Rows belong to one task only: no two threads write one
  // word.
  void carve_rows(int y, int z) {
    for (int x = 0; x < grid_.points().x(); x += kRootPoints) carve_node({x, y, z}, kRootPoints, all_, false);
  }

 private:
  void carve_node(const Eigen::Vector3i& first, int size, std::span<const std::uint32_t> candidates,
                  bool witnessed) {
    // The outermost layer of points stays outside.
    const Eigen::Vector3i lo = first.cwiseMax(1);
    const Eigen::Vector3i hi =
        (first.array() + size).matrix().cwiseMin(grid_.points() - Eigen::Vector3i::Ones());
    if ((lo.array() >= hi.array()).any()) return;
    const Eigen::AlignedBox3d box(grid_.position(lo.x(), lo.y(), lo.z()),
                                  grid_.position(hi.x() - 1, hi.y() - 1, hi.z() - 1));
    const Joint joint = judge(views_, candidates, witnessed, box);
    if (joint.carved || joint.unseen) return;
    if (joint.solid()) {
      fill(lo, hi);
    } else if (size <= 2) {
      ask_points(lo, hi, joint);
    } else {
      for (int child = 0; child < 8; ++child) {
        const Eigen::Vector3i step(child & 1, (child >> 1) & 1, child >> 2);
        carve_node(first + step * (size / 2), size / 2, joint.undecided, joint.witnessed);
      }
    }
  }

  void fill(const Eigen::Vector3i& lo, const Eigen::Vector3i& hi) {
    for (int z = lo.z(); z < hi.z(); ++z)
      for (int y = lo.y(); y < hi.y(); ++y)
        for (int x = lo.x(); x < hi.x(); ++x) set(x, y, z);
  }

  void ask_points(const Eigen::Vector3i& lo, const Eigen::Vector3i& hi, const Joint& joint) {
    for (int z = lo.z(); z < hi.z(); ++z)
      for (int y = lo.y(); y < hi.y(); ++y)
        for (int x = lo.x(); x < hi.x(); ++x)
          if (inside(joint, grid_.position(x, y, z))) set(x, y, z);
  }

  bool inside(const Joint& joint, const Eigen::Vector3d& point) const {
    bool witnessed = joint.witnessed;
    for (std::uint32_t i : joint.undecided) {
      const PointVerdict verdict = views_[i].at(point);
      if (verdict == PointVerdict::Background) return false;
      witnessed |= verdict == PointVerdict::Subject;
    }
    return witnessed && grid_.box().contains(point);
  }

  void set(int x, int y, int z) { grid_.row(y, z)[x >> 6] |= std::uint64_t{1} << (x & 63); }

  std::span<const OctreeView> views_;
  CarvedGrid& grid_;
  std::vector<std::uint32_t> all_;
};

void extend_by_uncarved(std::span<const OctreeView> views, const Eigen::AlignedBox3d& box, int depth,
                        std::span<const std::uint32_t> candidates, bool witnessed,
                        Eigen::AlignedBox3d& kept) {
  if (kept.contains(box)) return;
  const Joint joint = judge(views, candidates, witnessed, box);
  if (joint.carved || joint.unseen) return;
  if (depth == 0 || joint.solid()) {
    kept.extend(box);
    return;
  }
  const Eigen::Vector3d half = box.sizes() / 2;
  for (int child = 0; child < 8; ++child) {
    const Eigen::Vector3d corner =
        box.min() + half.cwiseProduct(Eigen::Vector3d(child & 1, (child >> 1) & 1, child >> 2));
    extend_by_uncarved(views, {corner, corner + half}, depth - 1, joint.undecided, joint.witnessed, kept);
  }
}

}  // namespace

bool in_hull(std::span<const OctreeView> views, const Eigen::Vector3d& point) {
  bool witnessed = false;
  for (const OctreeView& view : views) {
    const PointVerdict verdict = view.at(point);
    if (verdict == PointVerdict::Background) return false;
    witnessed |= verdict == PointVerdict::Subject;
  }
  return witnessed;
}

CarvedGrid::CarvedGrid(const Eigen::AlignedBox3d& box, int resolution) : box_(box) {
  FLOATSTAGE_CHECK(!box.isEmpty() && box.sizes().maxCoeff() > 0 && resolution > 0, "a grid over nothing");
  voxel_ = box.sizes().maxCoeff() / resolution;
  for (int axis = 0; axis < 3; ++axis)
    points_[axis] = std::max(1, static_cast<int>(std::lround(box.sizes()[axis] / voxel_))) + 2;
  origin_ = box.center() - voxel_ / 2 * (points_ - Eigen::Vector3i::Ones()).cast<double>();
  words_ = static_cast<std::size_t>(points_.x() + 63) / 64;
  bits_.assign(words_ * static_cast<std::size_t>(points_.y()) * static_cast<std::size_t>(points_.z()), 0);
}

CarvedGrid carve(std::span<const OctreeView> views, const Eigen::AlignedBox3d& box, int resolution,
                 int threads) {
  CarvedGrid grid(box, resolution);
  const auto roots = [](int points) {
    return static_cast<std::size_t>((points + kRootPoints - 1) / kRootPoints);
  };
  const std::size_t across = roots(grid.points().y());
  parallel_for(across * roots(grid.points().z()), threads, [&](std::size_t task) {
    Carver(views, grid)
        .carve_rows(static_cast<int>(task % across) * kRootPoints,
                    static_cast<int>(task / across) * kRootPoints);
  });
  return grid;
}

Eigen::AlignedBox3d shrink_to_hull(std::span<const OctreeView> views, const Eigen::AlignedBox3d& box) {
  constexpr int kPasses = 2, kDepth = 6;  // 1/64 of the box, then 1/64 of what is left
  const std::vector<std::uint32_t> all = everyone(views);
  Eigen::AlignedBox3d kept = box;
  for (int pass = 0; pass < kPasses && !kept.isEmpty(); ++pass) {
    Eigen::AlignedBox3d smaller;
    extend_by_uncarved(views, kept, kDepth, all, false, smaller);
    kept = smaller;
  }
  return kept;
}

}  // namespace floatstage::recon
