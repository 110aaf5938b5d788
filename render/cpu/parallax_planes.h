#pragma once

#include <array>
#include <functional>
#include <vector>

#include "render/cpu/position_kernels.h"
#include "render/parallaxes.h"

namespace floatstage::render::cpu {

/// The surface along a row of a window, as lists of its `count` pixels, padded to Covered::kAlign.
struct SurfaceRow {
  int count = 0;
  std::vector<float> x, inverse_z, nx, ny, nz;  ///< px of the window; normals in the world

  void resize(std::size_t padded);
};

/// Finds Parallaxes. Keeps its memory.
class ParallaxPlanes {
 public:
  struct Task {
    ViewRays rays;
    CentersInView centers{};
    ShortList<float, kMostListed> fade;  ///< of each image
    int width = 0, height = 0;           ///< of the window
    int shrink = 1, threads = 0;
  };
  /// What the surface is along row y; called by several threads at once.
  using ReadRow = std::function<void(int y, SurfaceRow& row)>;
  void run(const Task& task, const ReadRow& read, Parallaxes& out);

 private:
  struct Worker {
    SurfaceRow row;
    std::array<std::vector<float>, kMostListed> x, y;
    std::vector<float> scale;  // of a row
  };
  static void add_row(const Task& task, int y, Worker& worker, Parallaxes& out);
  static void settle_row(int shrink, int y, Worker& worker, Parallaxes& out);

  std::vector<Worker> workers_;
};

}  // namespace floatstage::render::cpu
