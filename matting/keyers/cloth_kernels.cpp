// The kernels in vectors, compiled once for every instruction set that Highway knows here: the arithmetic of
// cloth_measure.h, in its order and without contraction, so that all give the same bits.

#include "matting/keyers/cloth_kernels.h"

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matting/keyers/cloth_kernels.cpp"
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
using MF = hn::Mask<F>;

void split(const std::uint8_t* rgb, std::size_t count, std::uint8_t* r, std::uint8_t* g, std::uint8_t* b) {
  const HWY_CAPPED(std::uint8_t, 64) d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t x = 0;
  for (; x + lanes <= count; x += lanes) {
    hn::Vec<decltype(d)> red, green, blue;
    hn::LoadInterleaved3(d, rgb + 3 * x, red, green, blue);
    hn::StoreU(red, d, r + x);
    hn::StoreU(green, d, g + x);
    hn::StoreU(blue, d, b + x);
  }
  for (; x < count; ++x) {
    r[x] = rgb[3 * x];
    g[x] = rgb[3 * x + 1];
    b[x] = rgb[3 * x + 2];
  }
}

HWY_INLINE VF load(const std::uint8_t* at) {
  return hn::ConvertTo(F(), hn::PromoteTo(I(), hn::LoadU(Bytes(), at)));
}

HWY_INLINE VF of(const ColorForm& form, VF r, VF g, VF b) {
  const F d;
  return hn::Add(hn::Add(hn::Mul(hn::Set(d, form.r), r), hn::Mul(hn::Set(d, form.g), g)),
                 hn::Mul(hn::Set(d, form.b), b));
}

HWY_INLINE VF value_of(const ClothMeasure& m, VF r, VF g, VF b) {
  const F d;
  const VF cloth = hn::Sub(of(m.along, r, g, b),
                           hn::Mul(hn::Set(d, ClothMeasure::kAngleSlope), hn::Abs(of(m.across, r, g, b))));
  const VF luma = hn::Add(of(kLuma, r, g, b), hn::Set(d, ClothMeasure::kDarkFloor));
  return hn::Sub(hn::Set(d, m.top), hn::Div(hn::Mul(hn::Set(d, m.scale), cloth), luma));
}

// Bits of the vectors that begin at pixel x: of one of eight lanes or more, or of as many shorter ones as
// eight take.
HWY_INLINE void store_bits(MF mask, std::size_t x, std::uint64_t* out) {
  const F d;
  auto* bytes = reinterpret_cast<std::uint8_t*>(out) + x / 8;
  if (hn::Lanes(d) >= 8) {
    hn::StoreMaskBits(d, mask, bytes);
    return;
  }
  std::uint8_t bits[8];
  hn::StoreMaskBits(d, mask, bits);
  *bytes = static_cast<std::uint8_t>((x % 8 == 0 ? 0 : *bytes) | bits[0] << (x % 8));
}

void classify(const ClothMeasure& measure, const std::uint8_t* r, const std::uint8_t* g,
              const std::uint8_t* b, std::size_t padded, std::uint64_t* subject, std::uint64_t* faint,
              std::uint64_t* doubt) {
  const F d;
  const VF opaque = hn::Set(d, 128.0F), some = hn::Set(d, 24.0F), none = hn::Set(d, measure.doubtful);
  for (std::size_t x = 0; x < padded; x += hn::Lanes(d)) {
    const VF value = value_of(measure, load(r + x), load(g + x), load(b + x));
    store_bits(hn::Ge(value, opaque), x, subject);
    store_bits(hn::Ge(value, some), x, faint);
    store_bits(hn::Gt(value, none), x, doubt);
  }
}

void alphas(const ClothMeasure& measure, const std::uint8_t* r, const std::uint8_t* g, const std::uint8_t* b,
            std::size_t padded, std::uint8_t* alpha, std::uint8_t* doubt) {
  const F d;
  const VF opaque = hn::Set(d, 255.0F), none = hn::Set(d, measure.doubtful);
  const auto store = [](VF value, std::uint8_t* out) {
    hn::StoreU(hn::DemoteTo(Bytes(), hn::ConvertTo(I(), value)), Bytes(), out);
  };
  for (std::size_t x = 0; x < padded; x += hn::Lanes(d)) {
    const VF value = value_of(measure, load(r + x), load(g + x), load(b + x));
    store(hn::Min(hn::Max(value, hn::Zero(d)), opaque), alpha + x);
    store(hn::IfThenElseZero(hn::Gt(value, none), opaque), doubt + x);
  }
}

void quantize(const ColorForm& form, const std::uint8_t* r, const std::uint8_t* g, const std::uint8_t* b,
              std::size_t padded, std::int32_t* out) {
  const F d;
  for (std::size_t x = 0; x < padded; x += hn::Lanes(d))
    hn::StoreU(hn::NearestInt(hn::Mul(of(form, load(r + x), load(g + x), load(b + x)),
                                      hn::Set(d, RowMeasure::kQuantum))),
               I(), out + x);
}

void table(ClothKernels* out) { *out = {hwy::TargetName(HWY_TARGET), split, classify, alphas, quantize}; }

}  // namespace
}  // namespace floatstage::matting::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::matting {

HWY_EXPORT(table);

namespace {

void fill_table(ClothKernels* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

}  // namespace

const ClothKernels& cloth_kernels() {
  static const ClothKernels best = native_kernels(fill_table);
  return best;
}

std::vector<ClothKernels> all_cloth_kernels() { return kernels_of_all_sets(fill_table); }

}  // namespace floatstage::matting
#endif
