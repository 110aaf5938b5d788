#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "pipeline/export/instant.h"

namespace floatstage::pipeline {

using Rgb = std::array<std::uint8_t, 3>;

/// Who sees what of an instant's surface, as the renderers decide it (docs/adr/0063): at least half of the
/// four depths around the place are no nearer than the point, and the matte shows it.
class SurfaceSights {
 public:
  /// `instant` outlives this. Draws one depth map a camera.
  explicit SurfaceSights(const StraightInstant& instant);

  /// Where camera `camera` sees the point; nothing where it does not.
  std::optional<Eigen::Vector2d> see(std::size_t camera, const Eigen::Vector3d& point) const;

 private:
  bool is_nearest(std::size_t camera, const Eigen::Vector2d& pixel, double z) const;

  const StraightInstant& instant_;
  std::vector<std::vector<float>> depth_;
  double tolerance_ = 0;  ///< metres
};

/// Normals of a mesh's vertices: those of their triangles, by area. Zero where a vertex has no triangle.
std::vector<Eigen::Vector3f> vertex_normals(const Mesh& mesh);

/// Colours of a mesh's vertices from the photographs (`mesh` is the instant's, or finer). The three cameras
/// that show most pixels of the place count, each by how many more pixels it has than the fourth, so that
/// colours change without a step where one camera takes another's place. Where nobody sees the surface, the
/// nearest colours along it.
std::vector<Rgb> colors_of_vertices(const StraightInstant& instant, const SurfaceSights& sights,
                                    const Mesh& mesh);

}  // namespace floatstage::pipeline
