#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "recon/exact/exact_face.h"
#include "recon/exact/exact_polygon.h"

namespace floatstage::recon {

/// The hull with its polygonal faces. Vertices are shared by name, so it is closed without any tolerance.
struct HullPolygons {
  struct Face {
    std::int32_t view, edge;  ///< the contour edge whose cone face it lies in
    std::int32_t
        first_polygon;  ///< polygons first_polygon … of the next face; an outline per piece, then its holes
  };
  std::vector<Eigen::Vector3d> positions;   ///< metres
  std::vector<std::int32_t> corners;        ///< indices into positions
  std::vector<std::int32_t> polygon_start;  ///< one more than polygons
  std::vector<Face> faces;
  std::vector<std::uint32_t> triangles;     ///< three indices each, counter-clockwise seen from outside
  std::vector<std::int32_t> triangle_face;  ///< per triangle: index into faces
  double volume = 0;                        ///< m³, from the faces' area vectors, without triangles

  int unmatched = 0;  ///< directed edges without their reverse
  int irregular = 0;  ///< vertices whose faces do not form one fan
  bool closed() const { return unmatched == 0 && irregular == 0; }
  void clear();
};

/// Welds what the sweeps found. Keeps its tables from frame to frame.
class MeshWelder {
 public:
  /// Numbers the vertices and fills `out` but for the triangles; `parts` in ascending order of faces.
  void weld(const ArrangementInput& input, std::span<const FaceOutput> parts, HullPolygons& out);
  /// Cuts all polygons into triangles. False when a diagonal was cut along twice, or is another face's edge,
  /// which only rounding can do: it would have four triangles.
  bool triangulate(std::span<FaceOutput> parts, int threads, HullPolygons& out);

 private:
  std::int32_t number_of(VertexName name, const FaceCorner& corner, const FaceOutput::Face& face,
                         const ArrangementInput& input, HullPolygons& out);
  void place_hits(const ArrangementInput& input, HullPolygons& out);
  void note_face(std::int32_t vertex, std::int32_t face);
  /// Face f of a part with its corners' numbers; false when it uses a hit that its ray does not know.
  bool add_face(const FaceOutput& part, std::size_t f, const ArrangementInput& input, HullPolygons& out);
  void check(const ArrangementInput& input, HullPolygons& out);
  struct Scratch {
    std::vector<Eigen::Vector2d> points;
    std::vector<std::int32_t> ends, local;
    std::vector<std::pair<std::int32_t, std::int32_t>> within;
    PolygonCutter cutter;
  };
  struct PartStart {
    std::int32_t corner, face;
  };
  static void cut_face(const FaceOutput& part, int first, int last, Scratch& scratch);
  static bool adjacent(const Scratch& scratch, std::int32_t a, std::int32_t b);
  void note_risky(FaceOutput& part, std::size_t first_triangle, bool ears_only, std::int32_t number,
                  Scratch& scratch) const;
  void triangulate_part(FaceOutput& part, PartStart start, const HullPolygons& hull, Scratch& scratch) const;
  bool share_another_face(std::int32_t u, std::int32_t v, std::int32_t face) const;

  static constexpr int kFaces = 3;  ///< of a vertex that are noted; all, but for apexes
  std::vector<std::int32_t> faces_of_;
  std::vector<PartStart> part_start_;
  std::vector<Scratch> scratch_;
  std::vector<std::uint64_t> risky_;
  std::vector<std::int32_t> of_hit_;
  std::vector<std::uint64_t> keys_;  ///< open addressing; 0 is free
  std::vector<std::int32_t> values_;
  std::size_t named_ = 0;
  std::vector<std::int32_t> out_edges_, degree_;
  std::vector<std::uint8_t> kind_;
};

}  // namespace floatstage::recon
