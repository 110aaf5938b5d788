#include "render/cpu/raster.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace floatstage::render::cpu {
namespace {

constexpr int kGrid = 256;  // steps a pixel, as GPUs and llvmpipe have
constexpr float kFarOutside =
    1 << 14;                          // px: farther vertices are clipped, so that integers hold every product
constexpr std::size_t kChunk = 4096;  // vertices

/// The nearest integer, halves upwards; without a call where processors cannot round.
std::int32_t rounded(float v) {
  const float up = v + 0.5F;
  const auto cut = static_cast<std::int32_t>(up);
  return cut - (static_cast<float>(cut) > up ? 1 : 0);
}

}  // namespace

void ScreenMesh::begin(const Mesh& mesh, const RasterCamera& camera, bool closed) {
  mesh_ = &mesh;
  camera_ = camera;
  closed_ = closed;
  vertices_.resize(mesh.positions.size());
  to_clip_.assign(chunks(), 0);
}

std::size_t ScreenMesh::chunks() const { return (vertices_.size() + kChunk - 1) / kChunk; }

void ScreenMesh::project(std::size_t chunk) {
  const std::size_t end = std::min((chunk + 1) * kChunk, vertices_.size());
  const auto& m = camera_.rows;
  const float near_plane = camera_.near_plane, far_plane = camera_.far_plane;
  bool clipped = false;
  for (std::size_t i = chunk * kChunk; i < end; ++i) {
    const Eigen::Vector3f& p = mesh_->positions[i];
    const float x = m(0, 0) * p.x() + m(0, 1) * p.y() + m(0, 2) * p.z() + m(0, 3);
    const float y = m(1, 0) * p.x() + m(1, 1) * p.y() + m(1, 2) * p.z() + m(1, 3);
    const float z = m(2, 0) * p.x() + m(2, 1) * p.y() + m(2, 2) * p.z() + m(2, 3);
    const float inverse = 1 / z, u = x * inverse - 0.5F, v = y * inverse - 0.5F;
    const bool good =
        z >= near_plane && z <= far_plane && std::abs(u) < kFarOutside && std::abs(v) < kFarOutside;
    clipped |= !good;
    ScreenVertex& to = vertices_[i];
    to.x = good ? rounded(u * kGrid) : 0;
    to.y = good ? rounded(v * kGrid) : 0;
    to.inverse_z = good ? inverse : 0;
  }
  to_clip_[chunk] = clipped ? 1 : 0;
}

void ScreenMesh::draw(int first, int last, float* inverse_z, std::uint32_t* triangle) const {
  const auto begin = static_cast<std::size_t>(first) * static_cast<std::size_t>(camera_.width),
             end = static_cast<std::size_t>(last) * static_cast<std::size_t>(camera_.width);
  std::fill(inverse_z + begin, inverse_z + end, 0.F);
  const RasterRows to{camera_.width, first, last, inverse_z, triangle};
  walk([&](const ScreenVertex* vertices, const std::uint32_t* corners, std::uint32_t count,
           std::uint32_t index, bool cull) { draw_triangles(vertices, corners, count, index, cull, to); });
}

void ScreenMesh::cover(const CoverRows& to) const {
  walk([&](const ScreenVertex* vertices, const std::uint32_t* corners, std::uint32_t count, std::uint32_t,
           bool cull) { cover_triangles(vertices, corners, count, cull, to); });
}

template <class Draw>
void ScreenMesh::walk(const Draw& draw) const {
  const std::uint32_t* corner = mesh_->triangles.data();
  const auto count = static_cast<std::uint32_t>(mesh_->triangle_count());
  if (std::find(to_clip_.begin(), to_clip_.end(), 1) == to_clip_.end())
    return draw(vertices_.data(), corner, count, 0, closed_);
  auto beyond = [&](std::uint32_t i) { return vertices_[i].inverse_z == 0; };
  for (std::uint32_t t = 0; t < count; ++t, corner += 3) {
    if (beyond(corner[0]) || beyond(corner[1]) || beyond(corner[2]))
      walk_clipped(corner, t, draw);
    else
      draw(vertices_.data(), corner, 1, t, false);
  }
}

// Clips against the planes and a frame far outside of the picture, as a fan of what is left.
template <class Draw>
void ScreenMesh::walk_clipped(const std::uint32_t* corners, std::uint32_t index, const Draw& draw) const {
  std::array<Corner, 12> now, next;
  std::size_t count = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d p =
        camera_.rows.cast<double>() * mesh_->positions[corners[i]].cast<double>().homogeneous();
    now[i] = {p.x(), p.y(), p.z()};
  }
  const double reach = kFarOutside / 2;
  for (int plane = 0; plane < 6; ++plane) {
    auto inside = [&](const Corner& c) {
      switch (plane) {
        case 0:
          return c.z - static_cast<double>(camera_.near_plane);
        case 1:
          return static_cast<double>(camera_.far_plane) - c.z;
        case 2:
          return c.x + reach * c.z;
        case 3:
          return reach * c.z - c.x;
        case 4:
          return c.y + reach * c.z;
        default:
          return reach * c.z - c.y;
      }
    };
    std::size_t kept = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const Corner &here = now[i], &there = now[(i + 1) % count];
      const double in = inside(here), out = inside(there);
      if (in >= 0) next[kept++] = here;
      if ((in >= 0) != (out >= 0)) {
        const double s = in / (in - out);
        next[kept++] = {here.x + s * (there.x - here.x), here.y + s * (there.y - here.y),
                        here.z + s * (there.z - here.z)};
      }
    }
    count = kept;
    std::swap(now, next);
    if (count < 3) return;
  }
  auto vertex = [](const Corner& c) {
    return ScreenVertex{static_cast<std::int32_t>(std::floor((c.x / c.z - 0.5) * kGrid + 0.5)),
                        static_cast<std::int32_t>(std::floor((c.y / c.z - 0.5) * kGrid + 0.5)),
                        static_cast<float>(1 / c.z)};
  };
  const ScreenVertex hub = vertex(now[0]);
  constexpr std::uint32_t kOne[] = {0, 1, 2};
  for (std::size_t i = 1; i + 1 < count; ++i) {
    const ScreenVertex three[] = {hub, vertex(now[i]), vertex(now[i + 1])};
    draw(three, kOne, 1, index, false);
  }
}

}  // namespace floatstage::render::cpu
