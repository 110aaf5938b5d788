#include "recon/mesh/mesh_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "core/text.h"
#include "recon/mesh/crossings.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;
using Triangle = std::array<std::uint32_t, 3>;

struct Edge {
  std::uint32_t low, high;
  bool rising;  // the triangle runs it from low to high
  bool operator<(const Edge& o) const { return low != o.low ? low < o.low : high < o.high; }
};

std::vector<Edge> sorted_edges(std::span<const Triangle> triangles) {
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = t[i], b = t[(i + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  std::sort(edges.begin(), edges.end());
  return edges;
}

void check_edges(std::span<const Triangle> triangles, MeshCheck& result) {
  const std::vector<Edge> edges = sorted_edges(triangles);
  result.watertight = result.oriented = true;
  for (std::size_t first = 0, last; first < edges.size(); first = last) {
    int rising = 0;
    for (last = first; last < edges.size() && !(edges[first] < edges[last]); ++last)
      rising += edges[last].rising;
    const int count = static_cast<int>(last - first);
    if (count != 2 || edges[first].low == edges[first].high) result.watertight = false;
    if (rising > 1 || count - rising > 1) result.oriented = false;
  }
}

// The links of all vertices: one entry a corner, from the next vertex of its triangle to the one after.
bool every_vertex_has_one_fan(std::span<const Triangle> triangles) {
  struct Link {
    std::uint32_t vertex, a, b;
  };
  std::vector<Link> links;
  links.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    for (std::size_t i = 0; i < 3; ++i) links.push_back({t[i], t[(i + 1) % 3], t[(i + 2) % 3]});
  std::sort(links.begin(), links.end(), [](const Link& x, const Link& y) {
    return std::array{x.vertex, x.a, x.b} < std::array{y.vertex, y.a, y.b};
  });
  std::vector<char> visited;
  for (std::size_t first = 0, last; first < links.size(); first = last) {
    for (last = first; last < links.size() && links[last].vertex == links[first].vertex;) ++last;
    // Walk from triangle to triangle around the vertex, whichever way each one faces.
    const std::size_t count = last - first;
    visited.assign(count, 0);
    std::size_t seen = 1;
    std::uint32_t front = links[first].b;
    visited[0] = 1;
    for (bool moved = true; moved;) {
      moved = false;
      for (std::size_t i = 0; i < count && !moved; ++i) {
        const Link& l = links[first + i];
        if (visited[i] || (l.a != front && l.b != front)) continue;
        front = l.a == front ? l.b : l.a;
        visited[i] = 1;
        ++seen;
        moved = true;
      }
    }
    if (seen != count || front != links[first].a) return false;
  }
  return true;
}

class Shells {
 public:
  Shells(std::span<const Vector3d> positions, std::span<const Triangle> triangles)
      : positions_(positions), triangles_(triangles), parent_(positions.size()) {
    std::iota(parent_.begin(), parent_.end(), 0u);
    const Eigen::Matrix3d slant =
        (Eigen::AngleAxisd(0.7391, Vector3d::UnitX()) * Eigen::AngleAxisd(0.5772, Vector3d::UnitY()))
            .toRotationMatrix();
    slanted_.reserve(positions.size());
    for (const Vector3d& p : positions) slanted_.push_back(slant * p);
    for (const Triangle& t : triangles) {
      join(t[0], t[1]);
      join(t[0], t[2]);
    }
    std::vector<int> number(positions.size(), -1);
    for (std::size_t i = 0; i < triangles.size(); ++i) {
      int& n = number[root(triangles[i][0])];
      if (n < 0) {
        n = static_cast<int>(members_.size());
        members_.emplace_back();
      }
      members_[static_cast<std::size_t>(n)].push_back(static_cast<std::uint32_t>(i));
    }
    for (const auto& members : members_) {
      double volume = 0;
      Eigen::AlignedBox3d box;
      for (std::uint32_t i : members) {
        const Triangle& t = triangles_[i];
        const Vector3d origin = positions_[triangles_[members.front()][0]];
        volume +=
            (positions_[t[0]] - origin).dot((positions_[t[1]] - origin).cross(positions_[t[2]] - origin)) / 6;
        for (std::uint32_t v : t) box.extend(positions_[v]);
      }
      volumes_.push_back(volume);
      boxes_.push_back(box);
    }
  }

  std::size_t count() const { return members_.size(); }

  bool all_outward() const {
    for (std::size_t i = 0; i < count(); ++i) {
      const std::uint32_t probe = triangles_[members_[i].front()][0];
      bool cavity = false;
      for (std::size_t j = 0; j < count(); ++j)
        if (j != i && boxes_[j].contains(boxes_[i]) && encloses(members_[j], probe)) cavity = !cavity;
      if (cavity ? volumes_[i] >= 0 : volumes_[i] <= 0) return false;
    }
    return true;
  }

 private:
  std::uint32_t root(std::uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[root(a)] = root(b); }

  // Signed crossings of a ray with the shell. The ray runs along z of a slanted frame, in which the vertices
  // of grids and boxes do not line up, so it does not meet an edge head on; and edge(a, b) == -edge(b, a) bit
  // by bit, so a ray beside an edge is claimed by exactly one of its two triangles.
  bool encloses(const std::vector<std::uint32_t>& members, std::uint32_t vertex) const {
    int crossings = 0;
    const Vector3d& p = slanted_[vertex];
    const auto edge = [](const Vector3d& a, const Vector3d& b) { return a.x() * b.y() - a.y() * b.x(); };
    for (std::uint32_t i : members) {
      const Vector3d a = slanted_[triangles_[i][0]] - p, b = slanted_[triangles_[i][1]] - p,
                     c = slanted_[triangles_[i][2]] - p;
      if ((a.x() > 0 && b.x() > 0 && c.x() > 0) || (a.x() < 0 && b.x() < 0 && c.x() < 0)) continue;
      const double ab = edge(a, b), bc = edge(b, c), ca = edge(c, a);
      const bool positive = ab > 0 && bc > 0 && ca > 0, negative = ab < 0 && bc < 0 && ca < 0;
      if (!positive && !negative) continue;
      if ((bc * a.z() + ca * b.z() + ab * c.z()) / (ab + bc + ca) > 0) crossings += positive ? 1 : -1;
    }
    return crossings != 0;
  }

  std::span<const Vector3d> positions_;
  std::span<const Triangle> triangles_;
  std::vector<Vector3d> slanted_;
  std::vector<std::uint32_t> parent_;
  std::vector<std::vector<std::uint32_t>> members_;
  std::vector<double> volumes_;
  std::vector<Eigen::AlignedBox3d> boxes_;
};

bool has_area(std::span<const Vector3d> positions, const Triangle& t) {
  const Vector3d u = positions[t[1]] - positions[t[0]], v = positions[t[2]] - positions[t[0]];
  // Less than this much of a right angle's area is rounding.
  return u.cross(v).norm() > 1e-12 * std::max(u.squaredNorm(), v.squaredNorm());
}

int count_vertices_in_use(std::span<const Triangle> triangles, std::size_t positions) {
  std::vector<char> used(positions, 0);
  for (const Triangle& t : triangles)
    for (std::uint32_t v : t) used[v] = 1;
  return static_cast<int>(std::count(used.begin(), used.end(), 1));
}

}  // namespace

std::string MeshCheck::summary() const {
  std::string faults;
  auto add = [&](bool fault, const char* words) {
    if (fault) faults += faults.empty() ? words : std::string(", ") + words;
  };
  add(!watertight, "not watertight");
  add(watertight && !manifold, "not manifold");
  add(!oriented, "not consistently oriented");
  add(oriented && !outward, "facing inwards");
  add(self_intersecting, "crossing itself");
  if (faults.empty()) faults = "closed, manifold and outward";
  return text(shells, shells == 1 ? " shell" : " shells", " of genus ", genus, ", ", faults, ", ", degenerate,
              " triangles without area, ", volume, " m³");
}

MeshCheck check_mesh(const Mesh& mesh) {
  MeshCheck result;
  std::vector<Vector3d> positions;
  positions.reserve(mesh.positions.size());
  for (const Eigen::Vector3f& p : mesh.positions) positions.push_back(p.cast<double>());
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i + 2 < mesh.triangles.size(); i += 3) {
    triangles.push_back({mesh.triangles[i], mesh.triangles[i + 1], mesh.triangles[i + 2]});
    for (std::uint32_t v : triangles.back())
      if (v >= positions.size()) return result;
  }
  if (mesh.triangles.size() % 3 != 0) return result;

  check_edges(triangles, result);
  result.manifold = result.watertight && every_vertex_has_one_fan(triangles);
  const Shells shells(positions, triangles);
  result.shells = static_cast<int>(shells.count());
  for (const Triangle& t : triangles) result.degenerate += !has_area(positions, t);
  if (result.manifold) {
    // Euler: V - E + F = 2 (shells - genus), and E = 3/2 F.
    const int euler =
        count_vertices_in_use(triangles, positions.size()) - static_cast<int>(triangles.size() / 2);
    result.genus = result.shells - euler / 2;
  }
  result.outward = result.watertight && result.oriented && shells.all_outward();
  result.self_intersecting = !crossing_pairs(positions, triangles, 1, 0).empty();
  result.volume = signed_volume(mesh);
  return result;
}

}  // namespace floatstage::recon
