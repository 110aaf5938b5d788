#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "core/rig.h"

namespace floatstage::recon {

/// What one camera says of its pixels, at any reduced size: log of how much likelier what is seen there is if
/// the subject is there than if it is not. Empty: this camera does not know.
struct OddsPicture {
  int width = 0, height = 0;
  std::vector<float> odds;  ///< width * height, row by row
  bool empty() const { return odds.empty(); }
};

struct OccupancyOptions {
  /// Share of empty space through which a camera sees the subject all the same: how little a yes proves.
  double seen_anyway = 0.5;
  /// Share of pixels that a camera misjudges: how little a no proves.
  double mistaken = 0.05;
  double prior = -1;  ///< log-odds of space before anybody was asked
};

/// Soft space carving on a regular grid: for every voxel the log-odds that it holds subject, from all cameras
/// that see it, as J.-S. Franco and E. Boyer, "Fusion of Multi-View Silhouette Cues Using a Space Occupancy
/// Grid", ICCV 2005, derive them: since a camera may see the subject before or behind empty space, a yes is
/// worth log(1 / seen_anyway) at most, a no down to log(mistaken). Unlike a visual hull it survives a camera
/// that misjudges a place. Where cameras see voxels is found once.
class OccupancyGrid {
 public:
  /// About `voxels` in `box`; sizes[i] is that of camera i's odds (0 x 0: none). Voxels that fewer than
  /// `seen_by` of the cameras see are left out. Threads: 0 is one per core; same result at any number.
  OccupancyGrid(const Rig& rig, const Eigen::AlignedBox3d& box, int voxels,
                std::span<const Eigen::Vector2i> sizes, int seen_by, int threads);

  /// Asks all cameras; those whose picture is empty say nothing. odds[i] has sizes[i].
  void fuse(std::span<const OddsPicture> odds, const OccupancyOptions& options);

  /// What all others than `camera` say of its pixels: of each, the largest log-odds of the voxels behind it,
  /// its own say taken out. kNothing where it sees no voxel.
  std::vector<float> said_by_others(int camera) const;
  /// The same of the voxels on the sides that the planes' normals point to.
  std::vector<float> said_by_others_before(int camera,
                                           std::span<const Eigen::Hyperplane<double, 3>> planes) const;
  /// What all say, with its own.
  std::vector<float> said_by_all(int camera) const;
  static constexpr float kNothing = -1e3f;

  /// Around the voxels that are more likely subject than not; empty when there are none.
  Eigen::AlignedBox3d subject_box(float above = 0) const;
  double voxel() const { return voxel_; }  ///< metres
  std::size_t occupied() const;            ///< voxels of log-odds > 0
  const Eigen::AlignedBox3d& box() const { return box_; }

 private:
  static constexpr std::uint32_t kUnseen = 0xffffffff;
  std::vector<float> silhouette(std::size_t camera, bool own,
                                std::span<const Eigen::Hyperplane<double, 3>> before = {}) const;
  Eigen::Vector3d position(std::size_t voxel) const;

  Eigen::AlignedBox3d box_;
  double voxel_ = 0;
  Eigen::Vector3i points_;
  int threads_;
  std::vector<Eigen::Vector2i> sizes_;
  std::vector<int> reach_;                         // px: how far apart voxels may lie in a picture
  std::vector<std::vector<std::uint32_t>> pixel_;  // [camera][voxel]
  std::vector<std::uint8_t> counts_;               // [voxel] seen by enough cameras
  std::vector<std::vector<float>> say_;            // [camera][pixel]
  std::vector<float> fused_;                       // [voxel]
};

}  // namespace floatstage::recon
