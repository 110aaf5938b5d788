#include "tests/recon/csg_oracle.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/corefinement.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Polygon_mesh_processing/orientation.h>
#include <CGAL/Polygon_mesh_processing/triangulate_faces.h>
#include <CGAL/Surface_mesh.h>

namespace floatstage::recon {
namespace {

namespace pmp = CGAL::Polygon_mesh_processing;
using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Solid = CGAL::Surface_mesh<Kernel::Point_3>;

Kernel::Point_3 to_point(const Eigen::Vector3d& p) { return {p.x(), p.y(), p.z()}; }

Solid pyramid(const ConeView& view, std::size_t first, std::size_t last, double far) {
  Solid solid;
  const auto apex = solid.add_vertex(to_point(view.center));
  std::vector<Solid::Vertex_index> base;
  for (std::size_t k = first; k < last; ++k)
    base.push_back(solid.add_vertex(to_point(view.center + far * view.rays[k])));
  for (std::size_t k = 0; k < base.size(); ++k) solid.add_face(apex, base[(k + 1) % base.size()], base[k]);
  solid.add_face(base);
  pmp::triangulate_faces(solid);
  if (!pmp::is_outward_oriented(solid)) pmp::reverse_face_orientations(solid);
  return solid;
}

/// Twice the sum of the polygon's triangles as seen from the centre: positive for outlines, negative for
/// holes.
double turn(const ConeView& view, std::size_t first, std::size_t last) {
  Eigen::Vector3d area = Eigen::Vector3d::Zero(), middle = Eigen::Vector3d::Zero();
  for (std::size_t k = first; k < last; ++k) {
    area += view.rays[k].cross(view.rays[k + 1 == last ? first : k + 1]);
    middle += view.rays[k];
  }
  return area.dot(middle);
}

}  // namespace

double volume_by_csg(std::span<const ConeView> views, double far) {
  std::vector<Solid> outlines, holes;
  for (const ConeView& view : views) {
    for (std::size_t first = 0, last; first < view.rays.size(); first = last) {
      for (last = first; last < view.rays.size() && view.loop[last] == view.loop[first]; ++last) {
      }
      (turn(view, first, last) > 0 ? outlines : holes).push_back(pyramid(view, first, last, far));
    }
  }
  Solid hull = outlines.front();
  bool fine = true;
  for (std::size_t k = 1; k < outlines.size(); ++k)
    fine = pmp::corefine_and_compute_intersection(hull, outlines[k], hull) && fine;
  for (Solid& hole : holes) fine = pmp::corefine_and_compute_difference(hull, hole, hull) && fine;
  return fine ? CGAL::to_double(pmp::volume(hull)) : -1;
}

}  // namespace floatstage::recon
