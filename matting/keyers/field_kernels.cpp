// The kernels in vectors, compiled once for every instruction set that Highway knows here: the arithmetic of
// BackingField::distances(), in its order and without contraction, so that all give the same bits.

#include "matting/keyers/field_kernels.h"

#include <limits>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "matting/keyers/field_kernels.cpp"
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

// Values of the cells left and right of the pixels from x on.
struct Sides {
  VF left, right;
};

// Wide pictures: the cells of a vector of pixels lie within a vector. Narrow ones: they lie anywhere.
template <bool narrow>
class Cells {
 public:
  HWY_INLINE Cells(const std::int32_t* cells, std::size_t x)
      : first_(narrow ? 0 : cells[x]),
        at_(hn::Sub(hn::LoadU(I(), cells + x), hn::Set(I(), static_cast<std::int32_t>(first_)))) {}

  HWY_INLINE Sides of(const float* plane) const {
    const F d;
    const float* from = plane + first_;
    if constexpr (narrow) return {hn::GatherIndex(d, from, at_), hn::GatherIndex(d, from + 1, at_)};
    const auto lanes = hn::IndicesFromVec(d, at_);
    return {hn::TableLookupLanes(hn::LoadU(d, from), lanes),
            hn::TableLookupLanes(hn::LoadU(d, from + 1), lanes)};
  }

 private:
  std::ptrdiff_t first_;
  hn::Vec<I> at_;
};

struct Colors {
  VF r, g, b;
};

template <bool narrow>
HWY_INLINE VF distance(const FieldRow& row, std::size_t x, const Colors& colors) {
  const F d;
  const Cells<narrow> cells(row.cells, x);
  const VF share = hn::LoadU(d, row.shares + x);
  const auto term = [&](std::size_t k) {
    const Sides s = cells.of(row.terms + k * row.stride);
    return hn::Add(s.left, hn::Mul(share, hn::Sub(s.right, s.left)));
  };
  const VF r = hn::Sub(colors.r, term(0)), g = hn::Sub(colors.g, term(1)), b = hn::Sub(colors.b, term(2));
  const VF u = hn::Mul(term(3), r);
  const VF v = hn::Add(hn::Mul(term(4), r), hn::Mul(term(5), g));
  const VF w = hn::Add(hn::Add(hn::Mul(term(6), r), hn::Mul(term(7), g)), hn::Mul(term(8), b));
  VF off = hn::Sqrt(hn::Add(hn::Add(hn::Mul(u, u), hn::Mul(v, v)), hn::Mul(w, w)));
  if (row.darker_too) {
    const VF luma = hn::Add(hn::Add(hn::Mul(hn::Set(d, 0.299F), r), hn::Mul(hn::Set(d, 0.587F), g)),
                            hn::Mul(hn::Set(d, 0.114F), b));
    off = hn::IfThenZeroElse(hn::Lt(luma, hn::Zero(d)), off);
  }
  if (row.known != nullptr) {
    const Sides known = cells.of(row.known);
    const VF nearest = hn::IfThenElse(hn::Lt(share, hn::Set(d, 0.5F)), known.left, known.right);
    off =
        hn::IfThenElse(hn::Eq(nearest, hn::Zero(d)), hn::Set(d, std::numeric_limits<float>::infinity()), off);
  }
  return off;
}

template <class Load, class Store>
HWY_INLINE void for_row(const FieldRow& row, std::size_t count, const Load& load, const Store& store) {
  const std::size_t lanes = hn::Lanes(F());
  if (row.narrow)
    for (std::size_t x = 0; x < count; x += lanes) store(x, distance<true>(row, x, load(x)));
  else
    for (std::size_t x = 0; x < count; x += lanes) store(x, distance<false>(row, x, load(x)));
}

HWY_INLINE VF sum_of(const std::uint32_t* columns, int size) {
  const I d;
  const auto* from = reinterpret_cast<const std::int32_t*>(columns);
  auto sum = hn::LoadU(d, from);
  for (int k = 1; k < size; ++k) sum = hn::Add(sum, hn::LoadU(d, from + k));
  return hn::ConvertTo(F(), sum);
}

