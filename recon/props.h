#pragma once

#include <vector>

#include "core/image.h"
#include "core/matte.h"
#include "core/result.h"
#include "core/rig.h"

namespace floatstage::recon {

/// What stands on the stage between cameras and performers and is none of them: a lectern, a stand, a rail.
/// Where it is in a picture, the camera does not know whether somebody is behind it. Where several cameras
/// have it, how far it stands is known from the hull of its masks, and nobody who is nearer is behind it.
/// Compare L. Guan, J.-S. Franco, M. Pollefeys, "3D occlusion inference from silhouette cues", CVPR 2007
/// (docs/adr/0366-props-hide-and-do-not-carve.md). Read-only after construction, so thread safe.
class Props {
 public:
  Props() = default;
  /// `masks`: for each camera a picture of its size with one channel, 255 where something may hide somebody,
  /// else 0; empty where nothing does.
  Props(const Rig& rig, std::vector<Image> masks);

  bool any() const;

  /// How much of somebody, of 1, lies within what stands on the stage, where nobody can be: shadows on it
  /// that a matte took for somebody, or masks that are larger than it is.
  struct Within {
    double share = 0;
    int camera = -1;  ///< whose matte shows most of that
  };

  /// What carves the hull: the mattes, and within the masks what the other cameras have of somebody there:
  /// what lies on somebody for half of those that look there, and for the others behind what stands before
  /// it. Empty mattes stay so; all do where there are no masks. Outlines within masks are as coarse as
  /// 400,000 voxels about the hull. BadData where silhouettes bound too much.
  Result<std::vector<Matte>> silhouettes(const Rig& rig, std::vector<Matte> mattes, int threads,
                                         Within* within = nullptr) const;

  /// What stands before a camera.
  struct Mask {
    Image stands;              ///< one channel, 255 or 0; empty: nothing does
    std::vector<float> depth;  ///< px by px: metres along the axis to what is nearest; 0: may be near
    bool stands_at(int x, int y) const { return !stands.empty() && *stands.at(x, y) != 0; }
    double depth_at(int x, int y) const {
      return depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(stands.width) +
                   static_cast<std::size_t>(x)];
    }
  };

 private:
  void find_depths(const Rig& rig);

  std::vector<Mask> masks_;  // of each camera
};

}  // namespace floatstage::recon
