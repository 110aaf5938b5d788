#pragma once

#include <filesystem>
#include <vector>

#include "core/result.h"
#include "pipeline/reproduce/comparison.h"

namespace floatstage::pipeline {

/// A light field whose pictures' names say where they were taken (`import lightfield`), read once.
struct LightField {
  Rig rig;
  std::vector<Image> pictures;  ///< RGB, one a camera
  Mesh plane;                   ///< where neighbouring pictures agree best
};

/// NotFound and BadData of the names' reader and of the pictures; InvalidArgument for cameras on no grid.
Result<LightField> load_light_field(const std::filesystem::path& folder);

/// Every `step`-th picture of every `step`-th row as photographs; the pictures in the middle between them as
/// views; nothing counts within a twelfth of the width from the sides, where not all cameras see.
/// InvalidArgument for a step that leaves no such view.
Result<TestScene> thinned(const LightField& field, int step);

}  // namespace floatstage::pipeline
