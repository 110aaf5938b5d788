#pragma once

#include <cstddef>

#include <Eigen/Core>

#include "recon/mesh/half_edges.h"
#include "recon/mesh/reprojection_bound.h"

namespace floatstage::recon {

/// A triangle whose longest side is this many times its height over that side is a sliver: an angle of about
/// one degree. Exact hulls are full of them: wherever two contour points of two cameras nearly meet.
inline constexpr double kSliver = 50;

bool is_sliver(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);
bool is_sliver(const HalfEdges& mesh, OpenMesh::FaceHandle face);
std::size_t count_slivers(const HalfEdges& mesh);

/// A face's true normal (unit length), known from elsewhere than its corners: slivers have none of their own.
using FaceNormals = OpenMesh::FPropHandleT<OpenMesh::Vec3d>;

/// Would collapsing the half-edge (its start goes to its end) leave a manifold whose triangles neither fold
/// over nor become slivers? `fewer`: and with fewer slivers than before? `thin`: new slivers are welcome.
bool may_collapse(HalfEdges& mesh, OpenMesh::HalfedgeHandle h, FaceNormals normals, bool fewer,
                  bool thin = false);

/// Removes slivers: needles by collapsing their short edge, caps by collapsing their blunt corner into a
/// neighbour or by flipping their long edge, wherever `bound` allows it. Every step leaves fewer than before.
/// Collapsed elements are marked, not yet swept up. Deterministic.
void remove_slivers(HalfEdges& mesh, FaceNormals normals, ReprojectionBound& bound);

}  // namespace floatstage::recon
