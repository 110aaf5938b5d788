// Method:  short edges collapse, then a step inwards and a larger
//          one outwards smooth without shrinking
// Paper:   G. Taubin, "A signal processing approach to fair surface design", 1995
// Differs: vertices whose triangles pass through each other go back to where they were
// ADR:     0050

#include "recon/mesh/mesh_cleanup.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/check.h"
#include "recon/mesh/crossings.h"
#include "recon/mesh/half_edges.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

constexpr double kShortEdge = 0.2;  // voxels

HalfEdges to_half_edges(const Surface& surface) {
  HalfEdges mesh;
  mesh.reserve(surface.positions.size(), surface.triangles.size() * 3 / 2, surface.triangles.size());
  std::vector<OpenMesh::VertexHandle> v;
  v.reserve(surface.positions.size());
  for (const Vector3d& p : surface.positions) v.push_back(mesh.add_vertex(to_openmesh(p)));
  for (const auto& t : surface.triangles) {
    const bool added = mesh.add_face(v[t[0]], v[t[1]], v[t[2]]).is_valid();
    FLOATSTAGE_CHECK(added, "marching cubes made a triangle that no manifold has");
  }
  return mesh;
}

Surface from_half_edges(HalfEdges& mesh) {
  mesh.garbage_collection();
  Surface surface;
  surface.positions.reserve(mesh.n_vertices());
  for (OpenMesh::VertexHandle v : mesh.vertices()) surface.positions.push_back(place(mesh, v));
  surface.triangles.reserve(mesh.n_faces());
  for (OpenMesh::FaceHandle f : mesh.faces()) {
    std::array<std::uint32_t, 3> t;
    std::size_t i = 0;
    for (OpenMesh::VertexHandle v : mesh.fv_range(f)) t[i++] = static_cast<std::uint32_t>(v.idx());
    surface.triangles.push_back(t);
  }
  return surface;
}

// Would the triangles around the vertex that goes keep their direction and some height, and no vertex so few
// neighbours that a small shell could be pressed flat?
bool keeps_shape(const HalfEdges& mesh, OpenMesh::HalfedgeHandle h, double least_height) {
  for (const OpenMesh::HalfedgeHandle side : {h, mesh.opposite_halfedge_handle(h)})
    if (mesh.valence(mesh.to_vertex_handle(mesh.next_halfedge_handle(side))) <= 4) return false;
  const OpenMesh::VertexHandle gone = mesh.from_vertex_handle(h), stays = mesh.to_vertex_handle(h);
  for (HalfEdges::ConstVertexOHalfedgeIter it = mesh.cvoh_iter(gone); it.is_valid(); ++it) {
    if (mesh.is_boundary(*it)) return false;
    const OpenMesh::VertexHandle a = mesh.to_vertex_handle(*it);
    const OpenMesh::VertexHandle b = mesh.to_vertex_handle(mesh.next_halfedge_handle(*it));
    if (a == stays || b == stays) continue;
    const Vector3d side = place(mesh, b) - place(mesh, a);
    const Vector3d before = (place(mesh, a) - place(mesh, gone)).cross(place(mesh, b) - place(mesh, gone));
    const Vector3d after = (place(mesh, a) - place(mesh, stays)).cross(place(mesh, b) - place(mesh, stays));
    if (after.norm() < least_height * side.norm()) return false;
    if (after.dot(before) < 0.7 * after.norm() * before.norm()) return false;
  }
  return true;
}

void collapse_short_edges(HalfEdges& mesh, double shortest) {
  request_deletion(mesh);
  for (std::size_t i = 0; i < mesh.n_edges(); ++i) {
    const OpenMesh::EdgeHandle edge(static_cast<int>(i));
    if (mesh.status(edge).deleted()) continue;
    for (int side = 0; side < 2; ++side) {
      const OpenMesh::HalfedgeHandle h = mesh.halfedge_handle(edge, static_cast<unsigned>(side));
      if (mesh.calc_edge_length(h) >= shortest) break;
      if (!mesh.is_collapse_ok(h) || !keeps_shape(mesh, h, 0.1 * shortest)) continue;
      mesh.collapse(h);
      break;
    }
  }
}

