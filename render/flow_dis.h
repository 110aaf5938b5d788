#pragma once

#include "render/flow.h"

namespace floatstage::render {

/// OpenCV's Dense Inverse Search (Kroeger et al. 2016) with variational refinement.
Result<std::unique_ptr<FlowEstimator>> make_dis_flow(const FlowOptions& options);

}  // namespace floatstage::render
