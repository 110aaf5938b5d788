#include "render/flow/field_solver.h"

#include <algorithm>

namespace floatstage::render {
namespace {

// An initial field is right to about a pixel at this level (four pixels at full size): what coarser levels
// are for is done.
constexpr int kWarmLevel = 2;

constexpr int kMostDoublings = 2;  // of the sweeps, from level to coarser level

/// The mean of a field over the pixels that one pixel of `level` covers, in pixels of that level.
void shrink_field(const FlowField& field, int level, SplitPlane& u, SplitPlane& v) {
  const int size = 1 << level;
  for (int y = 0; y < u.height(); ++y) {
    for (int x = 0; x < u.width(); ++x) {
      float sum_u = 0, sum_v = 0, count = 0;
      for (int b = y * size; b < std::min((y + 1) * size, field.height); ++b)
        for (int a = x * size; a < std::min((x + 1) * size, field.width); ++a) {
          const std::size_t i = 2 * (static_cast<std::size_t>(b) * static_cast<std::size_t>(field.width) +
                                     static_cast<std::size_t>(a));
          sum_u += field.uv[i];
          sum_v += field.uv[i + 1];
          count += 1;
        }
      const float scale = 1.F / (std::max(count, 1.F) * static_cast<float>(size));
      u.at(x, y) = sum_u * scale;
      v.at(x, y) = sum_v * scale;
    }
  }
}

/// The field as rows of u, v; 0 outside the domain.
void hand_out(const PictureLevel& level, const SplitPlane& u, const SplitPlane& v, FlowField& out) {
  out.width = level.width;
  out.height = level.height;
  const auto width = static_cast<std::size_t>(level.width);
  out.uv.resize(2 * width * static_cast<std::size_t>(level.height));
  for (int y = 0; y < level.height; ++y) {
    const std::uint8_t* zone = level.zone.data() + static_cast<std::size_t>(y) * width;
    float* to = out.uv.data() + 2 * static_cast<std::size_t>(y) * width;
    const ConstSplitRow a = u.row(y), b = v.row(y);
    for (int x = 0; x < level.width; ++x) {
      const float inside = zone[x] == PictureLevel::kDomain ? 1.F : 0.F;
      to[2 * x] = inside * (x % 2 == 0 ? a.even : a.odd)[x / 2];
      to[2 * x + 1] = inside * (x % 2 == 0 ? b.even : b.odd)[x / 2];
    }
  }
}

}  // namespace

int SolverOptions::warps_at(int level) const { return std::min(finest_warps + level - finest, most_warps); }

int SolverOptions::sweeps_at(int level) const { return sweeps << std::min(level - finest, kMostDoublings); }

void FieldSolver::begin(const PictureLevel& level, const FlowField* initial, int l) {
  Field& field = fields_[static_cast<std::size_t>(l)];
  field.u.reset(level.width, level.height);
  field.v.reset(level.width, level.height);
  if (initial != nullptr) shrink_field(*initial, l, field.u, field.v);
}

void FieldSolver::solve(const FlowKernels& kernels, const SolverOptions& options, const PicturePyramid& first,
                        const PicturePyramid& second, int levels, const FlowField* initial,
                        FlowField& result) {
  const int finest = std::min(options.finest, levels - 1);
  const int start = initial == nullptr ? levels - 1 : std::clamp(kWarmLevel, finest, levels - 1);
  fields_.resize(std::max(fields_.size(), static_cast<std::size_t>(levels)));
  begin(first.level(start), initial, start);
  for (int l = start; l >= 0; --l) {
    const PictureLevel &from = first.level(l), &into = second.level(l);
    Field& field = fields_[static_cast<std::size_t>(l)];
    if (l < start) {
      const Field& coarse = fields_[static_cast<std::size_t>(l) + 1];
      if (l >= finest) {
        enlargement_.bilinear(from, coarse.u, field.u);
        enlargement_.bilinear(from, coarse.v, field.v);
      } else {
        enlargement_.guided(first.level(l + 1), from, options.guide_edge, coarse.u, coarse.v, field.u,
                            field.v);
      }
    }
    if (l < finest) continue;
    sweep_.reset(from.width, from.height, options.sweeps_at(l));
    for (int k = 0; k < options.warps_at(l); ++k)
      sweep_.run(kernels, options.energy, options.cubic, from, into, field.u, field.v);
  }
  hand_out(first.level(0), fields_[0].u, fields_[0].v, result);
}

}  // namespace floatstage::render
