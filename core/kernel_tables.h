#pragma once

#include <cstdint>
#include <vector>

// For files that have included <hwy/highway.h>: which instruction sets there are is theirs to say.
#ifndef HWY_DYNAMIC_DISPATCH
#error "include <hwy/highway.h> first"
#endif

namespace floatstage {

/// Writes the functions of one instruction set, the one that Highway has chosen, into a table: what
/// HWY_DYNAMIC_DISPATCH calls.
template <class Table>
using FillTable = void (*)(Table*);

/// The table of the best instruction set that this machine has.
template <class Table>
Table native_kernels(FillTable<Table> fill) {
  Table best{};
  fill(&best);
  return best;
}

/// The tables of all instruction sets that it has, for tests; one thread.
template <class Table>
std::vector<Table> kernels_of_all_sets(FillTable<Table> fill) {
  std::vector<Table> all;
  native_kernels(fill);  // chosen before the choice is played with
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(target);
    fill(&all.emplace_back());
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  return all;
}

}  // namespace floatstage
