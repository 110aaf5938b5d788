#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "core/matte.h"
#include "core/rig.h"

namespace floatstage::recon {

/// Holds a mesh's vertices to where the cameras saw them: remembers the pixel of every vertex in every view
/// that has a matte, and, when vertices are merged, of all that became one. As long as every vertex stays
/// within the limit of all its pixels, so does the surface between them, and with it every silhouette (up to
/// perspective within a triangle).
class ReprojectionBound {
 public:
  ReprojectionBound(const Rig& rig, std::span<const Matte> mattes, std::span<const Eigen::Vector3d> positions,
                    double limit);

  double limit() const { return limit_; }
  void set_limit(double limit) { limit_ = limit; }

  /// May vertex v, with all that was merged into it, lie at `position`?
  bool allows(std::size_t v, const Eigen::Vector3d& position) const;
  /// The furthest point on the way from `start`, which is allowed, to `wish` that is allowed too, nearly.
  Eigen::Vector3d nearest_allowed(std::size_t v, const Eigen::Vector3d& start,
                                  const Eigen::Vector3d& wish) const;
  /// From now on `stays` stands for all that `gone` stood for.
  void merge(std::size_t gone, std::size_t stays);

  /// Largest distance in any view between a point and the segment from a to b, px; infinite where one cannot
  /// be seen.
  double distance(const Eigen::Vector3d& point, const Eigen::Vector3d& a, const Eigen::Vector3d& b) const;

  /// Adds to `moves` (per camera, px) how far what v stands for has moved when v lies at `position`.
  void measure(std::size_t v, const Eigen::Vector3d& position, std::vector<double>& moves) const;

 private:
  struct Eye {
    const RigCamera* camera;
    std::size_t index;
  };
  template <class Visit>
  bool visit(std::size_t v, const Eigen::Vector3d& position, Visit visit) const;

  std::vector<Eye> eyes_;
  std::vector<Eigen::Vector2d> seen_;             ///< per vertex and eye; NaN: not seen
  std::vector<std::vector<std::size_t>> merged_;  ///< per vertex: what else it stands for
  double limit_;
};

}  // namespace floatstage::recon
