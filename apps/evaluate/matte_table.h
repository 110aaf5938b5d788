#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"
#include "pipeline/chosen_take.h"

namespace floatstage::apps {

/// Mattes of a take against true ones.
struct MatteTruth {
  std::filesystem::path take;
  pipeline::LabelChoice labels;  ///< whose mattes, against those labels' truth
  std::filesystem::path truth;   ///< empty: the take's own, of a synthetic studio
  std::string frames;            ///< for parse_frames()
  std::filesystem::path json_file;
};

/// `evaluate --mattes`: a row a camera and their mean, printed, and as JSON where that is asked for.
Result<void> report_mattes(const MatteTruth& given);

}  // namespace floatstage::apps
