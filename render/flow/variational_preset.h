#pragma once

#include "render/flow.h"
#include "render/flow/field_solver.h"
#include "render/flow/picture_pyramid.h"

namespace floatstage::render {

/// How a preset solves, and what its pictures are prepared for. The solvers of the CPU and the GPU share it.
struct VariationalPreset {
  SolverOptions solver;
  PyramidOptions pyramid;
};

/// InvalidArgument for a preset or a finest scale that the variational flow does not have.
Result<VariationalPreset> variational_preset(const FlowOptions& options);

/// Levels of a pyramid of pictures of this size, more than `finest`.
int variational_levels(int width, int height, int finest);

}  // namespace floatstage::render
