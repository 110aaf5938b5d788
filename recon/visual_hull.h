#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "core/matte.h"
#include "core/mesh.h"
#include "core/result.h"
#include "core/rig.h"
#include "core/silhouette.h"

namespace floatstage::recon {

enum class HullMethod {
  Exact,   ///< the polyhedron of the silhouettes' polygons, exactly (docs/algorithms/visual-hull.md): fast,
           ///< sharp
  Octree,  ///< carving of an octree and an iso-surface: slow, soft, sturdy; the reference
};

/// Which cameras have to agree that a point is inside (exact method).
enum class HullVoting {
  Strict,  ///< all of them
  MofN,    ///< HullOptions::votes of them
  Auto,    ///< all of them; but where a matte lacks what the others agree on, it is overruled, and named in
           ///< the report
};

/// What is done to a finished hull on request, in this order. It leaves the silhouettes' polyhedron, by
/// amounts that MeshCleanupReport states; the mesh stays closed, manifold and oriented, with its shells and
/// handles.
struct MeshCleanup {
  /// Needles and caps (kSliver in recon/mesh/slivers.h) go, where no vertex of the hull has to move by more
  /// than largest_move for it.
  bool collapse_slivers = false;
  int triangles = 0;  ///< budget: the least important edges are collapsed until so few are left; 0: none
  int smooth = 0;  ///< rounds of smoothing that does not shrink it or round ridges off, within largest_move
  double largest_move = 0.5;  ///< px: how far from where it was any vertex may be seen, in any view
  /// Of any view's silhouette IoU, by smoothing; it is held back until this holds.
  double largest_loss = 0.002;
  bool wanted() const { return collapse_slivers || smooth > 0 || triangles > 0; }
  bool operator==(const MeshCleanup&) const = default;
};

struct HullOptions {
  HullMethod method = HullMethod::Exact;
  /// World box to search, metres; the hull is cut off at its sides. Absent: the box of the intersection of
  /// all silhouettes' bounding pyramids, shrunk to what the silhouettes leave of it.
  std::optional<Eigen::AlignedBox3d> volume = {};
  /// Exact: px by which the polygons may leave the silhouettes' iso-lines; 0: every point.
  double contour_tolerance = 0.5;
  HullVoting voting = HullVoting::Strict;
  int votes = 0;           ///< MofN: m; views without a matte do not vote
  int resolution = 256;    ///< octree: voxels along the longest side of the box, 8 … 1024
  double smoothing = 0.5;  ///< octree: largest move of a vertex by smoothing, in voxels; 0: none
  /// Exact: also pieces that the mattes are not sure of: thinner than contour_tolerance and half a pixel on
  /// each side, in the camera that sees them smallest. They come from outlines that disagree by a pixel.
  bool keep_crumbs = false;
  MeshCleanup cleanup;
  int threads = 0;       ///< 0: one per core; the result is the same at any number
  bool quality = true;   ///< compute silhouette_iou; takes longer than the exact hull itself
  int quality_step = 1;  ///< on every so-many-th row of the pictures; 4 tells nearly the same
};

/// Every number in range; the sentence says which is not.
Result<void> check(const HullOptions& options);

/// Where a triangle of an exact hull comes from: the cone face behind one edge of one camera's outline.
struct HullFaceSource {
  int camera = -1;        ///< index into Rig::cameras; -1: a side of HullOptions::volume
  int contour_edge = -1;  ///< counted over all polygons of the camera's outline
  bool operator==(const HullFaceSource&) const = default;
};

/// Seconds. The hull alone is their sum but `contours`, `cleanup` and `quality`.
struct HullTimings {
  double contours = 0;  ///< mattes to polygons
  double tables = 0;    ///< every pair of cameras
  double rays = 0, faces = 0, weld = 0, triangles = 0;
  double voting = 0;   ///< Auto: looking for a bad matte
  double cleanup = 0;  ///< HullOptions::cleanup
  double quality = 0;  ///< silhouettes of the mesh against the mattes
  double hull() const { return tables + rays + faces + weld + triangles + voting; }
};

/// What an exact hull cost, in things that do not depend on the machine.
struct HullWork {
  std::int64_t points = 0;     ///< of all outlines
  std::int64_t hits = 0;       ///< half-lines through those that meet another picture's outline
  std::int64_t lines = 0;      ///< edges of other outlines that were looked at within faces
  std::int64_t relations = 0;  ///< pairs of those that were compared
};

/// What MeshCleanup did. Lists are per camera; those of cameras without a matte hold 0.
struct MeshCleanupReport {
  std::size_t triangles_before = 0, triangles_after = 0;
  std::size_t slivers_before = 0, slivers_after = 0;
  /// px: largest_move, or less where the silhouettes would have suffered; 0: not smoothed.
  double smoothed_within = 0;
  std::vector<double> vertex_move;  ///< px, the largest of what is left and of slivers that went
  /// px: Hausdorff distance of the silhouettes before and after, to the pixel.
  std::vector<double> silhouette_shift;
  std::vector<double> iou_loss;  ///< of the silhouette against the matte
};

/// What a camera's silhouette lacks, or has too much, by what the others agree on.
struct SilhouetteVerdict {
  int camera = 0;
  double lost = 0;     ///< share of the subject that the matte lacks: what all others see there
  double gained = 0;   ///< share of the matte that nobody else confirms
  Matte lost_where;    ///< 255 in the blocks (pixels squared) that were looked at and are lost
  Matte gained_where;  ///< 255 in those that nobody confirms
  int block = 1;       ///< px
};

struct HullReport {
  Mesh mesh;                           ///< empty when no point of space is inside every silhouette
  double volume = 0;                   ///< m³
  std::vector<double> silhouette_iou;  ///< per camera: the mesh's silhouette against the matte; NaN for an
                                       ///< empty matte, or without options.quality
  Eigen::AlignedBox3d searched;        ///< metres
  double voxel = 0;                    ///< metres; 0 for the exact method
  double seconds = 0;
  /// What a person should know, a sentence each: cameras that saw only background, an empty hull and why.
  std::vector<std::string> remarks;
  // Exact method:
  std::vector<HullFaceSource> sources;  ///< per triangle
  int faces = 0;                        ///< polygons, before they were cut into triangles
  int escalations = 0;  ///< times that the frame was computed again, with jitter or with exact integers
  /// Auto: silhouettes that the others contradict by more than a twentieth, worst first.
  std::vector<SilhouetteVerdict> verdicts;
  std::vector<int> voted_down;  ///< Auto: cameras that were overruled where they lack what the others see
  /// Auto: more than a twentieth of at least half of the silhouettes (two at least) is explained by no body,
  /// mended or not, or more than a quarter of them lack so much of what the others show, and then none is
  /// overruled: the mattes or the calibration contradict one another, and the hull is not to be trusted.
  bool contradictory = false;
  int stage_cameras = 0;    ///< so many cameras see every point of it, at least; 0: the volume was given
  bool cut = false;         ///< by the sides of the volume, given or found: the subject goes on beyond
  int crumbs = 0;           ///< pieces that were left out, see HullOptions::keep_crumbs
  double crumb_volume = 0;  ///< m³, theirs
  HullTimings timings;
  HullWork work;
  void clear();  ///< empties it, but keeps the mesh's memory
  /// With options.cleanup; `sources` are then those of the triangles that were kept.
  std::optional<MeshCleanupReport> cleanup;
};

/// Memory that visual_hull() keeps from frame to frame. Not for two calls at once; results do not depend on
/// it.
class HullWorkspace {
 public:
  HullWorkspace();
  HullWorkspace(HullWorkspace&&) noexcept;
  HullWorkspace& operator=(HullWorkspace&&) noexcept;
  ~HullWorkspace();
  struct Impl;
  Impl& impl() { return *impl_; }

