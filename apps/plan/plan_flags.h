#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace floatstage::apps {

/// How a verb's work is divided and who does it: `--plan` and what belongs to it.
struct PlanFlags {
  std::string backend;                    ///< "local", "slurm"; empty: the verb does it all by itself
  std::filesystem::path folder, scratch;  ///< empty: beside the take; in the plan's folder
  int workers = 0;                        ///< processes side by side; 0: as many as cores and -j allow
  int chunk = 100;                        ///< frames of an item
  int retries = 2;                        ///< so often an item is tried again
  std::string sbatch;                     ///< options for sbatch, as a shell reads them
};

void add_plan_flags(CLI::App& verb, PlanFlags& flags);

/// The words of a command line without those that say how it is divided.
std::vector<std::string> without_plan_flags(const std::vector<std::string>& words);

}  // namespace floatstage::apps
