#pragma once

namespace floatstage {

/// From now on this thread gets what others leave of the processor: 10 of 19 steps of niceness are a tenth
/// of what a usual thread gets beside it, 19 a seventieth. Threads that it begins inherit that; those of
/// parallel_for() do not.
void give_way(int nice);

}  // namespace floatstage
