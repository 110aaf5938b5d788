#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "detail/float_picture.h"

namespace floatstage::detail {

/// A curve a channel that makes one picture's colours another's: whatever exposure, white balance and gamma
/// did, as long as they did it everywhere alike.
struct ToneCurves {
  static constexpr std::size_t kKnots = 65;
  std::array<std::array<float, kKnots>, 3> to{};  ///< at even steps of encoded values, rising
  Light apply(const Light& light) const;          ///< linear light to linear light
};

/// From how often the two pictures show a brightness where `use` is not 0 (as exact histogram specification
/// does): both of one size, showing the same and equally sharp. Identity where fewer than 1,000 pixels count.
ToneCurves match_tones(const LightPicture& from, const LightPicture& to,
                       const std::vector<std::uint8_t>& use);

/// Where two pictures of one size show the same: 1; something else: 0 (thesis 4.3.1). Both as encoded values,
/// blurred by 2 px; the sum of squared differences over 5 x 5 px, of the channel in which it is largest,
/// stays below 0.35.
std::vector<std::uint8_t> matching_pixels(const LightPicture& child, const LightPicture& parent);

/// The same where the child may be shifted by up to `reach` px in any direction; found on pictures of at most
/// 512 px a side, in steps of half the reach.
std::vector<std::uint8_t> matching_nearby(const LightPicture& child, const LightPicture& parent, int reach);

/// Blurred by a Gaussian of `sigma` px; 0: as it is.
LightPicture blurred(const LightPicture& picture, double sigma);

}  // namespace floatstage::detail
