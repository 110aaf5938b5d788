#pragma once

#include <cstdint>
#include <vector>

namespace floatstage {

/// Continues a grey picture where `mask` is 0: every unknown pixel takes the smooth continuation of the known ones
/// around it (pull-push over a pyramid, Gortler et al. 1996). Known pixels stay as they are.
void fill_unknown(int width, int height, const std::uint8_t* mask, std::uint8_t* gray);

}  // namespace floatstage
