#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/image.h"

// Private to the stage: the matting Laplacian as a stencil, before anybody wants a sparse matrix of it.
namespace floatstage::matting {

/// The matting Laplacian of a picture, one half of its symmetric 5x5 stencil: `planes[k][p]` is L(p, p +
/// step(k)), where step(0) is the pixel itself, step(1), step(2) are to its right, step(3 + dx + 2) and
/// step(8 + dx + 2) are in the next two rows. Entries that reach out of the picture are 0.
struct LaplacianStencil {
  static constexpr int kSteps = 13;
  struct Step {
    int dx, dy;
  };
  static constexpr Step step(int k) { return k < 3 ? Step{k, 0} : k < 8 ? Step{k - 5, 1} : Step{k - 10, 2}; }
  static constexpr int plane_of(int dx, int dy) { return dy == 0 ? dx : dy == 1 ? dx + 5 : dx + 10; }

  int width = 0, height = 0;
  std::array<std::vector<double>, kSteps> planes;

  std::size_t pixels() const { return static_cast<std::size_t>(width) * height; }
  /// L(p, p + (dx, dy)) for any neighbour within two rows and columns; 0 beyond the border.
  double at(int x, int y, int dx, int dy) const;
};

/// Fills `stencil`, whose storage is kept from the last call. `picture` has 1 or 3 channels and at least 3x3
/// pixels. `known` is empty or a one-channel mask of the picture's size: windows whose nine pixels are all
/// not 0 are left out.
void build_stencil(const Image& picture, double epsilon, const Image& known, LaplacianStencil& stencil);

/// What build_stencil() is made of, compiled for one instruction set.
struct StencilKernels {
  const char* name;
  /// Adds every window that has an unknown pixel, but for its diagonal.
  void (*add_windows)(const Image& picture, double epsilon, const Image& known, LaplacianStencil& stencil);
  void (*reset_diagonal)(LaplacianStencil& stencil);
};
std::vector<StencilKernels> all_stencil_kernels();  ///< of all sets that this processor has, for tests

}  // namespace floatstage::matting
