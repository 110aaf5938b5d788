#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json_fwd.hpp>

#include "core/result.h"
#include "recon/visual_hull.h"

namespace floatstage {

/// The command line's words for HullOptions, shared by the verbs that compute hulls.
struct HullFlags {
  std::string method = "exact", votes = "auto";
  HullOptions options;
  std::vector<double> volume;
};

void add_hull_flags(CLI::App& verb, HullFlags& flags);

/// InvalidArgument for a method or votes that are none.
Result<HullOptions> hull_options(const HullFlags& flags);

/// What was asked for, in the words of the flags: only what the method takes notice of.
nlohmann::json describe(const HullOptions& options);

}  // namespace floatstage
