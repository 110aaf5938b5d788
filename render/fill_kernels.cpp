// Plain loops, which compilers turn into vectors of each instruction set; without contraction, so that all
// give the same bits.

#include "render/fill_kernels.h"

#include <algorithm>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/fill_kernels.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

#include "core/kernel_tables.h"

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::HWY_NAMESPACE {
namespace {

template <std::size_t kStep>
HWY_INLINE void take_every(const float* HWY_RESTRICT values, const std::uint8_t* HWY_RESTRICT known,
                           std::size_t count, float* HWY_RESTRICT value) {
  for (std::size_t x = 0; x < count; ++x) {
    const float v = values[kStep * x];
    value[x] = known[x] != 0 ? v : 0.F;
  }
}

void take(const float* values, std::size_t step, const std::uint8_t* known, std::size_t count, float* value) {
  if (step == 1) return take_every<1>(values, known, count, value);
  if (step == 2) return take_every<2>(values, known, count, value);
  for (std::size_t x = 0; x < count; ++x) value[x] = known[x] != 0 ? values[step * x] : 0.F;
}

void pull(const float* HWY_RESTRICT v0, const float* HWY_RESTRICT w0, const float* HWY_RESTRICT v1,
          const float* HWY_RESTRICT w1, std::size_t count, float* HWY_RESTRICT value) {
  for (std::size_t x = 0; x < count; ++x) {
    const float sum = w0[2 * x] * v0[2 * x] + w0[2 * x + 1] * v0[2 * x + 1] + w1[2 * x] * v1[2 * x] +
                      w1[2 * x + 1] * v1[2 * x + 1];
    const float total = w0[2 * x] + w0[2 * x + 1] + w1[2 * x] + w1[2 * x + 1];
    value[x] = sum / (total > 0 ? total : 1.F);
  }
}

void pull_weights(const float* HWY_RESTRICT w0, const float* HWY_RESTRICT w1, std::size_t count,
                  float* HWY_RESTRICT weight) {
  for (std::size_t x = 0; x < count; ++x) {
    const float total = w0[2 * x] + w0[2 * x + 1] + w1[2 * x] + w1[2 * x + 1];
    weight[x] = std::min(total, 1.F);
  }
}

void expand(const float* HWY_RESTRICT coarse, std::size_t count, std::size_t width,
            float* HWY_RESTRICT fine) {
  fine[0] = coarse[0];
  const std::size_t last = count - 1;
  for (std::size_t x = 0; x < last; ++x) {
    fine[2 * x + 1] = coarse[x] * 0.75F + coarse[x + 1] * 0.25F;
    fine[2 * x + 2] = coarse[x] * 0.25F + coarse[x + 1] * 0.75F;
  }
  if (2 * last + 1 < width) fine[2 * last + 1] = coarse[last];
}

void push(const float* HWY_RESTRICT top, float upper, const float* HWY_RESTRICT bottom, float lower,
          const float* HWY_RESTRICT weight, std::size_t count, float* HWY_RESTRICT value) {
  for (std::size_t x = 0; x < count; ++x) {
    const float around = top[x] * upper + bottom[x] * lower;
    const float mixed = weight[x] * value[x] + (1 - weight[x]) * around;
    value[x] = weight[x] >= 1 ? value[x] : mixed;
  }
}

void table(FillKernels* out) { *out = {hwy::TargetName(HWY_TARGET), take, pull, pull_weights, expand, push}; }

}  // namespace
}  // namespace floatstage::render::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render {

HWY_EXPORT(table);

namespace {

void fill_table(FillKernels* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

}  // namespace

const FillKernels& fill_kernels() {
  static const FillKernels best = native_kernels(fill_table);
  return best;
}

std::vector<FillKernels> all_fill_kernels() { return kernels_of_all_sets(fill_table); }

}  // namespace floatstage::render
#endif
