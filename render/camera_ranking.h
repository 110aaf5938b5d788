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
struct RankingSample {
  Eigen::Vector3f point = Eigen::Vector3f::Zero();
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();  ///< outwards, of unit length; zero: of no surface
};
using RankingSamples = ShortList<RankingSample, 2 * kRankingSamples>;

/// Some corners of a mesh's triangles, spread over it: what cameras are ranked by.
RankingSamples ranking_samples(const Mesh& mesh);

/// How much a view's choice of cameras asks a point: 1 in the middle of the picture, falling smoothly outside
/// it, for what the view shows decides.
double importance(const View& view, const Eigen::Vector3d& world);

/// How far each camera is from the view, in radians: the mean angle, over sample points of the proxy, between
/// the ray to the view and the ray to the camera (the angular penalty of Buehler et al. 2001). What the view
/// shows counts most. One ray after the other: the reference of CameraRanking.
std::vector<double> mean_angles(const std::vector<RigCamera>& cameras, const RankingSamples& samples,
                                const View& view);

/// How well a camera has a point in its picture: 1 inside, falling to 0 over a fiftieth of its width beyond
/// the border, so that somebody who walks out of it leaves by degrees.
double in_picture(const RigCamera& camera, const Eigen::Vector3d& world);

/// How well a camera sees a surface there, but for what stands before it: in_picture(), falling to 0 where it
/// looks along the surface.
double shows(const RigCamera& camera, const RankingSample& sample);

/// A camera among all by its mean angle.
struct RankedCamera {
  std::int64_t nanoradians = 0;  ///< rounded, so that cameras do not swap with the last bit of a sum
  int place = 0;                 ///< among all by their places in the world: ties go by it
  int camera = -1;
  double angle = 0;  ///< radians
};

/// A camera that is blended, and how much it counts.
struct BlendedCamera {
  int camera = -1;
  double fade = 0;  ///< above 0
};

/// Ranks cameras for many views of one scene: the rays from its samples to its cameras, and which of them has
/// which in its picture, are found once. One thread at a time.
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

  /// What some blended cameras lack: how much of the view lies beyond their pictures, of 1, and how near each
  /// camera is to it.
  struct Rest {
    double lacking = 0;
    std::span<const RankedCamera> ranked;  ///< all cameras; lives until the next call of rank()
  };
  /// Ranks cameras by what is missing in the pictures of those that are blended: by the mean angle over it,
  /// half a turn more where they do not show it either, and over all the rest, which counts a fiftieth. Where
  /// nothing is missing it is the last rank() of the same view itself.
  Rest rank_rest(const View& view, std::span<const BlendedCamera> blended);

 private:
  void order(double total, std::vector<RankedCamera>& ranked) const;

  RankingSamples samples_;
  std::vector<int> by_place_;           // the cameras, by the coordinates of their centres
  std::size_t lanes_ = 0;               // the cameras' number, padded
  std::vector<double> centers_, rays_;  // x, y and z of all lanes; of the rays one such list a sample
  std::vector<double> pictured_;        // in_picture() of each sample's lanes
  std::vector<double> shown_;           // shows() of them
  std::vector<double> angles_;          // of each lane
  std::vector<RankedCamera> ranked_, rest_;
};

}  // namespace floatstage::render
