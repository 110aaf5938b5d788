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

constexpr float kBlind = 1e-6F;  // a camera that does not see the pixel counts where none does

// Plain loops over bytes and shorts, which compilers turn into vectors.

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

void BlendingWeights(const WeightRow& row) {
  const hn::CappedTag<float, 16> d;
  const hn::RebindToSigned<decltype(d)> di;
  const hn::Rebind<std::uint8_t, decltype(d)> d8;
  const auto listed = static_cast<std::size_t>(row.listed);
  const auto zero = hn::Zero(d), one = hn::Set(d, 1), blind = hn::Set(d, kBlind),
             unreached = hn::Set(d, kBlind * 1e-3F);
  for (std::size_t i = 0; i < static_cast<std::size_t>(row.count); i += hn::Lanes(d)) {
    const auto bits = hn::PromoteTo(di, hn::LoadU(d8, row.visible + i));
    auto sum = zero, best = hn::Set(d, -1);
    auto best_slot = hn::Zero(di);
    for (std::size_t s = 0; s < listed; ++s) {
      const auto angular = hn::LoadU(d, row.angular[s] + i), size = hn::Abs(angular);
      const auto visible = hn::RebindMask(d, hn::Ne(hn::And(bits, hn::Set(di, 1 << s)), hn::Zero(di)));
      const auto soft = hn::IfThenElseZero(visible, hn::LoadU(d, row.soft[s] + i));
      const auto least = hn::IfThenElse(hn::Gt(angular, zero), blind, unreached);
      const auto reach = hn::Set(d, row.fade[s] + kStandIn * row.stand_in_fade[s]);
      const auto weight = hn::Mul(size, hn::MulAdd(soft, reach, least));
      sum = hn::Add(sum, weight);
      const auto score = row.one_camera ? hn::Mul(size, hn::IfThenElse(visible, one, least)) : weight;
      const auto better = hn::Gt(score, best);
      best = hn::IfThenElse(better, score, best);
      best_slot =
          hn::IfThenElse(hn::RebindMask(di, better), hn::Set(di, static_cast<std::int32_t>(s)), best_slot);
      hn::StoreU(soft, d, row.soft[s] + i);
      hn::StoreU(weight, d, row.weight[s] + i);
    }
    const auto share = hn::Div(one, sum);
    for (std::size_t s = 0; s < listed; ++s) {
      const auto chosen = hn::RebindMask(d, hn::Eq(best_slot, hn::Set(di, static_cast<std::int32_t>(s))));
      const auto weight =
          row.one_camera ? hn::IfThenElseZero(chosen, one) : hn::Mul(hn::LoadU(d, row.weight[s] + i), share);
      hn::StoreU(weight, d, row.weight[s] + i);
    }
  }
}

}  // namespace floatstage::render::cpu::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace floatstage::render::cpu {

HWY_EXPORT(RowDistances);
HWY_EXPORT(SoftShares);
HWY_EXPORT(BlendingWeights);

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
