#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "core/rig.h"
#include "recon/block_pictures.h"
#include "recon/hull_input.h"

namespace floatstage::recon {

/// Where the silhouettes of one instant leave room for a body.
struct StageVolume {
  Eigen::AlignedBox3d box;            ///< world, metres; empty: no point is subject for all who see it
  int cameras = 0;                    ///< every point of the body is seen by so many, at least
  std::vector<std::uint8_t> partial;  ///< per camera of the rig: 1 when a part of it lies outside the picture
  /// Per camera: share of the blocks with subject that no body within the box explains.
  std::vector<double> unexplained;
};

/// Finds it by halving cubes (an octree over silhouettes in blocks of pixels: Szeliski 1993). A cube stays
/// when at least `cameras` pictures show subject there and none shows background only. What is searched grows
/// until what is left lies inside. `cameras` is a quarter of those that have a matte, at least three: two
/// bound a point, the third confirms it.
///
/// A picture whose border the subject does not touch is taken to show all of it, as long as that leaves
/// nothing unexplained. Else it is not known what is outside the pictures, and bodies are added that stand
/// there, and then those that half as many cameras (down to two) see: each part whose cubes fall, for the
/// most part, on subject that nothing else explains. Keeps its memory: a later frame of the same rig
/// allocates nothing. One thread at a time.
class StageFinder {
 public:
  /// `outvoted`: a cube also stays when so many cameras see background only (votes of m of n cameras). False
  /// when the silhouettes do not bound it: the body reaches a hundred times the cameras' distance away.
  bool find(const Rig& rig, const HullInput& input, StageVolume& out, int outvoted = 0);
  /// Whether a point lies in a cube.
  bool holds(const Eigen::Vector3d& point) const;

  /// How many of those that have a matte must see subject at a point.
  static int cameras_of(int known) { return std::min(known, std::max(3, known / 4)); }

  // What find() found, for those who ask on. A cube is its centre and half(); `searched` is half the side of
  // the cube around focus() that was searched.
  const BlockPictures& pictures() const { return pictures_; }
  const std::vector<Eigen::Vector3d>& cubes() const { return cubes_; }
  double half() const { return half_; }
  const Eigen::Vector3d& focus() const { return focus_; }
  double searched() const { return reach_; }
  /// Per camera: 1 for each block with subject that no cube explains.
  const std::vector<std::vector<std::uint8_t>>& unexplained() const { return unexplained_; }

  /// Cubes of less than this part of what is searched are small (BlockPictures::ask()).
  static constexpr double kSmall = 24;
  static constexpr std::size_t kMostCubes = 20000;  ///< bounds the time of a frame; more is looser

 private:
  /// Cubes that hang together.
  struct Part {
    int number = 0;
    int shown = 0;            ///< blocks with subject that its cubes fall on, over all cubes and cameras
    int lacking = 0;          ///< those of them that nothing explains
    int camera = -1;          ///< the last one that lacks
    bool of_several = false;  ///< more than one camera lacks: what one lacks alone is rather its own mistake
    bool ends = true;         ///< within what is searched
    bool believed() const { return ends && of_several && 2 * lacking > shown; }
  };

  bool keeps(const Eigen::Vector3d& center, double radius, bool small, int cameras);
  bool carve(int cameras);
  template <class Keep>
  void halve(std::vector<Eigen::Vector3d>& cubes, double half, const Keep& keep);
  void refine(int cameras, double reach, double finest);
  bool is_bounded(double reach) const;
  void count_unexplained();
  std::int64_t place(const Eigen::Vector3d& point) const;
  void sort_places(const std::vector<Eigen::Vector3d>& cubes);
  int find_parts(const std::vector<Eigen::Vector3d>& core);
  void weigh(std::size_t cube, Part& part) const;
  bool take_parts(const std::vector<Eigen::Vector3d>& core);
  void explain(const Eigen::Vector3d& cube);
  bool may_see_missing(const Eigen::Vector3d& center, double radius) const;
  bool lacks_most(const Eigen::Vector3d& cube) const;
  bool may_grow(int cameras, double finest);
  bool grow(int cameras);
  void grow_while_unexplained(StageVolume& out);
  void find_partial(StageVolume& out);
  Eigen::AlignedBox3d box_of_cubes() const;

  BlockPictures pictures_;
  std::vector<Eigen::Vector3d> cubes_, next_, core_;
  std::vector<std::size_t> asked_;  ///< cameras that know, in the order in which they are asked
  std::vector<std::vector<std::uint8_t>> unexplained_;
  std::vector<std::vector<int>> unexplained_sums_;  ///< of cameras that lack any; else empty
  std::vector<int> covered_;
  std::vector<std::pair<std::int64_t, int>> places_;
  std::vector<int> part_of_, queue_;
  std::vector<Part> parts_;
  int missing_ = 0;  ///< blocks that nothing explains, of all cameras
  Eigen::Vector3d focus_ = Eigen::Vector3d::Zero();
  int outvoted_ = 0;
  double reach_ = 0;
  double half_ = 0;  ///< of a cube's side
};

}  // namespace floatstage::recon
