#pragma once

#include <functional>
#include <optional>

#include "capture/take.h"
#include "core/frame.h"
#include "core/image.h"
#include "core/result.h"
#include "matting/keyers/plate.h"

namespace floatstage::pipeline {

/// What is said of a camera whose plate is of no use.
inline constexpr const char* kPlateDoesNotFit =
    "its plate does not show what stands behind its photographs (it was moved since, or the light has "
    "changed)";

/// Whether most of up to four photographs of a camera, spread over the take, pass: each with its RGB. One
/// that gives nothing is not counted; of none, nothing is wrong. Errors: those of the take.
Result<bool> most_photographs_pass(
    capture::TakeReader& take, int camera,
    const std::function<std::optional<bool>(const Frame& photograph, const Image& rgb)>& passes);

/// Whether most photographs of a camera show no more than half of their picture changed before a plate of
/// their size: nobody fills more, a camera that moved and other light do. Errors: those of the take.
Result<bool> shows_the_stage(capture::TakeReader& take, int camera, const matting::Plate& plate);

/// A camera's empty stage as it was shot, in colour; empty where nobody shot it, where it is
/// grey, or where it does not fit the take's photographs, which a warning then says with the camera's name:
/// it was moved since, or most of the picture has another light. Errors: those of its files and of the take.
Result<matting::Plate> fitting_plate(capture::TakeReader& take, int camera);

}  // namespace floatstage::pipeline
