#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace floatstage::apps {

/// Of `known` the word that `typed` was probably meant to be; empty when none is like it. Alike are words
/// that a few slips of the fingers apart (insertions, losses, exchanges and swapped neighbours: the distance
/// of Damerau, CACM 7(3), 1964, restricted), at most one for every three letters, and words of several parts,
/// as options are, with a part in common: --out-size and --size.
std::string closest(std::string_view typed, const std::vector<std::string>& known);

/// "; did you mean '--size'?", or nothing.
std::string did_you_mean(std::string_view typed, const std::vector<std::string>& known);

}  // namespace floatstage::apps
