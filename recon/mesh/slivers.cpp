// Method:  needles lose their short edge, caps their blunt
//          corner or their long edge
// Paper:   none: edge collapses and flips, greedily, each leaving fewer slivers
// Differs: bounded in the cameras' pixels
// ADR:     0078

#include "recon/mesh/slivers.h"

#include <algorithm>
#include <array>

#include <Eigen/Geometry>

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;
using OpenMesh::EdgeHandle;
using OpenMesh::FaceHandle;
using OpenMesh::HalfedgeHandle;
using OpenMesh::VertexHandle;

constexpr double kLargestTurn = 0.3;  // cosine between a triangle's normal before and after

Vector3d area_vector(const Vector3d& a, const Vector3d& b, const Vector3d& c) { return (b - a).cross(c - a); }

bool keeps_side(const Vector3d& area, const Vector3d& normal) {
  return area.dot(normal) >= kLargestTurn * area.norm() * normal.norm();
}

std::array<HalfedgeHandle, 3> sides(const HalfEdges& mesh, FaceHandle face) {
  const HalfedgeHandle h = mesh.halfedge_handle(face);
  return {h, mesh.next_halfedge_handle(h), mesh.prev_halfedge_handle(h)};
}

bool collapse(HalfEdges& mesh, HalfedgeHandle h, FaceNormals normals, ReprojectionBound& bound) {
  const VertexHandle gone = mesh.from_vertex_handle(h), stays = mesh.to_vertex_handle(h);
  const std::size_t from = static_cast<std::size_t>(gone.idx()), to = static_cast<std::size_t>(stays.idx());
  if (!may_collapse(mesh, h, normals, true) || !bound.allows(from, place(mesh, stays))) return false;
  bound.merge(from, to);
  mesh.collapse(h);
  return true;
}

// The long side of a cap becomes the other diagonal of the two triangles at it: the surface moves by less
// than the cap's height.
bool flip(HalfEdges& mesh, HalfedgeHandle h, FaceNormals normals, const ReprojectionBound& bound) {
  const EdgeHandle edge = mesh.edge_handle(h);
  if (!mesh.is_flip_ok(edge)) return false;
  const HalfedgeHandle back = mesh.opposite_halfedge_handle(h);
  const VertexHandle p = mesh.from_vertex_handle(h), q = mesh.to_vertex_handle(h);
  const VertexHandle a = mesh.to_vertex_handle(mesh.next_halfedge_handle(h));
  const VertexHandle d = mesh.to_vertex_handle(mesh.next_halfedge_handle(back));
  if (mesh.valence(p) <= 3 || mesh.valence(q) <= 3) return false;
  const Vector3d at_p = place(mesh, p), at_q = place(mesh, q), at_a = place(mesh, a), at_d = place(mesh, d);
  const FaceHandle other = mesh.face_handle(back);
  const int before = 1 + is_sliver(mesh, other);
  const int after = is_sliver(at_a, at_p, at_d) + is_sliver(at_d, at_q, at_a);
  const Vector3d normal = to_eigen(mesh.property(normals, other));
  if (after >= before || !keeps_side(area_vector(at_a, at_p, at_d), normal) ||
      !keeps_side(area_vector(at_d, at_q, at_a), normal) || bound.distance(at_a, at_p, at_q) > bound.limit())
    return false;
  mesh.flip(edge);
  mesh.property(normals, mesh.face_handle(h)) = to_openmesh(normal);
  return true;
}

bool remove_sliver(HalfEdges& mesh, FaceHandle face, FaceNormals normals, ReprojectionBound& bound) {
  std::array<HalfedgeHandle, 3> by_length = sides(mesh, face);
  std::stable_sort(by_length.begin(), by_length.end(), [&](HalfedgeHandle a, HalfedgeHandle b) {
    return mesh.calc_edge_sqr_length(a) < mesh.calc_edge_sqr_length(b);
  });
  // The two shorter sides meet in the blunt corner of a cap; a needle's is its shortest.
  for (std::size_t k = 0; k < 2; ++k) {
    for (const HalfedgeHandle h : {by_length[k], mesh.opposite_halfedge_handle(by_length[k])})
      if (collapse(mesh, h, normals, bound)) return true;
  }
  return flip(mesh, by_length[2], normals, bound);
}

}  // namespace

bool is_sliver(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double longest2 = std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
  return area_vector(a, b, c).norm() * kSliver < longest2;
}

bool is_sliver(const HalfEdges& mesh, FaceHandle face) {
  const auto [a, b, c] = sides(mesh, face);
  return is_sliver(place(mesh, mesh.to_vertex_handle(a)), place(mesh, mesh.to_vertex_handle(b)),
                   place(mesh, mesh.to_vertex_handle(c)));
}

std::size_t count_slivers(const HalfEdges& mesh) {
  std::size_t count = 0;
  for (const FaceHandle face : mesh.all_faces())
    if (!(mesh.has_face_status() && mesh.status(face).deleted())) count += is_sliver(mesh, face);
  return count;
}

bool may_collapse(HalfEdges& mesh, HalfedgeHandle h, FaceNormals normals, bool fewer, bool thin) {
  // A corner with three neighbours would be left with two: that is a shell pressed flat.
  for (const HalfedgeHandle side : {h, mesh.opposite_halfedge_handle(h)})
    if (mesh.valence(mesh.to_vertex_handle(mesh.next_halfedge_handle(side))) <= 3) return false;
  const VertexHandle gone = mesh.from_vertex_handle(h), stays = mesh.to_vertex_handle(h);
  const Vector3d from = place(mesh, gone), to = place(mesh, stays);
  int before = 0, after = 0;
  for (HalfEdges::ConstVertexOHalfedgeIter it = mesh.cvoh_iter(gone); it.is_valid(); ++it) {
    if (mesh.is_boundary(*it)) return false;
    const VertexHandle a = mesh.to_vertex_handle(*it),
                       b = mesh.to_vertex_handle(mesh.next_halfedge_handle(*it));
    const Vector3d at_a = place(mesh, a), at_b = place(mesh, b);
    const bool was = is_sliver(from, at_a, at_b);
    before += was;
    if (a == stays || b == stays) continue;
    const Vector3d area = area_vector(to, at_a, at_b);
    const bool will_be = is_sliver(to, at_a, at_b);
    if (will_be && !was && !thin) return false;
    after += will_be;
    const Vector3d normal =
        was ? to_eigen(mesh.property(normals, mesh.face_handle(*it))) : area_vector(from, at_a, at_b);
    if (!will_be && !keeps_side(area, normal)) return false;
  }
  return (!fewer || after < before) && mesh.is_collapse_ok(h);
}

void remove_slivers(HalfEdges& mesh, FaceNormals normals, ReprojectionBound& bound) {
  constexpr int kRounds = 8;
  for (int round = 0, removed = 1; round < kRounds && removed > 0; ++round) {
    removed = 0;
    for (std::size_t f = 0; f < mesh.n_faces(); ++f) {
      const FaceHandle face(static_cast<int>(f));
      if (!mesh.status(face).deleted() && is_sliver(mesh, face))
        removed += remove_sliver(mesh, face, normals, bound);
    }
  }
}

}  // namespace floatstage::recon