 private:
  std::unique_ptr<Impl> impl_;
};

/// The visual hull (Laurentini 1994): the largest body that projects into every silhouette. mattes[i] belongs
/// to rig.cameras[i] in its own, distorted pixels; half opacity is the silhouette's edge.
///
/// An empty matte, and everything outside a camera's image, never carves: it is unknown. A camera that sees
/// only background carves all that it sees, which usually leaves nothing: that is an empty mesh and a remark,
/// no error. Space that no camera sees is not hull either: nothing bears witness for it. Where a subject is
/// cut off by an image's border, other cameras or options.volume must bound it.
///
/// The mesh is closed, manifold and oriented. `options.threads` threads work inside; inputs are only read.
/// Errors: InvalidArgument for unequal counts or sizes and for options out of range; BadData for a rig that
/// does not pass check(), when no camera shows any subject ("empty silhouette"), and when the silhouettes
/// bound nothing (all foreground) and no volume was given.
///
/// Mattes of noise are made coarser until the frame's time is bounded, which a remark says: no outline keeps
/// more than 20,000 points, and no pair of cameras more than 4,000,000 / V(V-1) (at least 8 a point) meetings
/// of one's points with the other's edges. What is too much even without islands below some hundred thousand
/// px² is an error, BadData.
Result<HullReport> visual_hull(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options,
                               HullWorkspace* workspace = nullptr);

/// The same for the frames of a sequence: what depends on the calibration only is found once, and memory,
/// that of the report too, is used again. With one thread, the exact method, Strict or MofN votes, no volume,
/// subjects inside the pictures, and neither quality nor cleanup, the second frame of a size allocates
/// nothing. On an error the report is empty.
Result<void> visual_hull(const Rig& rig, std::span<const Matte> mattes, const HullOptions& options,
                         HullWorkspace& workspace, HullReport& report);

/// The same from outlines (outline_of() in recon/outline.h), for where mattes stay with the cameras.
/// outlines[i] belongs to rig.cameras[i], in its own, distorted pixels; one that knows nothing does not
/// carve. They are taken as they are: options.contour_tolerance is for mattes. The hull is that of the
/// mattes, bit for bit, as long as the outlines were found with its tolerance; with a volume that leaves a
/// picture, to the outline's tolerance. Whatever compares silhouettes (Auto votes, quality, cleanup, the
/// octree) compares with the filled outlines, which hold no half opacity. Errors: those above; and BadData,
/// with the camera's name, for an outline that is malformed or has its subject on the wrong side, and for
/// outlines whose hull does not close, since the octree that helps mattes out takes seconds. One that crosses
/// itself a little, as rounding on its way here may do, is mended.
Result<HullReport> visual_hull(const Rig& rig, std::span<const Silhouette> outlines,
                               const HullOptions& options, HullWorkspace* workspace = nullptr);
Result<void> visual_hull(const Rig& rig, std::span<const Silhouette> outlines, const HullOptions& options,
                         HullWorkspace& workspace, HullReport& report);

}  // namespace floatstage::recon
