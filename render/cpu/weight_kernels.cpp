#include "render/cpu/weight_kernels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/instruction_sets.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/cpu/weight_kernels.cpp"
#include <hwy/foreach_target.h>
// clang-format off: foreach_target must come first
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace floatstage::render::cpu::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

constexpr float kBlind = 1e-6F, kReachesNot = 1e-3F;  // of `nearest`: one that does not see, nor has it
constexpr float kEnoughOfList = 0.01F;                // the same of who is listed
constexpr float kLeast = 1e-30F;

// Plain loops over bytes and shorts, which compilers turn into vectors.

// Eight counts at once, a bit each: columns of three are added to two bits, three columns to ones and twos.
void WithoutSpecks(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below, int width,
                   std::uint8_t* HWY_RESTRICT hidden) {
  const auto most = [](unsigned a, unsigned b, unsigned c) { return (a & b) | (c & (a | b)); };
  const auto at = [&](int x, unsigned& ones, unsigned& twos) {
    const unsigned a = above[x], b = here[x], c = below[x];
    ones = a ^ b ^ c;
    twos = most(a, b, c);
  };
  unsigned ones[3] = {0, 0, 0}, twos[3] = {0, 0, 0};  // of the columns left, here and right
  if (width > 0) at(0, ones[2], twos[2]);
  for (int x = 0; x < width; ++x) {
    for (int k = 0; k < 2; ++k) ones[k] = ones[k + 1], twos[k] = twos[k + 1];
    ones[2] = twos[2] = 0;
    if (x + 1 < width) at(x + 1, ones[2], twos[2]);
    const unsigned one = ones[0] ^ ones[1] ^ ones[2], two = most(ones[0], ones[1], ones[2]);
    const unsigned p = twos[0] ^ twos[1], q = twos[0] & twos[1], r = twos[2] ^ two, t = twos[2] & two;
    const unsigned three_twos = (q & (r | t)) | (t & p), two_twos = (p & r) | q | t;
    hidden[x] = static_cast<std::uint8_t>(here[x] & (three_twos | (two_twos & one)));
  }
}

bool RowDistances(const std::uint8_t* hidden, int width, int slot, int radius,
                  std::uint8_t* HWY_RESTRICT scratch, std::int16_t* HWY_RESTRICT squares) {
  std::uint8_t any = 0;
  for (int x = 0; x < width; ++x) any |= hidden[x];
  if ((any >> slot & 1) == 0) return false;
  std::uint8_t* at = scratch + radius;  // 0 where hidden, else 255, also beyond the row's ends
  std::uint8_t* HWY_RESTRICT nearest = scratch + width + 2 * radius;
  std::memset(scratch, 255, static_cast<std::size_t>(width + 2 * radius));
  for (int x = 0; x < width; ++x) at[x] = static_cast<std::uint8_t>(((hidden[x] >> slot) & 1) - 1);
  std::memcpy(nearest, at, static_cast<std::size_t>(width));
  for (int d = 1; d <= radius; ++d) {
    const std::uint8_t *left = at - d, *right = at + d;
    const auto distance = static_cast<std::uint8_t>(d);
    for (int x = 0; x < width; ++x) {
      const std::uint8_t found = std::min(left[x], right[x]) | distance;
      nearest[x] = std::min(nearest[x], found);
    }
  }
  for (int x = 0; x < width; ++x) {
    const auto d = static_cast<std::int16_t>(nearest[x]);
    squares[x] = d == 255 ? kNoneNear : static_cast<std::int16_t>(d * d);
  }
  return true;
}

void SoftShares(const std::int16_t* const* rows, const std::int16_t* offsets, int row_count, float radius,
                int count, float* HWY_RESTRICT shares) {
  constexpr int kBlock = 64;
  const float scale = 1 / radius;
  for (int begin = 0; begin < count; begin += kBlock) {
    const int n = std::min(kBlock, count - begin);
    std::int16_t nearest[kBlock];
    std::fill_n(nearest, kBlock, kNoneNear);
    for (int r = 0; r < row_count; ++r) {
      const std::int16_t* row = rows[r] + begin;
      const std::int16_t offset = offsets[r];
      if (n == kBlock)
        for (int x = 0; x < kBlock; ++x)
          nearest[x] = std::min(nearest[x], static_cast<std::int16_t>(row[x] + offset));
      else
        for (int x = 0; x < n; ++x)
          nearest[x] = std::min(nearest[x], static_cast<std::int16_t>(row[x] + offset));
    }
    for (int x = 0; x < n; ++x)
      shares[begin + x] = std::min(std::sqrt(static_cast<float>(nearest[x])) * scale, 1.F);
  }
}

