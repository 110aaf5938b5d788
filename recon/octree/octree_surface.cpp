// Method:  marching cubes over a carved grid
// Paper:   W. E. Lorensen, H. E. Cline, "Marching cubes", 1987
// Differs: vertices lie where a grid edge leaves the hull, bisected against the mattes, not where grid
//          values interpolate
// ADR:     0051

#include "recon/octree/octree_surface.h"

#include <algorithm>
#include <bit>
#include <memory>

#include "core/parallel.h"
#include "recon/octree/octree_cases.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

struct CutEdge {
  int x, y, z, axis;  // lower end
};

// Calls visit(x) for every set bit.
template <class Visit>
void for_each_bit(std::uint64_t word, int first, Visit visit) {
  for (; word != 0; word &= word - 1) visit(first + std::countr_zero(word));
}

class Extractor {
 public:
  Extractor(const CarvedGrid& grid, std::span<const OctreeView> views, int threads)
      : grid_(grid), views_(views), threads_(threads), cases_(make_cube_cases()) {}

  Surface run() {
    const std::size_t layers = static_cast<std::size_t>(grid_.points().z());
    edges_.resize(layers);
    parallel_for(layers, threads_, [&](std::size_t z) { find_edges(static_cast<int>(z)); });
    first_vertex_.assign(layers + 1, 0);
    for (std::size_t z = 0; z < layers; ++z)
      first_vertex_[z + 1] = first_vertex_[z] + static_cast<std::uint32_t>(edges_[z].size());
    Surface surface;
    surface.positions.resize(first_vertex_.back());
    surface.safe_positions.resize(first_vertex_.back());
    std::vector<std::vector<std::array<std::uint32_t, 3>>> triangles(layers - 1);
    parallel_for(layers, threads_, [&](std::size_t z) {
      for (std::size_t i = 0; i < edges_[z].size(); ++i) {
        surface.positions[first_vertex_[z] + i] = crossing(edges_[z][i]);
        surface.safe_positions[first_vertex_[z] + i] = middle(edges_[z][i]);
      }
      if (z + 1 < layers) triangles[z] = triangulate_slab(static_cast<int>(z));
    });
    for (const auto& slab : triangles)
      surface.triangles.insert(surface.triangles.end(), slab.begin(), slab.end());
    return surface;
  }

 private:
  // Bit x: points x and x + 1 of the row differ.
  std::uint64_t changes_along(const std::uint64_t* row, std::size_t word) const {
    const std::uint64_t next = word + 1 < grid_.words_per_row() ? row[word + 1] : 0;
    return row[word] ^ (row[word] >> 1 | next << 63);
  }

  void find_edges(int z) {
    std::vector<CutEdge>& found = edges_[static_cast<std::size_t>(z)];
    const Vector3i n = grid_.points();
    for (int y = 0; y < n.y(); ++y) {
      const std::uint64_t* row = grid_.row(y, z);
      const std::uint64_t* next_y = y + 1 < n.y() ? grid_.row(y + 1, z) : nullptr;
      const std::uint64_t* next_z = z + 1 < n.z() ? grid_.row(y, z + 1) : nullptr;
      for (std::size_t w = 0; w < grid_.words_per_row(); ++w) {
        const int x0 = static_cast<int>(w) * 64;
        for_each_bit(changes_along(row, w), x0, [&](int x) { found.push_back({x, y, z, 0}); });
        if (next_y) for_each_bit(row[w] ^ next_y[w], x0, [&](int x) { found.push_back({x, y, z, 1}); });
        if (next_z) for_each_bit(row[w] ^ next_z[w], x0, [&](int x) { found.push_back({x, y, z, 2}); });
      }
    }
  }

  Vector3d middle(const CutEdge& e) const {
    return grid_.position(e.x, e.y, e.z) + grid_.voxel() / 2 * Vector3d::Unit(e.axis);
  }

