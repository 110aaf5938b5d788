#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/mesh.h"
#include "core/random.h"
#include "recon/exact/exact_hull.h"
#include "recon/mesh/mesh_check.h"

namespace floatstage::recon {

/// Silhouettes as exact cones, without pixels: what the engine's tests are made of.
namespace cones {

/// The convex silhouette of points as seen from `center`: exact, corners are the points themselves.
ConeView of_convex(const Eigen::Vector3d& center, const std::vector<Eigen::Vector3d>& points);
/// The silhouette of a sphere around the origin, a regular polygon of `sides` inscribed in the cone's circle.
ConeView of_sphere(const Eigen::Vector3d& center, double radius, int sides, double turn = 0);
/// A polygon given in the plane through the origin that faces the camera: (right, up) coordinates, metres,
/// running counter-clockwise as the camera sees it for an outline, clockwise for a hole.
void add_polygon(ConeView& view, const std::vector<Eigen::Vector2d>& polygon);
ConeView at(const Eigen::Vector3d& center);

std::vector<Eigen::Vector3d> cube_corners(double half);
std::vector<Eigen::Vector3d> octahedron_corners(double radius);
/// Centres on a circle around the z axis, at height z, the first at `phase` radians.
std::vector<Eigen::Vector3d> ring(int count, double distance, double z, double phase = 0);
/// Centres spread over a sphere (a Fibonacci spiral).
std::vector<Eigen::Vector3d> around(int count, double distance);

/// Stars, combs and rings with holes: `spikes` concave corners, drawn from `random`.
std::vector<ConeView> random_stars(Random& random, const std::vector<Eigen::Vector3d>& centers, int spikes,
                                   bool holes);

}  // namespace cones

Mesh to_mesh(const HullPolygons& polygons);

}  // namespace floatstage::recon
