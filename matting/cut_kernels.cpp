// The kernels in vectors, compiled once for every instruction set that Highway knows here. Whole numbers, so
// that all give the same.

#include "matting/cut_kernels.h"

#include <algorithm>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matting/cut_kernels.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

#include "core/kernel_tables.h"

HWY_BEFORE_NAMESPACE();
namespace floatstage::matting::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using U = HWY_CAPPED(std::uint32_t, 16);
using Bytes = hn::Rebind<std::uint8_t, U>;
using VU = hn::Vec<U>;

HWY_INLINE VU wide(const std::uint8_t* at) { return hn::PromoteTo(U(), hn::LoadU(Bytes(), at)); }

HWY_INLINE VU difference(CutKernels::Planes a, CutKernels::Planes b, std::size_t x) {
  VU sum = hn::Zero(U());
  for (int k = 0; k < 3; ++k) {
    const VU off = hn::Sub(wide(a[k] + x), wide(b[k] + x));  // the square of its wrapped negative is the same
    sum = hn::Add(sum, hn::Mul(off, off));
  }
  return sum;
}

void differences(CutKernels::Planes a, CutKernels::Planes b, std::size_t count, std::uint32_t most,
                 std::uint32_t* out) {
  const U d;
  const VU limit = hn::Set(d, most);
  for (std::size_t x = 0; x < count; x += hn::Lanes(d))
    hn::StoreU(hn::Min(difference(a, b, x), limit), d, out + x);
}

void add(CutKernels::Planes a, CutKernels::Planes b, const std::uint8_t* asked_a, const std::uint8_t* asked_b,
         std::size_t count, CutKernels::Contrast& contrast) {
  const U d;
  const std::size_t lanes = hn::Lanes(d);
  // Sums of as many as 32 bits hold.
  constexpr std::size_t kMost = 16384;
  for (std::size_t first = 0; first < count; first += kMost) {
    VU sum = hn::Zero(d), pairs = hn::Zero(d), most = hn::Zero(d);
    for (std::size_t x = first; x < std::min(count, first + kMost); x += lanes) {
      const VU one =
          hn::IfThenElseZero(hn::FirstN(d, count - x), hn::Or(wide(asked_a + x), wide(asked_b + x)));
      const VU off = hn::And(hn::Sub(hn::Zero(d), one), difference(a, b, x));
      sum = hn::Add(sum, off);
      pairs = hn::Add(pairs, one);
      most = hn::Max(most, off);
    }
    contrast.sum += hn::GetLane(hn::SumOfLanes(d, sum));
    contrast.pairs += hn::GetLane(hn::SumOfLanes(d, pairs));
    contrast.most = std::max(contrast.most, hn::GetLane(hn::MaxOfLanes(d, most)));
  }
}

}  // namespace

void table(CutKernels* out) { *out = {hwy::TargetName(HWY_TARGET), differences, add}; }

}  // namespace floatstage::matting::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::matting {

HWY_EXPORT(table);

namespace {

void fill_table(CutKernels* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

}  // namespace

const CutKernels& cut_kernels() {
  static const CutKernels best = native_kernels(fill_table);
  return best;
}

std::vector<CutKernels> all_cut_kernels() { return kernels_of_all_sets(fill_table); }

}  // namespace floatstage::matting
#endif
