#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/take.h"
#include "core/result.h"
#include "matting/keyers/keyer.h"

namespace floatstage::pipeline {

/// mattes/keying.json: which keyer made a take's mattes, camera by camera.
struct KeyingRecord {
  std::string
      key;  ///< as the user asked: "chroma", "luminance:12"; "imported" when mattes came with the take
  std::vector<std::string> specs;  ///< per camera, exact (with the sampled colour); empty when imported
};

/// Absent when the take has not been keyed.
Result<std::optional<KeyingRecord>> load_keying(const TakeLayout& layout, const Rig& rig);
Result<void> save_keying(const KeyingRecord& record, const TakeLayout& layout, const Rig& rig);

/// The keyer of one camera: `spec` completed from its clean plate, or else from a few of its photographs.
Result<std::unique_ptr<matting::Keyer>> keyer_for(capture::TakeReader& take, int camera,
                                                  const std::string& spec);

}  // namespace floatstage::pipeline
