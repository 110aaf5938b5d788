#pragma once

#include <string>
#include <vector>

#include "core/image.h"

namespace floatstage::matting {

/// What a camera's keyer learns from.
struct KeySamples {
  std::vector<Image> pictures;  ///< whole photographs, one channel or RGB
  bool empty_stage = false;     ///< they show the stage without anybody: clean plates
};

/// The words of the keyers that suit cameras which are keyed picture by picture, as make_keyer() takes them,
/// one a camera: "chroma" where green or blue cloth is the backdrop; else "plate" where the empty stage was
/// shot, and then for all cameras where it was: cloth that only some have before them is a wall among others;
/// else "luminance" before a black stage. Empty where it is none of these.
std::vector<std::string> choose_keyers(const std::vector<KeySamples>& cameras);

/// Of a camera for which choose_keyers() has nothing.
inline constexpr const char* kNothingToKeyBy =
    "no green or blue cloth, no black stage and no clean plate to key it by: photograph the empty stage "
    "(plates/<serial>.png of a take, --plates of cameras), or say what to key by with --matte";

}  // namespace floatstage::matting
