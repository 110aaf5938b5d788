#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "recon/exact/exact_face.h"
#include "recon/exact/exact_mesh.h"
#include "recon/exact/exact_pairs.h"
#include "recon/exact/exact_rays.h"
#include "recon/exact/exact_views.h"

namespace floatstage::recon {

/// How the numbers were decided. Each step is taken only when the one before left the surface open.
enum class ExactLevel {
  Doubles,   ///< as given, in doubles
  Jitter,    ///< every ray moved by a hash, up to 1e-4 px, in doubles
  Integers,  ///< moved, rounded to a grid, and every predicate exact; a zero predicate means another hash
};

struct ExactOptions {
  int votes = 0;        ///< how many views, besides the mandatory ones, have to agree on "inside"; 0: all
  int threads = 1;      ///< 0: one per core; the same result at any number
  double pixel = 1e-3;  ///< size of a pixel in units of a ray's z: 1 / focal length
  bool triangulate = true;
  bool cull = true;  ///< false: the slow reference, which leaves nothing out
  ExactLevel start = ExactLevel::Doubles;
};

struct ExactTimings {
  double pairs = 0, rays = 0, faces = 0, weld = 0, triangles = 0;  ///< seconds
  double total() const { return pairs + rays + faces + weld + triangles; }
};

/// What a frame cost, in things that do not depend on the machine.
struct ExactWork {
  std::int64_t hits = 0;       ///< rays through contour edges of other views
  std::int64_t lines = 0;      ///< made in all faces
  std::int64_t relations = 0;  ///< pairs of lines looked at
};

struct ExactOutcome {
  ExactLevel level = ExactLevel::Doubles;
  int attempts = 0;  ///< sweeps over the whole frame; 1 when plain doubles were enough
  /// The views do not bound the hull: give a volume. Believed only from the integers.
  bool unbounded = false;
  bool closed = false;
  int defects = 0;           ///< faces whose boundary did not close, in the last attempt
  bool tie = false;          ///< an exact predicate was zero, in the last attempt
  bool too_complex = false;  ///< more outline edges, hits (PairTables::most_hits) or pairs of lines than a
                             ///< frame may cost: no hull
  ExactWork work;            ///< of the last attempt
  ExactTimings timings;      ///< of the last attempt
};

/// The exact polyhedral visual hull of polygonal silhouettes (Franco and Boyer 2003 state the problem): one
/// planar sweep for each contour edge, vertices that carry names instead of tolerances, and a check that
/// every edge has its reverse. docs/algorithms/visual-hull.md explains it. Keeps its memory: on one thread
/// the second frame of a size allocates nothing, unless it has to escalate.
class ExactHull {
 public:
  /// At least two views; every view has at least one polygon. The views are moved when escalation needs it.
  ExactOutcome compute(std::vector<ConeView>& views, const ExactOptions& options);
  const HullPolygons& polygons() const { return polygons_; }

 private:
  void attempt(std::span<const ConeView> views, const GridViews* grid, const ExactOptions& options,
               ExactOutcome& outcome);
  std::span<FaceOutput> sweep_faces(std::int32_t faces, int threads);

  PairTables pairs_;
  RayIntervals rays_;
  GridViews grid_;
  ArrangementInput input_;
  std::vector<FaceOutput> parts_;
  std::vector<FaceSweep> sweeps_;
  std::vector<ConeView> moved_;
  MeshWelder welder_;
  HullPolygons polygons_;
};

}  // namespace floatstage::recon
