#include "render/cpu/field_memory.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.h"
#include "render/cpu/passage.h"
#include "render/scene_impl.h"

namespace floatstage::render::cpu {
namespace {

// A texel whose surface the picture before shows, too.
struct Taking {
  std::size_t to = 0, from = 0, right = 0, below = 0;  // floats of fields
  std::array<float, 4> weight{};
  float x = 0, y = 0, z = 0;     // there
  float home_x = 0, home_y = 0;  // where that is in this picture
};

FieldsOfPicture fields_of(const Projection& projection, const std::vector<bool>& wanted) {
  const std::array<float, 3>& eye = projection.rays().eye;
  FieldsOfPicture picture{{eye[0], eye[1], eye[2]}, {}, wanted};
  for (std::size_t i = 0; i < projection.choice().chosen; ++i)
    picture.cameras.push_back(projection.choice().listed[i]);
  return picture;
}

// What one call mixes, row by row.
struct Mixing {
  struct Field {
    FlowField* now;
    const FlowField* before;
    float share;  // of what was before
  };
  Passage back, forth;
  SeenSurface surface, surface_before;
  float tolerance;
  float px;  // of the view, of a texel
  std::vector<Field> fields = {};

  void find(int y, std::vector<Taking>& row) const;
  void take(const Field& field, const std::vector<Taking>& row) const;
};

void Mixing::find(int y, std::vector<Taking>& row) const {
  row.clear();
  const FlowField &now = *fields.front().now, &before = *fields.front().before;
  const float py = (static_cast<float>(y) + 0.5F) * px;
  for (int x = 0; x < now.width; ++x) {
    const float here = (static_cast<float>(x) + 0.5F) * px, z = surface.z_at(here, py);
    if (!(z > 0)) continue;
    const Passage::Point there = back.of(here, py, z);
    const float was = there.z > 0 ? surface_before.z_at(there.x, there.y) : 0;
    if (!(was > 0) || std::abs(was - there.z) > tolerance) continue;
    const float fx = std::clamp(there.x / px - 0.5F, 0.F, static_cast<float>(before.width - 1)),
                fy = std::clamp(there.y / px - 0.5F, 0.F, static_cast<float>(before.height - 1));
    const int x0 = static_cast<int>(fx), y0 = static_cast<int>(fy);
    const float rx = fx - static_cast<float>(x0), ry = fy - static_cast<float>(y0);
    const Passage::Point home = forth.of(there.x, there.y, was);
    if (!(home.z > 0)) continue;
    const auto line = static_cast<std::size_t>(before.width);
    row.push_back({2 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(now.width) +
                        static_cast<std::size_t>(x)),
                   2 * (static_cast<std::size_t>(y0) * line + static_cast<std::size_t>(x0)),
                   x0 + 1 < before.width ? std::size_t{2} : 0,
                   y0 + 1 < before.height ? 2 * line : 0,
                   {(1 - rx) * (1 - ry), rx * (1 - ry), (1 - rx) * ry, rx * ry},
                   there.x,
                   there.y,
                   was,
                   home.x,
                   home.y});
  }
}

// A field's two ends lie on the surface: this picture sees them where they are. An end beyond the surface's
// edge is as far as its beginning.
void Mixing::take(const Field& field, const std::vector<Taking>& row) const {
  for (const Taking& t : row) {
    const float* at = field.before->uv.data() + t.from;
    const auto read = [&](std::size_t c) {
      return t.weight[0] * at[c] + t.weight[1] * at[t.right + c] + t.weight[2] * at[t.below + c] +
             t.weight[3] * at[t.below + t.right + c];
    };
    const float x = t.x + px * read(0), y = t.y + px * read(1), z = surface_before.z_at(x, y);
    const Passage::Point end = forth.of(x, y, z > 0 && std::abs(z - t.z) <= tolerance ? z : t.z);
    if (!(end.z > 0)) continue;  // a view from within the scene
    float* uv = field.now->uv.data() + t.to;
    uv[0] += field.share * ((end.x - t.home_x) / px - uv[0]);
    uv[1] += field.share * ((end.y - t.home_y) / px - uv[1]);
  }
}

}  // namespace

void FieldMemory::mix(const Scene& scene, const Projection& projection, const std::vector<bool>& wanted,
                      int shrink, double share, std::span<FlowField> fields) const {
  if (shrink != shrink_ || scene_.lock() != scene.impl().on_cpu || version_ != scene.impl().version) return;
  const Window& window = projection.window();
  Mixing mixing{.back = Passage(projection.rays(), rays_),
                .forth = Passage(rays_, projection.rays()),
                .surface = {projection.inverse_z(), window.width, window.height},
                .surface_before = {inverse_z_.data(), width_, height_},
                .tolerance = projection.tolerance(),
                .px = static_cast<float>(shrink)};
  for (const RememberedField& one :
       remembered_fields(scene.impl(), fields_of(projection, wanted), picture_, share))
    mixing.fields.push_back({&fields[one.now], &fields_[one.before], one.share});
  if (mixing.fields.empty()) return;
  const int height = fields[0].height, threads = projection.threads(),
            bands = std::max(1, std::min(height, threads > 0 ? threads : default_threads()));
  parallel_for(static_cast<std::size_t>(bands), threads, [&](std::size_t band) {
    const int at = static_cast<int>(band);
    std::vector<Taking> row;
    for (int y = height * at / bands; y < height * (at + 1) / bands; ++y) {
      mixing.find(y, row);
      for (const Mixing::Field& field : mixing.fields) mixing.take(field, row);
    }
  });
}

void FieldMemory::keep(const Scene& scene, const Projection& projection, const std::vector<bool>& wanted,
                       int shrink, std::span<FlowField> fields) {
  scene_ = scene.impl().on_cpu;
  version_ = scene.impl().version;
  rays_ = projection.rays();
  width_ = projection.window().width;
  height_ = projection.window().height;
  shrink_ = shrink;
  inverse_z_.assign(projection.inverse_z(),
                    projection.inverse_z() + static_cast<std::ptrdiff_t>(width_) * height_);
  picture_ = fields_of(projection, wanted);
  fields_.resize(std::max(fields_.size(), fields.size()));
  std::swap_ranges(fields.begin(), fields.end(), fields_.begin());
}

}  // namespace floatstage::render::cpu