// The strongest camera that sees the pixel has it all; where none does, the strongest.
void OneCamera(const WeightRow& row) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  const auto listed = static_cast<std::size_t>(row.listed);
  const auto zero = hn::Zero(d), one = hn::Set(d, 1), blind = hn::Set(d, kBlind),
             unreached = hn::Set(d, kBlind * kReachesNot);
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.count); i += hn::Lanes(d)) {
    const auto bits = hn::PromoteTo(di, hn::LoadU(d8, row.visible + i));
    auto best = hn::Set(d, -1);
    auto best_slot = hn::Zero(di);
    for (std::size_t s = 0; s < listed; ++s) {
      const auto angular = hn::LoadU(d, row.angular[s] + i);
      const auto visible = hn::RebindMask(d, hn::Ne(hn::And(bits, hn::Set(di, 1 << s)), hn::Zero(di)));
      const auto least = hn::IfThenElse(hn::Gt(angular, zero), blind, unreached);
      const auto score = hn::Mul(hn::Abs(angular), hn::IfThenElse(visible, one, least));
      const auto better = hn::Gt(score, best);
      best = hn::IfThenElse(better, score, best);
      best_slot =
          hn::IfThenElse(hn::RebindMask(di, better), hn::Set(di, static_cast<std::int32_t>(s)), best_slot);
      hn::StoreU(hn::IfThenElseZero(visible, hn::LoadU(d, row.soft[s] + i)), d, row.soft[s] + i);
    }
    for (std::size_t s = 0; s < listed; ++s) {
      const auto chosen = hn::RebindMask(d, hn::Eq(best_slot, hn::Set(di, static_cast<std::int32_t>(s))));
      hn::StoreU(hn::IfThenElseZero(chosen, one), d, row.weight[s] + i);
    }
  }
}

// weights.comp says what the four kinds of cameras are and why each lets the next one in by degrees.
void BlendingWeights(const WeightRow& row) {
  if (row.one_camera) return OneCamera(row);
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  const auto listed = static_cast<std::size_t>(row.listed);
  const auto zero = hn::Zero(d), one = hn::Set(d, 1), enough = hn::Set(d, kEnough),
             least = hn::Set(d, kLeast), enough_of_list = hn::Set(d, kEnoughOfList);
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.count); i += hn::Lanes(d)) {
    const auto bits = hn::PromoteTo(di, hn::LoadU(d8, row.visible + i));
    auto all = least, chosen = zero, listed_all = least, in_list = zero, in_picture = zero;
    auto strongest = zero, second = zero, beside = zero;  // of the list; of those that do not have it
    for (std::size_t s = 0; s < listed; ++s) {
      const auto angular = hn::LoadU(d, row.angular[s] + i), size = hn::Abs(angular);
      const auto visible = hn::RebindMask(d, hn::Ne(hn::And(bits, hn::Set(di, 1 << s)), hn::Zero(di)));
      const auto soft = hn::IfThenElseZero(visible, hn::LoadU(d, row.soft[s] + i));
      const auto as_chosen = hn::Mul(size, hn::Set(d, row.fade[s])),
                 as_listed = hn::Mul(size, hn::Set(d, row.stand_in_fade[s]));
      all = hn::Add(all, as_chosen);
      chosen = hn::MulAdd(as_chosen, soft, chosen);
      listed_all = hn::Add(listed_all, as_listed);
      second = hn::Max(second, hn::Min(strongest, as_listed));
      strongest = hn::Max(strongest, as_listed);
      in_list = hn::MulAdd(as_listed, soft, in_list);
      const auto reaches = hn::Gt(angular, zero);
      in_picture = hn::Add(in_picture, hn::IfThenElseZero(reaches, as_listed));
      beside = hn::Max(beside, hn::IfThenZeroElse(reaches, as_listed));
      hn::StoreU(soft, d, row.soft[s] + i);
    }
    const auto of_chosen = hn::Div(one, hn::Max(chosen, hn::Mul(enough, all)));
    auto rest = hn::NegMulAdd(chosen, of_chosen, one);
    const auto enough_listed =
        hn::Mul(enough_of_list, hn::Sub(listed_all, hn::Max(zero, hn::Sub(beside, second))));
    const auto of_list = hn::Div(rest, hn::Max(in_list, enough_listed));
    rest = hn::NegMulAdd(in_list, of_list, rest);
    const auto of_picture = hn::Div(rest, hn::Max(in_picture, enough_listed));
    const auto of_any = hn::Div(hn::NegMulAdd(in_picture, of_picture, rest), listed_all);
    for (std::size_t s = 0; s < listed; ++s) {
      const auto angular = hn::LoadU(d, row.angular[s] + i), soft = hn::LoadU(d, row.soft[s] + i);
      const auto fade = hn::Set(d, row.fade[s]), stand_in = hn::Set(d, row.stand_in_fade[s]);
      const auto seen = hn::Mul(soft, hn::MulAdd(fade, of_chosen, hn::Mul(stand_in, of_list)));
      const auto unseen = hn::Add(of_any, hn::IfThenElseZero(hn::Gt(angular, zero), of_picture));
      hn::StoreU(hn::Mul(hn::Abs(angular), hn::MulAdd(stand_in, unseen, seen)), d, row.weight[s] + i);
    }
  }
}

}  // namespace floatstage::render::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render::cpu {

HWY_EXPORT(WithoutSpecks);
HWY_EXPORT(RowDistances);
HWY_EXPORT(SoftShares);
HWY_EXPORT(BlendingWeights);

void without_specks(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below, int width,
                    std::uint8_t* hidden) {
  HWY_DYNAMIC_DISPATCH(WithoutSpecks)(above, here, below, width, hidden);
}

bool row_distances(const std::uint8_t* hidden, int width, int slot, int radius, std::uint8_t* scratch,
                   std::int16_t* squares) {
  return HWY_DYNAMIC_DISPATCH(RowDistances)(hidden, width, slot, radius, scratch, squares);
}

void soft_shares(const std::int16_t* const* rows, const std::int16_t* offsets, int row_count, float radius,
                 int count, float* shares) {
  HWY_DYNAMIC_DISPATCH(SoftShares)(rows, offsets, row_count, radius, count, shares);
}

void blending_weights(const WeightRow& row) { HWY_DYNAMIC_DISPATCH(BlendingWeights)(row); }

}  // namespace floatstage::render::cpu
#endif
