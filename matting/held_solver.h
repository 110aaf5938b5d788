#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "matting/laplacian_stencil.h"

// Private to the stage.
namespace floatstage::matting {

/// What solve_band() solves, by conjugate gradients, for bands whose every pixel is held by its `weight`:
/// that makes the system well-conditioned, and some sixty passes over it cost a fraction of a factor (ADR
/// 0318). Values are within 1e-3 of the exact ones, a quarter of a step of 8 bits. Nothing where a pixel is
/// held too weakly for that, or where the passes do not get there; solve_band() answers then. The same bytes
/// each time.
std::optional<std::vector<double>> solve_held_band(const LaplacianStencil& stencil,
                                                   const std::vector<std::uint8_t>& active,
                                                   const std::vector<double>& weight,
                                                   const std::vector<double>& value);

/// solve_held_band() compiled for one instruction set.
struct HeldSolver {
  const char* name;
  std::optional<std::vector<double>> (*solve)(const LaplacianStencil&, const std::vector<std::uint8_t>&,
                                              const std::vector<double>&, const std::vector<double>&);
};
std::vector<HeldSolver> all_held_solvers();  ///< of all sets that this processor has, for tests

}  // namespace floatstage::matting
