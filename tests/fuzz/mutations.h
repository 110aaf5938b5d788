#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace floatstage {

/// How many damaged versions of a seed of `size` bytes there are: a truncation at every length (at most 512
/// of them, evenly spread) and 1024 mutations.
std::size_t mutation_count(std::size_t size);

/// Version `index` of `seed`, in [0, mutation_count(seed.size())): the same bytes on every machine.
/// Truncations come first; then flipped bits, extreme bytes, pieces removed, repeated or moved, and numbers
/// replaced by hostile ones.
std::string mutated(std::string_view seed, std::size_t index);

}  // namespace floatstage
