#pragma once

#include <vector>

#include <CLI/CLI.hpp>

#include "pipeline/hull_record.h"

namespace floatstage::apps {

/// The command line's words for HullOptions, shared by the verbs that compute hulls: one default for all.
struct HullFlags : pipeline::HullWords {
  std::vector<const CLI::Option*> words;  ///< what add_hull_flags() added

  /// Whether the command line said anything about the hull.
  bool given() const;
};

void add_hull_flags(CLI::App& verb, HullFlags& flags);

}  // namespace floatstage::apps
