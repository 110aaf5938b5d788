#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/result.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {

/// HullOptions in words, as command lines and meshes/hull.json have them.
struct HullWords {
  std::string method = "exact", votes = "auto";
  recon::HullOptions options;  ///< what is a number
  std::vector<double> volume;  ///< x0 y0 z0 x1 y1 z1, metres; empty: from the silhouettes
};

/// InvalidArgument for a method or votes that are none.
Result<recon::HullOptions> hull_options(const HullWords& words);

/// What was asked for, in words: only what the method takes notice of.
nlohmann::json describe(const recon::HullOptions& options);

/// The options that describe() wrote; absent when `description` is none. What the method takes no notice of
/// has its default.
std::optional<recon::HullOptions> parse_hull_options(const nlohmann::json& description);

}  // namespace floatstage::pipeline
