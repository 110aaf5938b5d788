#include "render/flow/enlargement.h"

#include <algorithm>

namespace floatstage::render {
namespace {

constexpr float kNear = 0.75F, kFar = 0.25F;  // of the coarse pixel a fine one lies in, and of its neighbour
constexpr float kLeastWeight = 1e-6F;         // where nothing around is known

/// Row `y` of a split plane in column order, from out[1] on; the ends are repeated.
void merge(const SplitPlane& plane, int y, float scale, std::vector<float>& out) {
  const ConstSplitRow row = plane.row(y);
  const int half = plane.whole_row().end, width = plane.width();
  out.assign(static_cast<std::size_t>(2 * half + 2 * kSplitBlock), 0.F);
  float* to = out.data() + 1;
  for (int i = 0; i < (width + 1) / 2; ++i) {
    to[2 * i] = scale * row.even[i];
    to[2 * i + 1] = scale * row.odd[i];
  }
  to[-1] = to[0];
  to[width] = to[width - 1];
}

/// The coarse rows that a fine row lies between.
struct Between {
  int near, far;
};
Between between(int y, int coarse_height) {
  const int near = y / 2, far = y % 2 == 0 ? near - 1 : near + 1;
  return {near, std::clamp(far, 0, coarse_height - 1)};
}

void blend_half(SplitSpan span, int to_far, const float* near, const float* far, float* out) {
  for (int i = span.begin; i < span.end; ++i)
    out[i] = kNear * (kNear * near[i] + kFar * far[i]) +
             kFar * (kNear * near[i + to_far] + kFar * far[i + to_far]);
}

struct Guides {
  const float *near_u, *near_v, *near_value, *near_known;
  const float *far_u, *far_v, *far_value, *far_known;
};

void guided_half(SplitSpan span, int to_far, float per_edge2, const Guides& g, const float* here, float* u,
                 float* v) {
  auto weight = [&](float share, float known, float value, float own) {
    const float difference = value - own;
    return share * known / (1.F + difference * difference * per_edge2);
  };
  for (int i = span.begin; i < span.end; ++i) {
    const int j = i + to_far;
    const float a = weight(kNear * kNear, g.near_known[i], g.near_value[i], here[i]);
    const float b = weight(kNear * kFar, g.near_known[j], g.near_value[j], here[i]);
    const float c = weight(kFar * kNear, g.far_known[i], g.far_value[i], here[i]);
    const float d = weight(kFar * kFar, g.far_known[j], g.far_value[j], here[i]);
    const float share = 1.F / (((a + b) + (c + d)) + kLeastWeight);
    u[i] = ((a * g.near_u[i] + b * g.near_u[j]) + (c * g.far_u[i] + d * g.far_u[j])) * share;
    v[i] = ((a * g.near_v[i] + b * g.near_v[j]) + (c * g.far_v[i] + d * g.far_v[j])) * share;
  }
}

void guide_row(const PictureLevel& level, int y, std::vector<float>& value, std::vector<float>& known) {
  const auto width = static_cast<std::size_t>(level.width), at = static_cast<std::size_t>(y) * width;
  const std::size_t size = width + 1 + 3 * static_cast<std::size_t>(kSplitBlock);
  value.assign(size, 0.F);
  known.assign(size, 0.F);
  for (std::size_t x = 0; x < width; ++x) {
    value[x + 1] = level.value[at + x];
    known[x + 1] = level.zone[at + x] == PictureLevel::kDomain ? 1.F : 0.F;
  }
}

}  // namespace

void Enlargement::bilinear(const PictureLevel& fine, const SplitPlane& from, SplitPlane& to) {
  to.resize(fine.width, fine.height);
  for (int y = 0; y < fine.height; ++y) {
    const SplitSpan span = fine.spans[static_cast<std::size_t>(y)];
    to.clear_outside(span, y);
    if (span.empty()) continue;
    const Between rows = between(y, from.height());
    merge(from, rows.near, 2, near_.u);
    merge(from, rows.far, 2, far_.u);
    const SplitRow out = to.row(y);
    blend_half(span, -1, near_.u.data() + 1, far_.u.data() + 1, out.even);
    blend_half(span, 1, near_.u.data() + 1, far_.u.data() + 1, out.odd);
  }
}

void Enlargement::guided(const PictureLevel& coarse, const PictureLevel& fine, float edge,
                         const SplitPlane& u, const SplitPlane& v, SplitPlane& fine_u, SplitPlane& fine_v) {
  fine_u.resize(fine.width, fine.height);
  fine_v.resize(fine.width, fine.height);
  const float per_edge2 = 1.F / (edge * edge);
  for (int y = 0; y < fine.height; ++y) {
    const SplitSpan span = fine.spans[static_cast<std::size_t>(y)];
    fine_u.clear_outside(span, y);
    fine_v.clear_outside(span, y);
    if (span.empty()) continue;
    const Between between_rows = between(y, coarse.height);
    for (const auto& [rows, at] :
         {std::pair(&near_, between_rows.near), std::pair(&far_, between_rows.far)}) {
      merge(u, at, 2, rows->u);
      merge(v, at, 2, rows->v);
      guide_row(coarse, at, rows->value, rows->known);
    }
    const Guides guides{near_.u.data() + 1,     near_.v.data() + 1,   near_.value.data() + 1,
                        near_.known.data() + 1, far_.u.data() + 1,    far_.v.data() + 1,
                        far_.value.data() + 1,  far_.known.data() + 1};
    const ConstSplitRow here = fine.first.row(y);
    const SplitRow out_u = fine_u.row(y), out_v = fine_v.row(y);
    guided_half(span, -1, per_edge2, guides, here.even, out_u.even, out_v.even);
    guided_half(span, 1, per_edge2, guides, here.odd, out_u.odd, out_v.odd);
  }
}

}  // namespace floatstage::render
