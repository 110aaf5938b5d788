#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "matting/keyers/keyer.h"

// Private to the stage: what each keyer's file gives to the table in keyer.cpp.
namespace floatstage::matting {

/// What a keyer is made from. `parameter` is what follows the colon of the spec; `samples` are RGB and of one
/// size.
struct KeyerRequest {
  std::optional<std::string_view> parameter;
  const std::vector<Image>& samples;
  const std::optional<CleanupOptions>& cleanup;
};

Result<std::unique_ptr<Keyer>> make_chroma_keyer(const KeyerRequest& request);
Result<std::unique_ptr<Keyer>> make_difference_keyer(const KeyerRequest& request);
Result<std::unique_ptr<Keyer>> make_luminance_keyer(const KeyerRequest& request);
Result<std::unique_ptr<Keyer>> make_plate_keyer(const KeyerRequest& request);

/// The threshold in a spec, a whole number of 8-bit steps from 1 to 254; `fallback` when none is given.
Result<int> threshold_of(const KeyerRequest& request, std::string_view keyer, int fallback);

}  // namespace floatstage::matting
