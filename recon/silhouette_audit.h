#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/matte.h"
#include "core/rig.h"
#include "recon/hull_input.h"
#include "recon/stage_volume.h"
#include "recon/visual_hull.h"

namespace floatstage::recon {

/// Every silhouette against what the others agree on, in blocks (BlockPictures). Where a matte lacks a part
/// of the subject, the other cameras show subject there that no strict body explains, and a body explains it
/// that all but the guilty cameras agree on. Where a matte has too much, nothing explains it. Compare the
/// dissent measure of Hernández, Schmitt and Cipolla ("Silhouette coherence", 2007). Keeps its memory.
class SilhouetteAudit {
 public:
  /// Names the cameras at fault, worst first; nothing when no silhouette has more than kAllowed unexplained.
  /// `finder` holds what StageFinder::find() found for `input`. At most a quarter of the cameras can lack the
  /// same part: more are a majority's word, or a calibration's.
  std::vector<SilhouetteVerdict> audit(const Rig& rig, const HullInput& input, const StageFinder& finder);

  /// A share of a silhouette: what block borders and mattes that disagree by a pixel leave unexplained is
  /// less, on every set (ADR 0175).
  static constexpr double kAllowed = 0.05;

 private:
  static constexpr int kMostDissent = 8;
  struct Cube {
    Eigen::Vector3d center;
    int dissent = 0;
    std::array<std::int16_t, kMostDissent> cameras{};
  };

  bool admit(const BlockPictures& pictures, double half, bool small, int most, int cameras, Cube& cube) const;
  void carve(const StageFinder& finder, int most, int cameras);
  void blame(const BlockPictures& pictures, int dissent);
  bool explains(const BlockPictures& pictures, const Cube& cube) const;
  SilhouetteVerdict verdict(const BlockPictures& pictures, std::size_t camera) const;

  std::vector<Cube> cubes_, next_;
  double half_ = 0;
  std::vector<std::uint8_t> guilty_;
  std::vector<std::vector<std::uint8_t>> unexplained_, lost_;
  std::vector<std::vector<int>> sums_;
};

/// The matte with the blocks that a verdict says are lost as subject, and those around them: there the camera
/// does not know, and the others decide.
Matte mended(const Matte& matte, const SilhouetteVerdict& verdict);

}  // namespace floatstage::recon