HWY_INLINE Colors mean_at(const FieldMeans& means, VF count, std::size_t x) {
  return {hn::Div(sum_of(means.columns[0] + x, means.size), count),
          hn::Div(sum_of(means.columns[1] + x, means.size), count),
          hn::Div(sum_of(means.columns[2] + x, means.size), count)};
}

HWY_INLINE VF value_of(const std::uint8_t* bytes) {
  return hn::ConvertTo(F(), hn::PromoteTo(I(), hn::LoadU(Bytes(), bytes)));
}

HWY_INLINE void store_alpha(VF distance, VF sigmas, std::uint8_t* out) {
  const F d;
  const VF ramp = hn::Add(hn::Mul(hn::Sub(hn::Div(distance, sigmas), hn::Set(d, 0.5F)), hn::Set(d, 255.0F)),
                          hn::Set(d, 0.5F));
  const VF alpha = hn::Min(hn::Max(ramp, hn::Zero(d)), hn::Set(d, 255.0F));
  hn::StoreU(hn::DemoteTo(Bytes(), hn::ConvertTo(I(), alpha)), Bytes(), out);
}

void between(const float* a, const float* b, float share, std::size_t count, float* out) {
  const F d;
  const VF s = hn::Set(d, share);
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    const VF from = hn::LoadU(d, a + i);
    hn::StoreU(hn::Add(from, hn::Mul(s, hn::Sub(hn::LoadU(d, b + i), from))), d, out + i);
  }
}

void slide(const std::uint8_t* more, const std::uint8_t* less, std::size_t count, std::uint32_t* columns) {
  const I d;
  for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
    auto* at = reinterpret_cast<std::int32_t*>(columns + i);
    const auto in = hn::PromoteTo(d, hn::LoadU(Bytes(), more + i)),
               out = hn::PromoteTo(d, hn::LoadU(Bytes(), less + i));
    hn::StoreU(hn::Add(hn::LoadU(d, at), hn::Sub(in, out)), d, at);
  }
}

void distances(const FieldRow& row, const FieldMeans& means, std::size_t count, float* out) {
  const VF n = hn::Set(F(), static_cast<float>(means.size * means.size));
  for_row(
      row, count, [&](std::size_t x) { return mean_at(means, n, x); },
      [&](std::size_t x, VF off) { hn::StoreU(off, F(), out + x); });
}

void mean_alphas(const FieldRow& row, const FieldMeans& means, float sigmas, std::size_t count,
                 std::uint8_t* out) {
  const VF n = hn::Set(F(), static_cast<float>(means.size * means.size)), all = hn::Set(F(), sigmas);
  for_row(
      row, count, [&](std::size_t x) { return mean_at(means, n, x); },
      [&](std::size_t x, VF off) { store_alpha(off, all, out + x); });
}

void alphas(const FieldRow& row, const std::uint8_t* const* rgb, float sigmas, std::size_t count,
            std::uint8_t* out) {
  const VF all = hn::Set(F(), sigmas);
  for_row(
      row, count,
      [&](std::size_t x) {
        return Colors{value_of(rgb[0] + x), value_of(rgb[1] + x), value_of(rgb[2] + x)};
      },
      [&](std::size_t x, VF off) { store_alpha(off, all, out + x); });
}

void table(FieldKernels* out) {
  *out = {hwy::TargetName(HWY_TARGET), between, slide, distances, mean_alphas, alphas};
}

}  // namespace
}  // namespace floatstage::matting::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::matting {

HWY_EXPORT(table);

namespace {

void fill_table(FieldKernels* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

}  // namespace

const FieldKernels& field_kernels() {
  static const FieldKernels best = native_kernels(fill_table);
  return best;
}

std::vector<FieldKernels> all_field_kernels() { return kernels_of_all_sets(fill_table); }

}  // namespace floatstage::matting
#endif
