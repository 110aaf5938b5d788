#pragma once

#include <filesystem>
#include <vector>

#include "core/result.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {

struct JoinReport {
  int frames = 0;
  std::vector<std::string> notes;
};

/// One take of several, one after the other: the same cameras and rig, pictures decoded and written again
/// without loss (what was H.264 becomes FFV1). Times stay where each take begins after the one before it
/// ended, else it begins one frame later. What was derived is left out. InvalidArgument names what differs;
/// nothing is left behind when it fails. Sealed.
Result<JoinReport> join_takes(const std::vector<std::filesystem::path>& takes,
                              const std::filesystem::path& out, Progress* progress);

}  // namespace floatstage::pipeline
