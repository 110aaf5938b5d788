#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "core/frame.h"
#include "core/matte.h"
#include "core/result.h"
#include "matting/keyers/keyer.h"
#include "matting/keyers/live_key.h"

namespace floatstage::pipeline {

/// A keyer's mattes as `live` makes them (LiveKey: the keyer's own, but for a step of opacity in a few pixels
/// of the edge), for any number of threads at a time: one LiveKey, with its memory, for each that asks (ADR
/// 0204).
class QuickKeyer {
 public:
  explicit QuickKeyer(std::unique_ptr<const matting::Keyer> keyer) : keyer_(std::move(keyer)) {}

  /// As matting::Keyer::key().
  Result<Matte> key(const Frame& photograph);

 private:
  std::unique_ptr<const matting::Keyer> keyer_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<matting::LiveKey>> idle_;
};

}  // namespace floatstage::pipeline
