#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace floatstage::studio::wire {

/// A matte's bytes as runs: nearly all of a matte is 0 or 255, so that a run-length code takes a fourteenth
/// of it in 0.1 ms (docs/adr/0138). A byte below 128 is that many single bytes that follow; otherwise a run
/// of the byte that follows: of its low six bits, or, with bit 6 set, of 14 bits over two bytes.
std::string encode_runs(std::span<const std::uint8_t> bytes);

/// Exactly `size` bytes back. BadData when there are fewer or more; memory is taken only for `size`.
Result<std::vector<std::uint8_t>> decode_runs(std::string_view code, std::size_t size);

}  // namespace floatstage::studio::wire
