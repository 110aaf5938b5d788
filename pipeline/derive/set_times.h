#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "capture/take.h"
#include "capture/time_offsets.h"
#include "core/result.h"
#include "pipeline/derive/derived_take.h"

namespace floatstage::pipeline {

struct SetTimesReport {
  DerivedReport take;
  std::vector<int> moved;              ///< by camera, frames
  std::vector<std::string> sentences;  ///< one a camera that was moved: by how much, and what is left
};

/// Makes `out`, a take in which every camera's pictures stand at the instants that they were taken at, by
/// whole frames: those of a camera that `times` says to be a frame behind most others move to the frame
/// before. What is left, up to half a frame, becomes the new take's times.json. Instants that a camera has no
/// picture of any more, at either end, are left out. Cameras that were not measured stay. Nothing is decoded
/// (derive_take()).
///
/// Errors: NotFound for a take without a frame rate, or times of none of its cameras; InvalidArgument when no
/// camera is half a frame apart, or no instants are left; those of derive_take().
Result<SetTimesReport> set_times(const capture::TakeReader& take, const capture::TimeOffsetFile& times,
                                 const std::filesystem::path& out);

}  // namespace floatstage::pipeline
