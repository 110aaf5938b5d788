#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"
#include "core/rig.h"
#include "core/take_layout.h"
#include "recon/props.h"

namespace floatstage::pipeline {

/// Of a take: where a camera's mask of what stands on the stage lies, if there is one:
/// occluders/<serial>.png, white, or opaque, where something may hide somebody.
std::filesystem::path occluder_file(const TakeLayout& take, const std::string& serial);

/// What stands on a take's stage.
struct Occluders {
  recon::Props props;
  std::string hash;  ///< of the pictures; empty where there are none
};

/// Errors: BadData for a picture that is no mask of its camera's size, or of no camera of the rig.
Result<Occluders> load_occluders(const TakeLayout& take, const Rig& rig);

}  // namespace floatstage::pipeline
