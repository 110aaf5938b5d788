#pragma once

#include <optional>
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
  std::vector<const CLI::Option*> words;  ///< what add_hull_flags() added

  /// Whether the command line said anything about the hull.
  bool given() const;
};

void add_hull_flags(CLI::App& verb, HullFlags& flags);

/// The words for HullCare alone, for verbs with words of their own for the rest.
std::vector<const CLI::Option*> add_care_flags(CLI::App& verb, HullCare& care);

/// InvalidArgument for a method or votes that are none.
Result<HullOptions> hull_options(const HullFlags& flags);

/// What was asked for, in the words of the flags: only what the method takes notice of.
nlohmann::json describe(const HullOptions& options);

/// The options that describe() wrote; absent when `description` is none. What the method takes no notice of
/// has its default.
std::optional<HullOptions> parse_hull_options(const nlohmann::json& description);

}  // namespace floatstage
