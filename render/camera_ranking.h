#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/mesh.h"
#include "core/rig.h"
#include "core/view.h"
#include "render/short_list.h"

namespace floatstage::render {

inline constexpr std::size_t kRankingSamples = 96;  ///< at least, of a mesh that has as many triangles
using RankingSamples = ShortList<Eigen::Vector3f, 2 * kRankingSamples>;

/// Some corners of a mesh, spread over it: what cameras are ranked by.
RankingSamples ranking_samples(const Mesh& mesh);

/// How far each camera is from the view, in radians: the mean angle, over sample points of the proxy, between
/// the ray to the view and the ray to the camera (the angular penalty of Buehler et al. 2001). What the view
/// shows counts most. One ray after the other: the reference of CameraRanking.
std::vector<double> mean_angles(const std::vector<RigCamera>& cameras, const RankingSamples& samples,
                                const View& view);

/// A camera among all by its mean angle.
struct RankedCamera {
  std::int64_t nanoradians = 0;  ///< rounded, so that cameras do not swap with the last bit of a sum
  int place = 0;                 ///< among all by their places in the world: ties go by it
  int camera = -1;
  double angle = 0;  ///< radians
};

/// Ranks cameras for many views of one scene: the rays from its samples to its cameras are found once. One
/// thread at a time.
class CameraRanking {
 public:
  CameraRanking() = default;
  CameraRanking(const std::vector<RigCamera>& cameras, const RankingSamples& samples) {
    set(cameras, samples);
  }
  /// Replaces cameras and samples; storage is kept.
  void set(const std::vector<RigCamera>& cameras, const RankingSamples& samples);

  /// All cameras, nearest first; lives until the next call.
  std::span<const RankedCamera> rank(const View& view);

 private:
  RankingSamples samples_;
  std::vector<int> by_place_;           // the cameras, by the coordinates of their centres
  std::size_t lanes_ = 0;               // the cameras' number, padded
  std::vector<double> centers_, rays_;  // x, y and z of all lanes; of the rays one such list a sample
  std::vector<double> angles_;          // of each lane
  std::vector<RankedCamera> ranked_;
};

}  // namespace floatstage::render
