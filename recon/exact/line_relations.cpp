// Eight lines at a time against one, compiled once for every instruction set that Highway knows here: the
// comparisons of FaceSweep::meet(), in its order and without contraction, so that all give the same bits.

#include "recon/exact/line_relations.h"

#include <bit>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "recon/exact/line_relations.cpp"
#include <hwy/foreach_target.h>  // NOLINT: includes this file again
#include <hwy/highway.h>

#include "core/kernel_tables.h"

HWY_BEFORE_NAMESPACE();
namespace floatstage::recon::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

using D = HWY_CAPPED(double, LineBlock::kLines);
using V = hn::Vec<D>;
using M = hn::Mask<D>;

HWY_INLINE unsigned bits_of(M mask) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(D(), mask, bits);
  return bits[0];
}

// As std::max and std::min, also of what is not a number.
HWY_INLINE V larger(V a, V b) { return hn::IfThenElse(hn::Lt(a, b), b, a); }
HWY_INLINE V smaller(V a, V b) { return hn::IfThenElse(hn::Lt(b, a), b, a); }

int change_of(const LineBlock& block, unsigned below, unsigned starts_later, unsigned spans) {
  const unsigned upper = block.upper;
  int change = 2 * std::popcount(below & upper) - std::popcount(below);
  if ((block.left_above | block.right_above) == 0) return change;
  const unsigned right = block.right_above & ~starts_later & ~spans, left = block.left_above & ~starts_later;
  change += 2 * std::popcount(right & upper) - std::popcount(right);
  return change - (2 * std::popcount(left & upper) - std::popcount(left));
}

BlockRelation relate(const LineBlock& block, const CutLine& line) {
  const D d;
  const V wa = hn::Set(d, line.wa), wb = hn::Set(d, line.wb), entry = hn::Set(d, line.entry);
  const V end = hn::Set(d, line.right), low = hn::Set(d, line.low), high = hn::Set(d, line.high);
  const V zero = hn::Zero(d);
  unsigned below = 0, crosses = 0, falls = 0, later = 0, spans = 0;
  for (std::size_t k = 0; k < LineBlock::kLines; k += hn::Lanes(d)) {
    const V left = hn::Load(d, block.left + k), right = hn::Load(d, block.right + k);
    const V at_a = hn::Sub(wa, hn::Load(d, block.wa + k));
    const V change = hn::Sub(hn::Sub(wb, hn::Load(d, block.wb + k)), at_a);
    const V from = larger(entry, left), to = smaller(end, right);
    const M below_first = hn::Lt(hn::Add(at_a, hn::Mul(change, from)), zero);
    const M below_last = hn::Lt(hn::Add(at_a, hn::Mul(change, to)), zero);
    const M over_it = hn::And(hn::Le(left, entry), hn::Lt(entry, right));
    const M under = hn::Gt(hn::Load(d, block.low + k), high), over = hn::Lt(hn::Load(d, block.high + k), low);
    const M mixed = hn::AndNot(hn::Or(under, over), hn::Lt(from, to));
    below |= bits_of(hn::And(over_it, hn::Or(under, hn::And(mixed, below_first)))) << k;
    crosses |= bits_of(hn::And(mixed, hn::Xor(below_first, below_last))) << k;
    falls |= bits_of(below_last) << k;
    later |= bits_of(hn::Lt(entry, left)) << k;
    spans |= bits_of(hn::Lt(entry, right)) << k;
  }
  return {change_of(block, below & block.used, later, spans & ~later),
          static_cast<std::uint8_t>(crosses & block.used), static_cast<std::uint8_t>(falls)};
}

void table(RelateKernel* out) { *out = {hwy::TargetName(HWY_TARGET), relate}; }

}  // namespace
}  // namespace floatstage::recon::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::recon {

HWY_EXPORT(table);

namespace {

void fill_table(RelateKernel* out) { HWY_DYNAMIC_DISPATCH(table)(out); }

}  // namespace

const RelateKernel& relate_kernel() {
  static const RelateKernel best = native_kernels(fill_table);
  return best;
}

std::vector<RelateKernel> all_relate_kernels() { return kernels_of_all_sets(fill_table); }

}  // namespace floatstage::recon
#endif
