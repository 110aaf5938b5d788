#include "render/cpu/outline.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "render/cpu/weight_kernels.h"

namespace floatstage::render::cpu {
namespace {

constexpr int kBandRows = 32;
constexpr float kNear = 0.5F;  // of soft visibility's radius: how far from the outline mattes count

std::uint8_t byte_of(float share) {
  return static_cast<std::uint8_t>(255 * std::clamp(share, 0.F, 1.F) + 0.5F);
}

/// The share of a pixel that is covered; `centre`: so is its middle, which is no sample.
float share_of(std::uint8_t samples, bool centre) {
  const int count = std::popcount(samples);
  return static_cast<float>(centre ? std::max(count, 1) : count) / static_cast<float>(kSamples.size());
}

}  // namespace

void Outline::run(Projection& projection, bool show, Image& picture) {
  const Window& w = projection.window();
  left_ = std::max(0, -w.x), right_ = std::min(w.width, picture.width - w.x);
  top_ = std::max(0, -w.y), bottom_ = std::min(w.height, picture.height - w.y);
  if (left_ >= right_ || top_ >= bottom_) return;
  reserve(projection);
  for_bands(projection, [&](int first, int last) { find_outside(projection, first, last); });
  for_bands(projection, [&](int first, int last) { find_rim(projection, first, last); });
  cover_rim(projection);
  projection.for_rows([&](int y, RowMemory&) {
    if (y >= top_ && y < bottom_) weigh_row(projection, y, picture);
  });
  for_bands(projection, [&](int first, int last) {
    for (int y = first; y < last; ++y) blend_rim(projection, y, show, picture);
  });
}

template <class Body>
void Outline::for_bands(const Projection& projection, const Body& body) const {
  const auto bands = static_cast<std::size_t>((bottom_ - top_ + kBandRows - 1) / kBandRows);
  parallel_for(bands, projection.threads(), [&](std::size_t band) {
    const int first = top_ + static_cast<int>(band) * kBandRows;
    body(first, std::min(first + kBandRows, bottom_));
  });
}

void Outline::reserve(const Projection& projection) {
  const auto rows = static_cast<std::size_t>(projection.window().height);
  const std::size_t pixels = static_cast<std::size_t>(projection.window().width) * rows;
  const float radius = kNear * projection.radius();
  reach_ = radius < 1 ? 0 : static_cast<int>(std::ceil(radius));
  for (auto* plane : {&outside_, &rim_, &covered_, &solid_})
    if (plane->size() < pixels) plane->resize(pixels);
  if (distances_.size() < pixels) distances_.resize(pixels);
  near_.assign(rows, 0);
  scratch_ = 2 * (static_cast<std::size_t>(projection.window().width + 2 * reach_) + 64);
  const std::size_t bands = rows / kBandRows + 1;
  if (memory_.size() < bands * scratch_) memory_.resize(bands * scratch_);
}

// Of the band that begins with this row.
std::uint8_t* Outline::scratch_of(int first) {
  return memory_.data() + static_cast<std::size_t>((first - top_) / kBandRows) * scratch_;
}

// Beyond the view nothing is outside: what no picture shows has no part in it.
void Outline::find_outside(const Projection& projection, int first, int last) {
  const int width = projection.window().width;
  const auto across = static_cast<std::size_t>(width);
  std::uint8_t* scratch = scratch_of(first);
  for (auto y = static_cast<std::size_t>(first); y < static_cast<std::size_t>(last); ++y) {
    const float* inverse_z = projection.inverse_z() + y * across;
    std::uint8_t* outside = outside_.data() + y * across;
    std::fill_n(outside, across, std::uint8_t{0});
    for (int x = left_; x < right_; ++x) outside[x] = inverse_z[x] > 0 ? 0 : 1;
    if (reach_ > 0)
      near_[y] = row_distances(outside, width, 0, reach_, scratch, distances_.data() + y * across);
  }
}

void Outline::find_rim(const Projection& projection, int first, int last) {
  const int width = projection.window().width;
  const auto across = static_cast<std::size_t>(width);
  std::uint8_t *any = scratch_of(first), *all = any + across + 2;  // of three rows
  for (int y = first; y < last; ++y) {
    const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * width;
    const std::uint8_t *here = outside_.data() + line, *above = y > top_ ? here - width : here,
                       *below = y + 1 < bottom_ ? here + width : here;
    const auto l = static_cast<std::size_t>(left_), r = static_cast<std::size_t>(right_);
    for (std::size_t x = l; x < r; ++x) {
      any[x + 1] = here[x] | above[x] | below[x];
      all[x + 1] = here[x] & above[x] & below[x];
    }
    any[l] = any[l + 1], all[l] = all[l + 1], any[r + 1] = any[r], all[r + 1] = all[r];
    std::uint8_t* rim = rim_.data() + line;
    std::fill_n(rim, across, std::uint8_t{0});
    for (std::size_t x = l; x < r; ++x)
      rim[x] = static_cast<std::uint8_t>((any[x] | any[x + 1] | any[x + 2]) &
                                         ~(all[x] & all[x + 1] & all[x + 2]) & 1);
    std::fill_n(covered_.data() + line, across, std::uint8_t{0});
  }
}

// Every band walks over all triangles: one a thread.
void Outline::cover_rim(const Projection& projection) {
  const int workers = projection.threads() > 0 ? projection.threads() : static_cast<int>(default_threads());
  const int rows = bottom_ - top_, bands = std::min(workers, rows);
  parallel_for(static_cast<std::size_t>(bands), projection.threads(), [&](std::size_t band) {
    const int i = static_cast<int>(band);
    projection.on_screen().cover({projection.window().width, top_ + i * rows / bands,
                                  top_ + (i + 1) * rows / bands, rim_.data(), covered_.data()});
  });
}

// What the mattes say, as far as the outline is near.
void Outline::weigh_row(const Projection& projection, int y, Image& picture) {
  const Covered::Row& row = projection.covered().rows[static_cast<std::size_t>(y)];
  const Window& window = projection.window();
  const float radius = kNear * projection.radius();
  for (std::size_t s = row.first_span; s < row.last_span; ++s) {
    const Covered::Span& span = projection.covered().spans[s];
    const float *matte = projection.matte() + span.list, *most = projection.most_opaque() + span.list;
    std::uint8_t* solid = solid_.data() + static_cast<std::ptrdiff_t>(y) * window.width;
    for (int x = span.begin; x < span.end; ++x, ++matte, ++most) {
      if (x < left_ || x >= right_) continue;
      float opacity = 1;
      if (*matte < 1 && radius > 1) {
        int nearest = kNoneNear;
        for (int dy = -reach_; dy <= reach_; ++dy) {
          const int from = y + dy;
          if (from < top_ || from >= bottom_ || near_[static_cast<std::size_t>(from)] == 0) continue;
          nearest = std::min(
              nearest, distances_[static_cast<std::size_t>(from) * static_cast<std::size_t>(window.width) +
                                  static_cast<std::size_t>(x)] +
                           dy * dy);
        }
        const float away = std::sqrt(static_cast<float>(nearest));
        opacity -= (1 - *matte) * std::clamp((radius - away) / (radius - 1), 0.F, 1.F);
      }
      solid[x] = byte_of(std::min(opacity, 2 * *most));
      picture.at(x + window.x, y + window.y)[3] = solid[x];
    }
  }
}

void Outline::blend_rim(const Projection& projection, int y, bool show, Image& picture) const {
  const Window& window = projection.window();
  const auto width = static_cast<std::ptrdiff_t>(window.width);
  for (int x = left_; x < right_; ++x) {
    const auto at = static_cast<std::size_t>(y * width + x);
    std::uint8_t* to = picture.at(x + window.x, y + window.y);
    if (rim_[at] != 0) {
      const bool centre = outside_[at] == 0;
      float opacity = static_cast<float>(solid_[at]) / 255;
      if (!centre) {  // the colours of what is next to it
        int sum[3] = {0, 0, 0}, solid = 0, count = 0;
        for (int dy = -1; covered_[at] != 0 && dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const int u = x + dx, v = y + dy;
            if (u < left_ || u >= right_ || v < top_ || v >= bottom_) continue;
            const auto next = static_cast<std::size_t>(v * width + u);
            if (outside_[next] != 0) continue;
            const std::uint8_t* c = picture.at(u + window.x, v + window.y);
            for (int k = 0; k < 3 && !show; ++k) sum[k] += c[k];
            solid += solid_[next];
            ++count;
          }
        if (solid == 0) continue;
        opacity = static_cast<float>(solid) / static_cast<float>(255 * count);
        for (int k = 0; k < 3; ++k) to[k] = static_cast<std::uint8_t>((sum[k] + count / 2) / count);
      }
      to[3] = byte_of(opacity * share_of(covered_[at], centre));
    }
    if (show && to[3] != 0) {
      to[0] = to[1] = to[2] = to[3];
      to[3] = 255;
    }
  }
}

}  // namespace floatstage::render::cpu
