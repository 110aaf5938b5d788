#include "recon/mesh/simplify.h"

#include <Eigen/Geometry>

#include "core/text.h"
#include "recon/mesh/decimate.h"

namespace floatstage::recon {

using OpenMesh::FaceHandle;
using OpenMesh::VertexHandle;

Result<Mesh> simplified(const Mesh& mesh, int triangles) {
  if (triangles < 1) return fail(ErrorCode::InvalidArgument, text("a mesh of ", triangles, " triangles"));
  const auto budget = static_cast<std::size_t>(triangles);
  if (mesh.triangle_count() <= budget) return mesh;
  HalfEdges edges;
  FaceNormals normals;
  edges.add_property(normals);
  for (const Eigen::Vector3f& p : mesh.positions) edges.add_vertex(to_openmesh(p.cast<double>()));
  for (std::size_t t = 0; t < mesh.triangle_count(); ++t) {
    const std::uint32_t* corner = mesh.triangles.data() + 3 * t;
    const auto vertex = [&](std::size_t k) { return VertexHandle(static_cast<int>(corner[k])); };
    const FaceHandle face = edges.add_face(vertex(0), vertex(1), vertex(2));
    if (!face.is_valid())
      return fail(
          ErrorCode::BadData,
          text("triangle ", t, " of the mesh is the third at an edge; such a mesh has no neighbours"));
    const auto at = [&](std::size_t k) { return place(edges, vertex(k)); };
    const Eigen::Vector3d normal = (at(1) - at(0)).cross(at(2) - at(0)).stableNormalized();
    edges.property(normals, face) = to_openmesh(normal);
  }
  request_deletion(edges);
  decimate(edges, normals, budget);
  edges.garbage_collection();
  Mesh out;
  for (const VertexHandle v : edges.all_vertices()) out.positions.push_back(place(edges, v).cast<float>());
  for (const FaceHandle f : edges.all_faces())
    for (const VertexHandle v : edges.fv_range(f))
      out.triangles.push_back(static_cast<std::uint32_t>(v.idx()));
  return out;
}

}  // namespace floatstage::recon
