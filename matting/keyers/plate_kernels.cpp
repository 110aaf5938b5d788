// The kernels in vectors, compiled once for every instruction set that Highway knows here, in one order and
// without contraction, so that all give the same bits.

#include "matting/keyers/plate_kernels.h"

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matting/keyers/plate_kernels.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

#include "core/kernel_tables.h"

HWY_BEFORE_NAMESPACE();
namespace floatstage::matting::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using F = HWY_CAPPED(float, 16);
using I = hn::RebindToSigned<F>;
using Bytes = hn::Rebind<std::uint8_t, F>;
using VF = hn::Vec<F>;

struct Colors {
  VF r, g, b;
};

HWY_INLINE VF to_float(hn::Vec<Bytes> v) { return hn::ConvertTo(F(), hn::PromoteTo(I(), v)); }

HWY_INLINE Colors load(const std::uint8_t* rgb) {
  hn::Vec<Bytes> r, g, b;
  hn::LoadInterleaved3(Bytes(), rgb, r, g, b);
  return {to_float(r), to_float(g), to_float(b)};
}

HWY_INLINE VF dot(const Colors& p, const Colors& q) {
  return hn::Add(hn::Add(hn::Mul(p.r, q.r), hn::Mul(p.g, q.g)), hn::Mul(p.b, q.b));
}

HWY_INLINE VF length(const Colors& p, const Colors& plate, VF darkest, VF brightest) {
  const VF square = hn::Add(dot(plate, plate), hn::Set(F(), 1e-3F));
  const VF bright = hn::Min(hn::Max(hn::Div(dot(p, plate), square), darkest), brightest);
  const Colors off{hn::Sub(p.r, hn::Mul(bright, plate.r)), hn::Sub(p.g, hn::Mul(bright, plate.g)),
                   hn::Sub(p.b, hn::Mul(bright, plate.b))};
  return hn::Sqrt(dot(off, off));
}

// Runs take(x, picture, plate) for whole vectors, and once more for what is left of the row, of which copies
// are read and `put` writes no more than there is.
template <class Take, class Put>
HWY_INLINE void for_row(const std::uint8_t* rgb, const std::uint8_t* plate, std::size_t count,
                        const Take& take, const Put& put) {
  const std::size_t lanes = hn::Lanes(F());
  std::size_t x = 0;
  for (; x + lanes <= count; x += lanes) take(x, load(rgb + 3 * x), load(plate + 3 * x));
  if (x == count) return;
  std::uint8_t last[2][3 * 16] = {};
  for (std::size_t i = 0; i < 3 * (count - x); ++i) {
    last[0][i] = rgb[3 * x + i];
    last[1][i] = plate[3 * x + i];
  }
  put(x, count - x, load(last[0]), load(last[1]));
}

void lengths(const std::uint8_t* rgb, const std::uint8_t* plate, std::size_t count, float darkest,
             float brightest, float* out) {
  const F d;
  const VF low = hn::Set(d, darkest), high = hn::Set(d, brightest);
  for_row(
      rgb, plate, count,
      [&](std::size_t x, const Colors& p, const Colors& q) {
        hn::StoreU(length(p, q, low, high), d, out + x);
      },
      [&](std::size_t x, std::size_t left, const Colors& p, const Colors& q) {
        float all[16];
        hn::StoreU(length(p, q, low, high), d, all);
        for (std::size_t i = 0; i < left; ++i) out[x + i] = all[i];
      });
}

HWY_INLINE hn::Vec<Bytes> opacity(VF length, VF threshold) {
  const F d;
  const VF ramp = hn::Add(hn::Mul(hn::Sub(hn::Div(length, threshold), hn::Set(d, 0.5F)), hn::Set(d, 255.0F)),
                          hn::Set(d, 0.5F));
  const VF alpha = hn::Min(hn::Max(ramp, hn::Zero(d)), hn::Set(d, 255.0F));
  const VF known = hn::IfThenElse(hn::Eq(threshold, hn::Zero(d)), hn::Set(d, 255.0F), alpha);
  return hn::DemoteTo(Bytes(), hn::ConvertTo(I(), known));
}

void alphas(const std::uint8_t* rgb, const std::uint8_t* plate, const float* thresholds, std::size_t count,
            float darkest, float brightest, std::uint8_t* out) {
  const F d;
  const VF low = hn::Set(d, darkest), high = hn::Set(d, brightest);
  for_row(
      rgb, plate, count,
      [&](std::size_t x, const Colors& p, const Colors& q) {
        hn::StoreU(opacity(length(p, q, low, high), hn::LoadU(d, thresholds + x)), Bytes(), out + x);
      },
      [&](std::size_t x, std::size_t left, const Colors& p, const Colors& q) {
        float t[16] = {};
        std::uint8_t all[16];
        for (std::size_t i = 0; i < left; ++i) t[i] = thresholds[x + i];
        hn::StoreU(opacity(length(p, q, low, high), hn::LoadU(d, t)), Bytes(), all);
        for (std::size_t i = 0; i < left; ++i) out[x + i] = all[i];
      });
}

void table(PlateKernels* out) { *out = {hwy::TargetName(HWY_TARGET), lengths, alphas}; }

}  // namespace
}  // namespace floatstage::matting::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::matting {

HWY_EXPORT(table);

namespace {

void fill_table(PlateKernels* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

}  // namespace

const PlateKernels& plate_kernels() {
  static const PlateKernels best = native_kernels(fill_table);
  return best;
}

std::vector<PlateKernels> all_plate_kernels() { return kernels_of_all_sets(fill_table); }

}  // namespace floatstage::matting
#endif