  Vector3d crossing(const CutEdge& e) const {
    Vector3d outside = grid_.position(e.x, e.y, e.z);
    Vector3d inside = outside;
    inside[e.axis] += grid_.voxel();
    if (grid_.inside(e.x, e.y, e.z)) std::swap(inside, outside);
    // Only the cameras that see background somewhere on the edge can end the hull there.
    std::array<std::uint32_t, 8> askable;
    std::size_t asked = 0;
    const Eigen::AlignedBox3d box(inside.cwiseMin(outside), inside.cwiseMax(outside));
    for (std::size_t i = 0; i < views_.size() && asked <= askable.size(); ++i) {
      const BoxVerdict verdict = views_[i].over(box);
      if (verdict != BoxVerdict::Mixed && verdict != BoxVerdict::Background) continue;
      if (asked < askable.size()) askable[asked] = static_cast<std::uint32_t>(i);
      ++asked;
    }
    // When the far end is outside only because no camera sees it, or too many have a say, everybody is asked.
    const bool ask_all = asked == 0 || asked > askable.size() || !carved(askable, asked, outside);
    double lo = 0, hi = 1;  // inside … outside
    constexpr int kHalvings = 10;
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = (lo + hi) / 2;
      const Vector3d p = inside + middle * (outside - inside);
      const bool in = grid_.box().contains(p) && (ask_all ? in_hull(views_, p) : !carved(askable, asked, p));
      (in ? lo : hi) = middle;
    }
    constexpr double kClearance = 0.02;  // voxels
    return inside + std::clamp((lo + hi) / 2, kClearance, 1 - kClearance) * (outside - inside);
  }

  bool carved(const std::array<std::uint32_t, 8>& askable, std::size_t count, const Vector3d& p) const {
    for (std::size_t i = 0; i < std::min(count, askable.size()); ++i)
      if (views_[askable[i]].at(p) == PointVerdict::Background) return true;
    return false;
  }

  // Vertex numbers of the cut edges of layers z and z + 1, by position; what is not cut is never read.
  class VertexNumbers {
   public:
    VertexNumbers(const Vector3i& n, int z0)
        : nx_(static_cast<std::size_t>(n.x())),
          ny_(static_cast<std::size_t>(n.y())),
          z0_(z0),
          numbers_(std::make_unique_for_overwrite<std::uint32_t[]>(2 * 3 * nx_ * ny_)) {}
    std::uint32_t& at(int x, int y, int z, int axis) {
      const std::size_t plane = static_cast<std::size_t>((z - z0_) * 3 + axis);
      return numbers_[(plane * ny_ + static_cast<std::size_t>(y)) * nx_ + static_cast<std::size_t>(x)];
    }

   private:
    std::size_t nx_, ny_;
    int z0_;
    std::unique_ptr<std::uint32_t[]> numbers_;
  };

  std::vector<std::array<std::uint32_t, 3>> triangulate_slab(int z) const {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    VertexNumbers numbers(grid_.points(), z);
    for (int layer = z; layer <= z + 1; ++layer) {
      std::uint32_t number = first_vertex_[static_cast<std::size_t>(layer)];
      for (const CutEdge& e : edges_[static_cast<std::size_t>(layer)])
        numbers.at(e.x, e.y, e.z, e.axis) = number++;
    }
    for (int y = 0; y + 1 < grid_.points().y(); ++y) {
      const std::array<const std::uint64_t*, 4> rows = {grid_.row(y, z), grid_.row(y + 1, z),
                                                        grid_.row(y, z + 1), grid_.row(y + 1, z + 1)};
      for (std::size_t w = 0; w < grid_.words_per_row(); ++w) {
        std::uint64_t cells =
            (rows[0][w] ^ rows[1][w]) | (rows[0][w] ^ rows[2][w]) | (rows[0][w] ^ rows[3][w]);
        const std::uint64_t carry = w + 1 < grid_.words_per_row() ? next_differs(rows, w + 1) << 63 : 0;
        cells |= cells >> 1 | carry;
        for (const std::uint64_t* row : rows) cells |= changes_along(row, w);
        for_each_bit(cells, static_cast<int>(w) * 64,
                     [&](int x) { triangulate_cell(x, y, z, numbers, triangles); });
      }
    }
    return triangles;
  }

  static std::uint64_t next_differs(const std::array<const std::uint64_t*, 4>& rows, std::size_t w) {
    return ((rows[0][w] ^ rows[1][w]) | (rows[0][w] ^ rows[2][w]) | (rows[0][w] ^ rows[3][w])) & 1;
  }

  void triangulate_cell(int x, int y, int z, VertexNumbers& numbers,
                        std::vector<std::array<std::uint32_t, 3>>& triangles) const {
    unsigned inside = 0;
    for (int corner = 0; corner < 8; ++corner)
      inside |=
          static_cast<unsigned>(grid_.inside(x + (corner & 1), y + ((corner >> 1) & 1), z + (corner >> 2)))
          << corner;
    for (const auto& triangle : cases_[inside]) {
      std::array<std::uint32_t, 3> t;
      for (std::size_t i = 0; i < 3; ++i) {
        const CubeEdge e = cube_edge(triangle[i]);
        t[i] = numbers.at(x + e.from[0], y + e.from[1], z + e.from[2], e.axis);
      }
      triangles.push_back(t);
    }
  }

  const CarvedGrid& grid_;
  std::span<const OctreeView> views_;
  int threads_;
  CubeCases cases_;
  std::vector<std::vector<CutEdge>>
      edges_;  // of the layer of their lower end, in the order of y, word, axis, x
  std::vector<std::uint32_t> first_vertex_;
};

}  // namespace

Surface extract_surface(const CarvedGrid& grid, std::span<const OctreeView> views, int threads) {
  return Extractor(grid, views, threads).run();
}

}  // namespace floatstage::recon
