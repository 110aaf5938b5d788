#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "render/cpu/projection.h"

namespace floatstage::render::cpu {

/// Weights below it are not blended: less than half an 8-bit step even against the strongest contrast.
constexpr float kFaint = 1e-4F;

/// A photograph's share in a row: for each covered pixel a weight and a colour (four floats).
struct RowShare {
  const float* weight = nullptr;
  const float* color = nullptr;
};

/// Marks the pixels that weigh `faint` or more with 1, the others with 0; whether there are any.
bool mark_weighty(const float* weight, float faint, std::size_t count, std::int32_t* marks);

/// The weighted mean (Eq. 9.1) of a row's colours while photographs are added one by one. Weights below
/// `faint` are left out, with their colours, which may then be anything.
class RowMean {
 public:
  RowMean(std::size_t count, float faint, RowMemory& memory);
  void add(const RowShare& share);
  /// The mean, four floats a pixel, black where nothing was added; or, where `ghosts` is wanted, how far what
  /// was added lies from it, weighted, as heat (0…255). `shares`: all that were added; an empty one was not.
  const float* finish(bool ghosts, std::span<const RowShare> shares);

 private:
  void show_ghosts(std::span<const RowShare> shares);
  std::size_t count_;
  float faint_;
  float *sum_, *total_;
};

}  // namespace floatstage::render::cpu
