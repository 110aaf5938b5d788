#pragma once

#include <cstdint>
#include <span>

namespace floatstage::capture {

/// Whether every slice of an FFV1 picture (version 3, with slice checksums) is as the encoder wrote it. The
/// decoder checks too, but only to paint old pixels over the damage without saying so. (FFV1: RFC 9043,
/// "Slice Footer": slices are found from the back by their 24-bit sizes; the CRC of a slice with its footer
/// is zero.)
bool ffv1_intact(std::span<const std::uint8_t> picture);

}  // namespace floatstage::capture
