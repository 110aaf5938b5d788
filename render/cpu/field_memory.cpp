#include "render/cpu/field_memory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/parallel.h"
#include "render/pairwise_flows.h"
#include "render/scene_impl.h"

namespace floatstage::render::cpu {
namespace {

constexpr float kMostStretch = 2;  // from one picture to the next; more is an edge

// A place of this view's surface in the picture before, px of its window.
struct Place {
  float x = 0, y = 0;
  bool known = false;
};

// Finds them: through the proxy.
class WayBack {
 public:
  WayBack(const ViewRays& now, const ViewRays& before) : now_(now), before_(before) {
    const std::array<float, 9>&a = before.world_from_view, &b = now.world_from_view;
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t c = 0; c < 3; ++c) turn_[3 * r + c] += a[3 * k + r] * b[3 * k + c];
        move_[r] += a[3 * k + r] * (now.eye[k] - before.eye[k]);
      }
  }

  // Of pixel x, y of this view at depth 1/inverse_z; `inverse_z_before` of the other's pixels.
  Place of(float x, float y, float inverse_z, const float* inverse_z_before, int width, int height,
           float tolerance) const {
    if (!(inverse_z > 0)) return {};
    const float z = 1 / inverse_z, ry = (y - now_.cy) * now_.inverse_fy,
                rx = (x - now_.cx - now_.skew * ry) * now_.inverse_fx;
    std::array<float, 3> at = move_;
    for (std::size_t r = 0; r < 3; ++r)
      at[r] += z * (turn_[3 * r] * rx + turn_[3 * r + 1] * ry + turn_[3 * r + 2]);
    if (!(at[2] > 0)) return {};
    const float py = at[1] / at[2];
    const Place place{at[0] / at[2] / before_.inverse_fx + before_.skew * py + before_.cx,
                      py / before_.inverse_fy + before_.cy, true};
    if (!(place.x >= 0 && place.y >= 0 && place.x < static_cast<float>(width) &&
          place.y < static_cast<float>(height)))
      return {};
    const float was = inverse_z_before[static_cast<std::size_t>(place.y) * static_cast<std::size_t>(width) +
                                       static_cast<std::size_t>(place.x)];
    return was > 0 && std::abs(1 / was - at[2]) <= tolerance ? place : Place();
  }

 private:
  const ViewRays &now_, &before_;
  std::array<float, 9> turn_{};
  std::array<float, 3> move_{};
};

// How the picture before is stretched against this one along a row or a column: by the neighbours of a place
// on the same surface.
bool stretch(const Place& at, const Place& after, const Place& ahead, float px, std::array<float, 2>& d) {
  for (const auto& [other, sign] : {std::pair(after, 1.F), std::pair(ahead, -1.F)}) {
    if (!other.known) continue;
    d = {sign * (other.x - at.x) / px, sign * (other.y - at.y) / px};
    const float square = d[0] * d[0] + d[1] * d[1];
    if (square < kMostStretch * kMostStretch && square * kMostStretch * kMostStretch > 1) return true;
  }
  return false;
}

// A texel that takes from fields of before: where it reads them, and how what it reads is turned and
// stretched into this picture, times its share.
struct Taking {
  std::size_t to = 0, from = 0, right = 0, below = 0;  // floats
  std::array<float, 4> weight{}, turn{};
};