// Each vertex towards (weight > 0) or away from the mean of its neighbours, but never far from where it
// began.
void smooth_step(HalfEdges& mesh, const std::vector<Vector3d>& start, double weight, double largest_move,
                 std::vector<Vector3d>& scratch) {
  scratch.resize(mesh.n_vertices());
  for (OpenMesh::VertexHandle v : mesh.vertices()) {
    Vector3d sum = Vector3d::Zero();
    int count = 0;
    for (HalfEdges::ConstVertexVertexIter it = mesh.cvv_iter(v); it.is_valid(); ++it, ++count)
      sum += place(mesh, *it);
    const std::size_t i = static_cast<std::size_t>(v.idx());
    Vector3d move = place(mesh, v) + weight * (sum / count - place(mesh, v)) - start[i];
    if (const double length = move.norm(); length > largest_move) move *= largest_move / length;
    scratch[i] = start[i] + move;
  }
  for (OpenMesh::VertexHandle v : mesh.vertices())
    mesh.set_point(v, to_openmesh(scratch[static_cast<std::size_t>(v.idx())]));
}

void smooth(HalfEdges& mesh, double largest_move) {
  constexpr int kRounds = 3;
  constexpr double kIn = 0.5, kOut = -0.53;  // Taubin's λ and μ: pass band 0.1
  std::vector<Vector3d> start, scratch;
  for (OpenMesh::VertexHandle v : mesh.vertices()) start.push_back(place(mesh, v));
  for (int round = 0; round < kRounds; ++round) {
    smooth_step(mesh, start, kIn, largest_move, scratch);
    smooth_step(mesh, start, kOut, largest_move, scratch);
  }
}

// Puts the vertices of crossing triangles back, to `start` and, if given, later to `safe`; true when nothing
// crosses any more.
bool undo_crossings(Surface& surface, const std::vector<Vector3d>& start, const std::vector<Vector3d>* safe,
                    int threads) {
  constexpr int kRounds = 4;
  for (int round = 0; round < (safe ? 3 * kRounds : kRounds); ++round) {
    const auto pairs = crossing_pairs(surface.positions, surface.triangles, 16, threads);
    if (pairs.empty()) return true;
    const std::vector<Vector3d>& places = round < kRounds ? start : *safe;
    for (const auto& [a, b] : pairs)
      for (std::uint32_t triangle : {a, b})
        for (std::uint32_t v : surface.triangles[triangle]) surface.positions[v] = places[v];
  }
  return crossing_pairs(surface.positions, surface.triangles, 1, threads).empty();
}

Surface rounded_to_float(Surface surface) {
  for (Vector3d& p : surface.positions) p = p.cast<float>().cast<double>();
  return surface;
}

std::optional<Surface> try_to_care(const Surface& raw, const CleanupOptions& options, bool collapse) {
  HalfEdges mesh = to_half_edges(raw);
  if (collapse) collapse_short_edges(mesh, kShortEdge * options.voxel);
  const Surface start = rounded_to_float(from_half_edges(mesh));
  Surface result = start;
  if (options.largest_move > 0) {
    smooth(mesh, options.largest_move * options.voxel);
    for (OpenMesh::VertexHandle v : mesh.vertices())
      result.positions[static_cast<std::size_t>(v.idx())] = place(mesh, v);
    result = rounded_to_float(std::move(result));
  }
  // Without collapsing, vertices are still those of `raw`, one for one.
  if (undo_crossings(result, start.positions, collapse ? nullptr : &raw.safe_positions, options.threads))
    return result;
  return std::nullopt;
}

}  // namespace

Surface clean_up(const Surface& raw, const CleanupOptions& options) {
  if (raw.triangles.empty()) return raw;
  for (const bool collapse : {true, false})
    if (std::optional<Surface> result = try_to_care(raw, options, collapse)) return std::move(*result);
  Surface safe = raw;
  safe.positions = raw.safe_positions;
  return rounded_to_float(std::move(safe));
}

}  // namespace floatstage::recon
