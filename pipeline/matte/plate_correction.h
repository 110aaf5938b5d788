#pragma once

#include <memory>

#include "capture/take.h"
#include "core/frame.h"
#include "core/image.h"
#include "core/result.h"
#include "matting/keyers/empty_stage.h"
#include "matting/keyers/keyer.h"

namespace floatstage::pipeline {

/// A camera's keys by colour, corrected by a plate that was shot (docs/adr/0293): fixtures go, what no shadow
/// can be becomes subject. Immutable, thread safe.
class PlateCorrection {
 public:
  /// Null where there is nothing to correct with: nobody shot a plate, it is grey, the camera has moved
  /// since, or `keyer` compares with it anyway. Errors: those of its files and of the take.
  static Result<std::shared_ptr<const PlateCorrection>> of(capture::TakeReader& take, int camera,
                                                           const matting::Keyer& keyer);

  /// The key of a photograph, one channel, corrected; its own bytes where there is nothing to correct.
  Result<Image> correct(const Frame& photograph, Image key) const;

 private:
  explicit PlateCorrection(matting::EmptyStage stage) : stage_(std::move(stage)) {}

  matting::EmptyStage stage_;
};

}  // namespace floatstage::pipeline
