// The kernels in vectors, compiled once for every instruction set that Highway knows here.

#include "matting/keyers/row_kernels.h"

#include <algorithm>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matting/keyers/row_kernels.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

#include "core/kernel_tables.h"

HWY_BEFORE_NAMESPACE();
namespace floatstage::matting::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using Bytes = HWY_CAPPED(std::uint8_t, 64);
using F = HWY_CAPPED(float, 16);

void quantize(const float* values, std::size_t padded, float steps, std::int32_t* out) {
  const F d;
  const hn::RebindToSigned<F> whole;
  for (std::size_t x = 0; x < padded; x += hn::Lanes(d))
    hn::StoreU(hn::NearestInt(hn::Mul(hn::LoadU(d, values + x), hn::Set(d, steps))), whole, out + x);
}

void raise(const std::uint8_t* other, std::size_t count, std::uint8_t* out) {
  const Bytes d;
  std::size_t x = 0;
  for (; x + hn::Lanes(d) <= count; x += hn::Lanes(d))
    hn::StoreU(hn::Max(hn::LoadU(d, out + x), hn::LoadU(d, other + x)), d, out + x);
  for (; x < count; ++x) out[x] = std::max(out[x], other[x]);
}

void lower(const std::uint8_t* other, std::size_t count, std::uint8_t* out) {
  const Bytes d;
  std::size_t x = 0;
  for (; x + hn::Lanes(d) <= count; x += hn::Lanes(d))
    hn::StoreU(hn::Min(hn::LoadU(d, out + x), hn::LoadU(d, other + x)), d, out + x);
  for (; x < count; ++x) out[x] = std::min(out[x], other[x]);
}

void table(RowKernels* out) { *out = {hwy::TargetName(HWY_TARGET), quantize, raise, lower}; }

}  // namespace
}  // namespace floatstage::matting::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::matting {

HWY_EXPORT(table);

namespace {

void fill_table(RowKernels* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

}  // namespace

const RowKernels& row_kernels() {
  static const RowKernels best = native_kernels(fill_table);
  return best;
}

std::vector<RowKernels> all_row_kernels() { return kernels_of_all_sets(fill_table); }

}  // namespace floatstage::matting
#endif
