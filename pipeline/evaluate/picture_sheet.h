#pragma once

#include <string>
#include <vector>

#include "core/image.h"
#include "pipeline/evaluate/evaluate.h"

namespace floatstage::pipeline {

/// One held-out view in a row: truth, each method, and the last method's difference to truth (three times as
/// strong), cropped to the silhouette, each with its name.
Image sheet_row(const HeldOutView& view, const std::vector<std::string>& methods);

}  // namespace floatstage::pipeline
