#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/result.h"
#include "pipeline/evaluate/evaluate.h"

namespace floatstage::apps {

/// A held-out view and the scores of each method.
struct ScoredView {
  std::string serial;
  int frame;
  bool has_matte;  ///< false: the camera is only truth, and is scored where the proxy is
  std::map<std::string, pipeline::Scores> scores;
};

/// Where the scores of a run go besides the terminal; empty: nowhere.
struct ScoreFiles {
  std::filesystem::path json, csv;
};

/// Prints the means of each method and, of several frames, how they go over time; saves what `files` names.
/// `take` stands in the JSON.
Result<void> report_scores(const std::filesystem::path& take, const std::vector<ScoredView>& views,
                           const std::vector<std::string>& methods, const ScoreFiles& files);

/// Views on their way from one process to another. JSON's numbers are read as they were written, bit by bit;
/// a score that a view does not have is null.
nlohmann::json json_of(const std::vector<ScoredView>& views);
/// BadData when there are none in it.
Result<std::vector<ScoredView>> views_of(const nlohmann::json& views);

}  // namespace floatstage::apps
