#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/camera.h"
#include "core/matte.h"
#include "core/silhouette.h"
#include "recon/outline.h"
#include "recon/silhouette_grid.h"

namespace floatstage::recon {

/// How much a lens bends straight lines: the largest second difference over the picture, px per px². 0
/// without a lens. Depends on the calibration only: found once, used for every frame.
double lens_bend(const CameraModel& model);

/// What tells_sides() works in: of each polygon of an outline.
struct PolygonBounds {
  std::vector<Eigen::AlignedBox2d> boxes;
  std::vector<double> areas;  ///< px²; holes count negative
};

/// Memory for one outline at a time, kept from frame to frame.
struct SilhouetteScratch {
  std::vector<std::uint64_t> bits, visited;
  Silhouette traced, given, kept, bent;
  PolygonBounds polygons;
  EdgeGrid grid, moved_grid;
  std::vector<char> keep, back;
  std::vector<int> origin, previous, conflicts;
  std::vector<std::pair<int, int>> stack;
  std::vector<double> offsets;
  std::vector<Eigen::Vector2d> moved;
};

/// Every point of the iso-line alpha = 127.5 (marching squares: one point for each pixel edge between subject
/// and background, on the line between the two pixel centres), still in the picture's distorted pixels.
/// Foreground pixels connect over their sides only, background over corners too, so polygons are simple and
/// disjoint by construction. At the border of the picture the point lies on the border.
void trace_outline(const Matte& matte, bool unknown_beyond, SilhouetteScratch& scratch, Silhouette& out);

/// Douglas-Peucker that keeps the topology, then fit_outline(): no two edges of the result come nearer than a
/// hundredth of a pixel, and no chord jumps over a point of another polygon. `longest` (px) limits the length
/// of a chord (0: no limit).
void simplify_outline(const Silhouette& outline, double tolerance, double longest, SilhouetteScratch& scratch,
                      Silhouette& out);
Silhouette simplify_outline(const Silhouette& outline, double tolerance, double longest = 0);

/// Moves the chords of `simple` (the points `origin` of `full`, ascending) sideways so that each cuts off as
/// much of the outline as it adds: chords of a round outline lie inside it, and hulls of them would be too
/// small. No corner moves more than `most` px, and none that would change the topology.
void fit_outline(const Silhouette& full, const Silhouette& simple, std::span<const int> origin, double most,
                 SilhouetteScratch& scratch, Silhouette& out);

/// Leaves out the polygons that enclose less than `smallest` px².
void drop_specks(double smallest, Silhouette& outline);

/// Two edges of an outline that are not neighbours stay this far apart, px.
inline constexpr double kOutlineGap = 0.01;

/// True when no two edges that are not neighbours touch.
bool is_simple(const Silhouette& outline);

/// True when subject is right of all edges: outer polygons and holes, and beyond_counts, fit into each other.
/// For outlines that are simple.
bool tells_sides(const Silhouette& outline, PolygonBounds& memory);

/// All of the above, then the lens removed from the points: the outline as the ideal pinhole camera would see
/// it, with simplicity checked again. Points that the lens cannot undo are dropped. `bend` is
/// lens_bend(model). A matte of noise is made coarser, up to an empty outline, until options.most_points are
/// enough; that bounds the time of a frame.
OutlineDetail undistorted_outline(const Matte& matte, const CameraModel& model, double bend,
                                  const SilhouetteOptions& options, SilhouetteScratch& scratch,
                                  Silhouette& out);

/// The same for an outline that was made elsewhere (outline_of()), possibly not quite simple any more. With a
/// tolerance of 0 it keeps its points.
OutlineDetail undistorted_outline(const Silhouette& outline, const CameraModel& model, double bend,
                                  const SilhouetteOptions& options, SilhouetteScratch& scratch,
                                  Silhouette& out);

/// Shoelace area of all polygons, px²; holes count negative.
double enclosed_area(const Silhouette& outline);

}  // namespace floatstage::recon
