#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/mesh.h"
#include "render/cpu/cover_kernels.h"
#include "render/cpu/raster_kernels.h"

// A scanline rasteriser for closed meshes of many small triangles: vertices on a grid of 1/256 px, coverage
// by exact integer edge functions with the top-left rule (as OpenGL's), depth by 1/z, which is affine on the
// screen. Triangles are drawn in their order, so results do not depend on the number of bands.
namespace floatstage::render::cpu {

/// Pixel = (x, y) / z of `rows` * (point, 1), the first pixel's centre at (0.5, 0.5); planes as of a View.
struct RasterCamera {
  Eigen::Matrix<float, 3, 4> rows;
  float near_plane = 0, far_plane = 0;
  int width = 0, height = 0;
};

/// A mesh as a raster camera sees it. Storage is kept from picture to picture.
class ScreenMesh {
 public:
  /// `closed`: back faces may be culled where no vertex is beyond a plane. The mesh must stay until the last
  /// draw(). Vertices are transformed by project(), in any number of calls over all of [0, chunks()).
  void begin(const Mesh& mesh, const RasterCamera& camera, bool closed);
  std::size_t chunks() const;
  void project(std::size_t chunk);

  /// Draws rows [first, last): inverse_z gets 1/z where that is larger than what is there, `triangle` (may be
  /// null) the index of the triangle. Both are width x height of the camera, and cleared to 0 by the call.
  void draw(int first, int last, float* inverse_z, std::uint32_t* triangle) const;

  /// Marks which samples of wanted pixels are covered (see cover_triangles()); nothing is cleared.
  void cover(const CoverRows& to) const;

 private:
  struct Corner {  // homogeneous: x/z, y/z are pixels
    double x = 0, y = 0, z = 0;
  };
  // Calls draw(vertices, corners, count, first_index, cull) for what is there.
  template <class Draw>
  void walk(const Draw& draw) const;
  template <class Draw>
  void walk_clipped(const std::uint32_t* corners, std::uint32_t index, const Draw& draw) const;

  const Mesh* mesh_ = nullptr;
  RasterCamera camera_;
  bool closed_ = false;
  std::vector<ScreenVertex> vertices_;  // 1/z 0: beyond a plane or far outside, to be clipped
  std::vector<std::uint8_t> to_clip_;   // a chunk each: it holds vertices to be clipped
};

}  // namespace floatstage::render::cpu
