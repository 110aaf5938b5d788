#pragma once

#include <span>
#include <vector>

#include "core/matte.h"
#include "core/result.h"
#include "core/rig.h"
#include "core/silhouette.h"
#include "recon/silhouette.h"

namespace floatstage::recon {

/// What visual_hull() was given of each camera: a matte or an outline. The spans outlive it.
class HullInput {
 public:
  HullInput(const Rig& rig, std::span<const Matte> mattes, int threads)
      : rig_(rig), mattes_(mattes), threads_(threads), count_(mattes.size()) {}
  HullInput(const Rig& rig, std::span<const Silhouette> outlines, int threads)
      : rig_(rig), outlines_(outlines), threads_(threads), count_(outlines.size()) {}

  /// Counts and sizes, and of outlines what a sender could have got wrong; sentences name the camera.
  Result<void> check(PolygonBounds& memory) const;

  /// False: nothing is known of this camera.
  bool knows(std::size_t camera) const;
  bool shows_subject(std::size_t camera) const;

  bool outlined() const { return !outlines_.empty(); }

  /// Null when mattes were given.
  const Silhouette* outline(std::size_t camera) const {
    return outlines_.empty() ? nullptr : &outlines_[camera];
  }
  const Matte& matte(std::size_t camera) const { return mattes_[camera]; }  ///< when mattes were given

  /// As mattes. Outlines are filled when they are first asked for, which a strict frame with the subject
  /// inside all pictures never does.
  std::span<const Matte> mattes();

 private:
  const Rig& rig_;
  std::span<const Matte> mattes_;
  std::span<const Silhouette> outlines_;
  std::vector<Matte> filled_;
  int threads_;
  std::size_t count_;
};

}  // namespace floatstage::recon
