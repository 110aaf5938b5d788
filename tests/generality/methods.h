#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tests/generality/sets.h"

namespace floatstage::generality {

/// What one method made of one set.
struct Outcome {
  int asked = 0, made = 0;     ///< cameras
  double mean = 0, worst = 1;  ///< IoU with the truth, over those with a matte
  std::string worst_camera;
  std::vector<std::string> said;  ///< errors, failures, remarks: what a person reads
};

/// Every way to mattes that makes some.
std::vector<std::string> all_methods();

/// Mattes the take by the method, as `matte --matte` does, and compares frame 0 with the set's truth. Short
/// form: of methods that look at one camera at a time four cameras, spread over the rig; of spectral matting
/// one.
Outcome outcome_of(const std::string& method, const StageSet& set, const std::filesystem::path& take);

}  // namespace floatstage::generality