Taking taking(std::size_t to, const Place& place, float px, int width, int height,
              const std::array<float, 2>& along, const std::array<float, 2>& down, float scale) {
  const float x = std::clamp(place.x / px - 0.5F, 0.F, static_cast<float>(width - 1)),
              y = std::clamp(place.y / px - 0.5F, 0.F, static_cast<float>(height - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const auto line = static_cast<std::size_t>(width);
  return {2 * to,
          2 * (static_cast<std::size_t>(y0) * line + static_cast<std::size_t>(x0)),
          x0 + 1 < width ? std::size_t{2} : 0,
          y0 + 1 < height ? 2 * line : 0,
          {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy},
          {scale * down[1], -scale * down[0], -scale * along[1], scale * along[0]}};
}

void take(const std::vector<Taking>& all, float kept, const float* before, float* field) {
  for (const Taking& t : all) {
    const float* at = before + t.from;
    const auto read = [&](std::size_t c) {
      return t.weight[0] * at[c] + t.weight[1] * at[t.right + c] + t.weight[2] * at[t.below + c] +
             t.weight[3] * at[t.below + t.right + c];
    };
    const float u = read(0), v = read(1);
    field[t.to] = kept * field[t.to] + t.turn[0] * u + t.turn[1] * v;
    field[t.to + 1] = kept * field[t.to + 1] + t.turn[2] * u + t.turn[3] * v;
  }
}

// What one call mixes, band by band.
struct Mixing {
  const Projection& projection;
  WayBack back;
  const float* inverse_z;  // of the picture before
  int width_before, height_before;
  float px;                                                     // of the view, of a texel
  float share;                                                  // of what was before
  std::vector<std::pair<FlowField*, const FlowField*>> fields;  // of this picture, and of the one before

  int width() const { return fields.front().first->width; }
  int height() const { return fields.front().first->height; }
  void find(int y, std::vector<Place>& row) const;
  void mix(int first, int last) const;
};

// The places of a row's texels; nothing beyond the field.
void Mixing::find(int y, std::vector<Place>& row) const {
  const Window& window = projection.window();
  row.assign(static_cast<std::size_t>(width()), Place());
  const float py = (static_cast<float>(y) + 0.5F) * px;
  const int line = static_cast<int>(py);
  if (y < 0 || y >= height() || line >= window.height) return;
  const float* plane = projection.inverse_z() + static_cast<std::ptrdiff_t>(line) * window.width;
  for (std::size_t x = 0; x < row.size(); ++x) {
    const float at = (static_cast<float>(x) + 0.5F) * px;
    const int column = static_cast<int>(at);
    if (column >= window.width) break;
    row[x] = back.of(at, py, plane[column], inverse_z, width_before, height_before, projection.tolerance());
  }
}

void Mixing::mix(int first, int last) const {
  std::vector<Place> above, row, below;
  std::vector<Taking> takings;
  const FlowField& before = *fields.front().second;
  find(first - 1, above);
  find(first, row);
  for (int y = first; y < last; ++y) {
    find(y + 1, below);
    takings.clear();
    for (std::size_t x = 0; x < row.size(); ++x) {
      const Place &at = row[x], after = x + 1 < row.size() ? row[x + 1] : Place(),
                  ahead = x > 0 ? row[x - 1] : Place();
      std::array<float, 2> along, down;
      if (!at.known || !stretch(at, after, ahead, px, along) || !stretch(at, below[x], above[x], px, down))
        continue;
      const float determinant = along[0] * down[1] - along[1] * down[0];
      if (!(determinant * kMostStretch * kMostStretch > 1)) continue;
      const std::size_t to = static_cast<std::size_t>(y) * row.size() + x;
      takings.push_back(taking(to, at, px, before.width, before.height, along, down, share / determinant));
    }
    for (const auto& [field, was] : fields) take(takings, 1 - share, was->uv.data(), field->uv.data());
    std::swap(above, row);
    std::swap(row, below);
  }
}

}  // namespace

void FieldMemory::mix(const Scene& scene, const Projection& projection, const std::vector<bool>& wanted,
                      int shrink, float share, std::span<FlowField> fields) const {
  if (fields.empty() || shrink != shrink_ || scene_.lock() != scene.impl().on_cpu ||
      version_ != scene.impl().version)
    return;
  const std::size_t count = projection.choice().chosen;
  const auto slot_before = [&](std::size_t slot) {
    return static_cast<std::size_t>(
        std::find(cameras_.begin(), cameras_.end(), projection.choice().listed[slot]) - cameras_.begin());
  };
  Mixing mixing{projection,
                WayBack(projection.rays(), rays_),
                inverse_z_.data(),
                width_,
                height_,
                static_cast<float>(shrink),
                share,
                {}};
  for (std::size_t index = 0; index < fields.size(); ++index) {
    const FlowPair pair = flow_pair_at(index, count);
    const FlowPair before{slot_before(pair.first), slot_before(pair.second)};
    if (wanted[pair.second] && before.first < cameras_.size() && before.second < cameras_.size() &&
        wanted_[before.second])
      mixing.fields.emplace_back(&fields[index], &fields_[flow_index_of(before, cameras_.size())]);
  }
  if (mixing.fields.empty()) return;
  const int height = mixing.height(), threads = projection.threads(),
            bands = std::max(1, std::min(height, threads > 0 ? threads : default_threads()));
  parallel_for(static_cast<std::size_t>(bands), threads, [&](std::size_t band) {
    const int at = static_cast<int>(band);
    mixing.mix(height * at / bands, height * (at + 1) / bands);
  });
}

void FieldMemory::keep(const Scene& scene, const Projection& projection, const std::vector<bool>& wanted,
                       int shrink, std::span<FlowField> fields) {
  if (fields.empty()) return forget();
  scene_ = scene.impl().on_cpu;
  version_ = scene.impl().version;
  rays_ = projection.rays();
  width_ = projection.window().width;
  height_ = projection.window().height;
  shrink_ = shrink;
  inverse_z_.assign(projection.inverse_z(),
                    projection.inverse_z() + static_cast<std::ptrdiff_t>(width_) * height_);
  cameras_ = {};
  for (std::size_t i = 0; i < projection.choice().chosen; ++i)
    cameras_.push_back(projection.choice().listed[i]);
  wanted_ = wanted;
  fields_.resize(std::max(fields_.size(), fields.size()));
  std::swap_ranges(fields.begin(), fields.end(), fields_.begin());
}

}  // namespace floatstage::render::cpu
