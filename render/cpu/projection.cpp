#include "render/cpu/projection.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/check.h"
#include "render/cpu/footprint_kernels.h"
#include "render/cpu/row_mean.h"
#include "render/cpu/weight_kernels.h"
#include "render/depth_windows.h"

namespace floatstage::render::cpu {
namespace {

constexpr std::size_t kRowPieces = 160;  // of a row's length that one row's work may need
constexpr std::size_t kMostBands = 32;

float f(double v) { return static_cast<float>(v); }

/// The view on the window's pixels.
RasterCamera raster_camera(const View& view, const Window& window) {
  Eigen::Matrix3d k = view.model.k();
  k(0, 2) -= window.x;
  k(1, 2) -= window.y;
  RasterCamera out;
  out.rows = (k * view.view_from_world.matrix().topRows<3>()).cast<float>();
  out.near_plane = f(view.near_plane);
  out.far_plane = f(view.far_plane);
  out.width = window.width;
  out.height = window.height;
  return out;
}

}  // namespace

ViewRays view_rays(const View& view, const Window& window) {
  const CameraModel& m = view.model;
  ViewRays rays{};
  rays.inverse_fx = f(1 / m.fx);
  rays.inverse_fy = f(1 / m.fy);
  rays.cx = f(m.cx - window.x);
  rays.cy = f(m.cy - window.y);
  rays.skew = f(m.skew);
  const Eigen::Matrix4d world_from_view = view.view_from_world.inverse().matrix();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      rays.world_from_view[static_cast<std::size_t>(3 * row + column)] = f(world_from_view(row, column));
  const Eigen::Vector3d eye = view.view_from_world.center();
  rays.eye = {f(eye.x()), f(eye.y()), f(eye.z())};
  return rays;
}

namespace {

std::uint32_t packed(const float* rgb) {
  auto byte = [](float v) { return static_cast<std::uint32_t>(v + 0.5F); };
  return byte(rgb[0]) | byte(rgb[1]) << 8 | byte(rgb[2]) << 16 | 255U << 24;
}

template <class T>
void grow(std::vector<T>& v, std::size_t size) {
  if (v.size() < size) v.resize(size);
}

}  // namespace

float* RowMemory::floats(std::size_t count) {
  const std::size_t padded = (count + Covered::kAlign - 1) / Covered::kAlign * Covered::kAlign;
  FLOATSTAGE_CHECK(used_ + padded <= memory_.size(), "a row's work fits its memory");
  float* piece = memory_.data() + used_;
  used_ += padded;
  return piece;
}

Result<void> Projection::run(const Scene& scene, const View& view, const RendererOptions& options,
                             const Wanted& wanted) {
  interruption_.begin(options.given_up);
  const Scene::Impl& s = scene.impl();
  choice_ = wanted.cameras != nullptr ? *wanted.cameras : s.choose(view, options.cameras);
  window_ = window_of(view, s.mesh.positions, s.vertex_blocks, wanted.margin);
  if (window_.empty()) return {};
  mesh_ = &s.mesh;
  margin_ = wanted.margin;
  threads_ = options.threads;
  sharp_ = options.sharp;
  radius_ = f(options.soft_radius);
  tolerance_ = f(depth_tolerance(s.box));
  rays_ = view_rays(view, window_);

  const std::size_t pixels = line(window_.height);
  grow(inverse_z_, pixels);
  grow(triangle_, pixels);
  raster_.run(s, raster_camera(view, window_), choice_.listed, threads_, inverse_z_.data(), triangle_.data());
  if (interruption_.given_up()) return given_up();
  take_photographs(s, view, wanted.levels);
  covered_.find(window_.width, window_.height, inverse_z_.data());
  reserve();
  if (wanted.mattes)
    for (auto* list : {&matte_, &most_opaque_}) grow(*list, covered_.padded);
  plan_bands();
  for_rows([&](int y, RowMemory& memory) { see_row(y, wanted, memory); });
  for_rows([&](int y, RowMemory& memory) { measure_row(y, memory); });
  for_rows([&](int y, RowMemory& memory) { weigh_row(y, wanted, memory); });
  return interruption_.given_up() ? Result<void>(given_up()) : Result<void>();
}

void Projection::take_photographs(const Scene::Impl& s, const View& view, bool levels) {
  ShortList<int, kMostListed> with_levels;
  for (std::size_t slot = 0; slot < choice_.listed.size(); ++slot) {
    const int camera = choice_.listed[slot];
    minified_[slot] = deepest_level(s.cameras[static_cast<std::size_t>(camera)], view, s.box) > 0;
    if (levels || minified_[slot]) with_levels.push_back(camera);
  }
  const PhotoPyramid* pyramid =
      with_levels.size() > 0 ? &PhotoPyramid::of(s, {with_levels.begin(), with_levels.end()}) : nullptr;
  for (std::size_t slot = 0; slot < choice_.listed.size(); ++slot) {
    const auto i = static_cast<std::size_t>(choice_.listed[slot]);
    PhotoCamera camera = photo_camera(s.blocks[i], s.tiles[i]);
    camera.depth = SceneMaps::of(s).maps[i].inverse_z.data();
    camera.depth_width = s.depth_windows[i].width;
    camera.depth_height = s.depth_windows[i].height;
    photos_[slot].set(camera, levels || minified_[slot] ? pyramid : nullptr, i);
  }
}

void Projection::reserve() {
  const std::size_t pixels = line(window_.height), rows = static_cast<std::size_t>(window_.height);
  grow(hidden_, pixels);
  grow(own_, pixels);
  grow(visible_, covered_.padded);
  for (std::size_t slot = 0; slot < choice_.listed.size(); ++slot) {
    grow(row_distances_[slot], pixels);
    row_has_hidden_[slot].assign(rows, 0);
    for (auto* list : {&angular_[slot], &weight_[slot], &soft_[slot]}) grow(*list, covered_.padded);
    if (minified_[slot]) grow(footprint_[slot], covered_.padded);
    if (slot >= choice_.chosen) continue;
    grow(soft_planes_[slot], pixels);
    grow(images_[slot], pixels);
  }
  // Bilinear reads touch the rows beside the proxy's first and last.
  for (std::size_t y = 0; y < rows; ++y)
    for (std::size_t slot = 0; slot < choice_.chosen && covered_.rows[y].count == 0; ++slot)
      std::fill_n(soft_planes_[slot].data() + line(static_cast<int>(y)), window_.width, 0.F);
  row_floats_ = kRowPieces * static_cast<std::size_t>(window_.width + 2 * Covered::kAlign) + 1024;
}

// Rows with about as many covered pixels each; rows without any go with a neighbour.
void Projection::plan_bands() {
  bands_.clear();
  const std::size_t share = covered_.padded / kMostBands + 1;
  std::size_t pixels = 0;
  int first = 0;
  for (int y = 0; y < window_.height; ++y) {
    pixels += static_cast<std::size_t>(covered_.rows[static_cast<std::size_t>(y)].count);
    if (pixels < share && y + 1 < window_.height) continue;
    bands_.push_back({first, y + 1});
    first = y + 1;
    pixels = 0;
  }
  if (memory_.size() < bands_.size()) memory_.resize(bands_.size());
}

void Projection::write_normals(int y, float* nx, float* ny, float* nz) const {
  const Covered::Row& row = covered_.rows[static_cast<std::size_t>(y)];
  const Eigen::Vector3f eye(rays_.eye[0], rays_.eye[1], rays_.eye[2]);
  std::uint32_t last = ~0U;
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  for (std::size_t s = row.first_span; s < row.last_span; ++s) {
    const Covered::Span& span = covered_.spans[s];
    std::size_t at = span.list - row.list;
    for (int x = span.begin; x < span.end; ++x, ++at) {
      const std::uint32_t triangle = triangle_[line(y) + static_cast<std::size_t>(x)];
      if (triangle != last) {
        last = triangle;
        const std::uint32_t* corner = mesh_->triangles.data() + 3 * static_cast<std::size_t>(triangle);
        const Eigen::Vector3f &a = mesh_->positions[corner[0]], &b = mesh_->positions[corner[1]],
                              &c = mesh_->positions[corner[2]];
        normal = (b - a).cross(c - a);
        const float length2 = normal.squaredNorm();
        normal = length2 > 0 ? Eigen::Vector3f(normal / std::sqrt(length2)) : (eye - a).normalized();
        if (normal.dot(eye - a) < 0) normal = -normal;
      }
      nx[at] = normal.x();
      ny[at] = normal.y();
      nz[at] = normal.z();
    }
  }
}

void Projection::see_row(int y, const Wanted& wanted, RowMemory& memory) {
  const Covered::Row& row = covered_.rows[static_cast<std::size_t>(y)];
  const auto count = static_cast<std::size_t>(row.count);
  float *nx = memory.floats(count), *ny = memory.floats(count), *nz = memory.floats(count);
  float *u = memory.floats(count), *v = memory.floats(count), *rgba = memory.floats(4 * count);
  std::int32_t *seen = memory.ints(count), *bits = memory.ints(count);
  write_normals(y, nx, ny, nz);
  std::fill_n(bits, count, 0);
  const PixelList points{covered_.x.data() + row.list, nullptr, covered_.inverse_z.data() + row.list,
                         static_cast<float>(y) + 0.5F, row.count};
  MatteSums mattes;
  if (wanted.mattes) {
    mattes = {1, matte_.data() + row.list, memory.floats(count), most_opaque_.data() + row.list,
              memory.floats(count)};
    for (float* list : {mattes.sum, mattes.weight, mattes.most}) std::fill_n(list, count, 0.F);
    std::fill_n(mattes.behind, count, wanted.unreached);
  }
  for (std::size_t slot = 0; slot < choice_.listed.size(); ++slot) {
    mattes.reach = choice_.fade[slot] + kStandIn * choice_.stand_in_fade[slot];
    see_points(camera(slot), rays_, points, {nx, ny, nz}, tolerance_, u, v, seen,
               angular_[slot].data() + row.list, mattes);
    if (minified_[slot])
      footprints(camera(slot), rays_, points, {nx, ny, nz}, footprint_[slot].data() + row.list);
    for (std::size_t i = 0; i < count; ++i) bits[i] |= seen[i] << slot;
    if (!wanted.images || slot >= choice_.chosen) continue;
    read(slot, row, u, v, seen, rgba, memory);
    for (std::size_t s = row.first_span; s < row.last_span; ++s) {
      const Covered::Span& span = covered_.spans[s];
      std::uint32_t* to = images_[slot].data() + line(y);
      for (int x = span.begin; x < span.end; ++x) {
        const std::size_t i = span.list - row.list + static_cast<std::size_t>(x - span.begin);
        if (seen[i] != 0) to[x] = packed(rgba + 4 * i);
      }
    }
  }
  for (std::size_t i = 0; wanted.mattes && i < count; ++i) {
    const bool watched = mattes.weight[i] > 0;
    mattes.sum[i] = watched ? mattes.sum[i] / mattes.weight[i] : 1;
    if (!watched) mattes.most[i] = mattes.behind[i];
  }
  std::uint8_t* hidden = hidden_.data() + line(y);
  std::fill_n(hidden, window_.width, std::uint8_t{0});
  const int all = (1 << choice_.listed.size()) - 1;
  for (std::size_t i = 0; i < count; ++i) visible_[row.list + i] = static_cast<std::uint8_t>(bits[i]);
  for (std::size_t s = row.first_span; s < row.last_span; ++s) {
    const Covered::Span& span = covered_.spans[s];
    for (int x = span.begin; x < span.end; ++x)
      hidden[x] =
          static_cast<std::uint8_t>(~visible_[span.list + static_cast<std::size_t>(x - span.begin)] & all);
  }
}

// The distance filter's first pass over what is hidden and no speck.
void Projection::measure_row(int y, RowMemory& memory) {
  if (radius_ < 1) return;
  const int reach = static_cast<int>(std::ceil(radius_));
  const auto width = static_cast<std::size_t>(window_.width);
  auto* above = reinterpret_cast<std::uint8_t*>(memory.floats(width / 4 + 1));
  auto* below = reinterpret_cast<std::uint8_t*>(memory.floats(width / 4 + 1));
  auto* hidden = reinterpret_cast<std::uint8_t*>(memory.floats(width / 4 + 1));
  auto* scratch = reinterpret_cast<std::uint8_t*>(
      memory.floats(static_cast<std::size_t>(2 * window_.width + 2 * reach) / 4 + 64));
  std::memset(above, 0, width);
  std::memset(below, 0, width);
  if (y > 0) std::copy_n(hidden_.data() + line(y - 1), width, above);
  if (y + 1 < window_.height) std::copy_n(hidden_.data() + line(y + 1), width, below);
  without_specks(above, hidden_.data() + line(y), below, window_.width, hidden);
  for (std::size_t slot = 0; slot < choice_.listed.size(); ++slot)
    row_has_hidden_[slot][static_cast<std::size_t>(y)] = row_distances(
        hidden, window_.width, static_cast<int>(slot), reach, scratch, row_distances_[slot].data() + line(y));
}

void Projection::soften_row(int y, RowMemory&) {
  const Covered::Row& row = covered_.rows[static_cast<std::size_t>(y)];
  constexpr int kMostRows = 2 * 64 + 1;
  const std::int16_t* rows[kMostRows];
  const std::int16_t* here[kMostRows];
  std::int16_t offsets[kMostRows];
  const int reach = radius_ < 1 ? -1 : static_cast<int>(std::ceil(radius_));
  for (std::size_t slot = 0; slot < choice_.listed.size(); ++slot) {
    int found = 0;
    for (int dy = -reach; dy <= reach; ++dy) {
      const int from = y + dy;
      if (from < 0 || from >= window_.height || row_has_hidden_[slot][static_cast<std::size_t>(from)] == 0)
        continue;
      rows[found] = row_distances_[slot].data() + line(from);
      offsets[found++] = static_cast<std::int16_t>(dy * dy);
    }
    for (std::size_t s = row.first_span; s < row.last_span; ++s) {
      const Covered::Span& span = covered_.spans[s];
      float* soft = soft_[slot].data() + span.list;
      if (found == 0) {
        std::fill_n(soft, span.end - span.begin, 1.F);
        continue;
      }
      for (int i = 0; i < found; ++i) here[i] = rows[i] + span.begin;
      soft_shares(here, offsets, found, radius_, span.end - span.begin, soft);
    }
  }
}

void Projection::weigh_row(int y, const Wanted& wanted, RowMemory& memory) {
  const Covered::Row& row = covered_.rows[static_cast<std::size_t>(y)];
  soften_row(y, memory);
  WeightRow weights;
  weights.count = row.count;
  weights.listed = static_cast<int>(choice_.listed.size());
  weights.one_camera = wanted.one_camera;
  weights.visible = visible_.data() + row.list;
  for (std::size_t slot = 0; slot < choice_.listed.size(); ++slot) {
    weights.angular[slot] = angular_[slot].data() + row.list;
    weights.soft[slot] = soft_[slot].data() + row.list;
    weights.weight[slot] = weight_[slot].data() + row.list;
    weights.fade[slot] = choice_.fade[slot];
    weights.stand_in_fade[slot] = choice_.stand_in_fade[slot];
  }
  blending_weights(weights);
  if (!wanted.images) return;
  fill_row(y, memory);
  if (!wanted.fill) show_hidden(y, memory);
}

// Where a chosen camera sees nothing its image takes the blend of those that do: which of them is the
// strongest changes at once as the view moves, how much each counts does not.
void Projection::fill_row(int y, RowMemory& memory) {
  const Covered::Row& row = covered_.rows[static_cast<std::size_t>(y)];
  const auto count = static_cast<std::size_t>(row.count);
  const int chosen = (1 << choice_.chosen) - 1;
  std::int32_t* wanted = memory.ints(count);
  std::int32_t* inside = memory.ints(count);
  float *u = memory.floats(count), *v = memory.floats(count), *rgba = memory.floats(4 * count);
  float* share = memory.floats(count);
  const std::uint8_t* visible = visible_.data() + row.list;
  const PixelList points{covered_.x.data() + row.list, nullptr, covered_.inverse_z.data() + row.list,
                         static_cast<float>(y) + 0.5F, row.count};
  RowMean mean(count, kFaint, memory);
  for (std::size_t slot = 0; slot < choice_.listed.size(); ++slot) {
    const float* weight = weight_[slot].data() + row.list;
    for (std::size_t i = 0; i < count; ++i) share[i] = (visible[i] & chosen) != chosen ? weight[i] : 0;
    if (!mark_weighty(share, kFaint, count, wanted)) continue;
    project_points(camera(slot), rays_, points, u, v, inside);
    read(slot, row, u, v, wanted, rgba, memory);
    mean.add({share, rgba});
  }
  const float* fill = mean.finish(false, {});
  std::uint8_t* own = own_.data() + line(y);
  std::fill_n(own, window_.width, std::uint8_t{0});
  for (std::size_t slot = 0; slot < choice_.chosen; ++slot)
    std::fill_n(soft_planes_[slot].data() + line(y), window_.width, 0.F);
  for (std::size_t s = row.first_span; s < row.last_span; ++s) {
    const Covered::Span& span = covered_.spans[s];
    const std::size_t first = span.list - row.list, at = line(y) + static_cast<std::size_t>(span.begin);
    const auto length = static_cast<std::size_t>(span.end - span.begin);
    for (std::size_t i = 0; i < length; ++i) {
      const int sees = visible[first + i] & chosen;
      own[static_cast<std::size_t>(span.begin) + i] = static_cast<std::uint8_t>(sees);
      if (sees == chosen) continue;
      const std::uint32_t color = packed(fill + 4 * (first + i));
      for (std::size_t slot = 0; slot < choice_.chosen; ++slot)
        if ((sees >> slot & 1) == 0) images_[slot][at + i] = color;
    }
    for (std::size_t slot = 0; slot < choice_.chosen; ++slot)
      std::copy_n(soft_[slot].data() + span.list, length, soft_planes_[slot].data() + at);
  }
}

// What a photograph shows where something hides the proxy from it counts as its own.
void Projection::show_hidden(int y, RowMemory& memory) {
  const Covered::Row& row = covered_.rows[static_cast<std::size_t>(y)];
  const auto count = static_cast<std::size_t>(row.count);
  float *u = memory.floats(count), *v = memory.floats(count), *rgba = memory.floats(4 * count);
  std::int32_t *wanted = memory.ints(count), *inside = memory.ints(count);
  const PixelList points{covered_.x.data() + row.list, nullptr, covered_.inverse_z.data() + row.list,
                         static_cast<float>(y) + 0.5F, row.count};
  for (std::size_t slot = 0; slot < choice_.chosen; ++slot) {
    project_points(camera(slot), rays_, points, u, v, inside);
    for (std::size_t i = 0; i < count; ++i)
      wanted[i] = inside[i] != 0 && (visible_[row.list + i] >> slot & 1) == 0 ? 1 : 0;
    read(slot, row, u, v, wanted, rgba, memory);
    for (std::size_t s = row.first_span; s < row.last_span; ++s) {
      const Covered::Span& span = covered_.spans[s];
      for (int x = span.begin; x < span.end; ++x) {
        const std::size_t i = span.list - row.list + static_cast<std::size_t>(x - span.begin);
        if (wanted[i] == 0) continue;
        const std::size_t at = line(y) + static_cast<std::size_t>(x);
        images_[slot][at] = packed(rgba + 4 * i);
        own_[at] = static_cast<std::uint8_t>(own_[at] | 1 << slot);
      }
    }
  }
}

}  // namespace floatstage::render::cpu
