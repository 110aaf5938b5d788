#pragma once

#include <Eigen/Core>
#include <OpenMesh/Core/Geometry/VectorT.hh>
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>

namespace floatstage::recon {

struct HalfEdgeTraits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
/// A triangle mesh one can walk about on, in double precision. Stays inside recon/.
using HalfEdges = OpenMesh::TriMesh_ArrayKernelT<HalfEdgeTraits>;

inline Eigen::Vector3d to_eigen(const OpenMesh::Vec3d& p) { return {p[0], p[1], p[2]}; }

inline OpenMesh::Vec3d to_openmesh(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

inline Eigen::Vector3d place(const HalfEdges& mesh, OpenMesh::VertexHandle v) {
  return to_eigen(mesh.point(v));
}

/// What OpenMesh wants before anything is collapsed.
inline void request_deletion(HalfEdges& mesh) {
  mesh.request_vertex_status();
  mesh.request_edge_status();
  mesh.request_halfedge_status();
  mesh.request_face_status();
}

}  // namespace floatstage::recon
