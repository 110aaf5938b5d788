#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "recon/exact/exact_pairs.h"
#include "recon/exact/exact_rays.h"
#include "recon/exact/line_relations.h"

namespace floatstage::recon {

/// The name of a hull vertex, by which neighbouring faces meet without any tolerance: a hit (a ray through a
/// face), the three faces of a triple point in ascending order, or a camera's centre seen through one
/// polygon.
class VertexName {
 public:
  static constexpr int kFaceBits = 20;
  static VertexName hit(std::int32_t id) { return VertexName(static_cast<std::uint64_t>(id)); }
  static VertexName apex(int view, int loop) {
    return VertexName(kApexFlag | static_cast<std::uint64_t>(view) << 32 | static_cast<std::uint64_t>(loop));
  }
  static VertexName triple(std::uint64_t a, std::uint64_t b, std::uint64_t c) {
    if (a > b) std::swap(a, b);
    if (b > c) std::swap(b, c);
    if (a > b) std::swap(a, b);
    return VertexName(kTripleFlag | a << (2 * kFaceBits) | b << kFaceBits | c);
  }
  bool is_hit() const { return bits_ >> 61 == 0; }
  bool is_triple() const { return (bits_ & kTripleFlag) != 0; }
  bool is_apex() const { return (bits_ & kApexFlag) != 0; }
  std::int32_t hit_id() const { return static_cast<std::int32_t>(bits_); }
  int apex_view() const { return static_cast<int>((bits_ >> 32) & 0xfffff); }
  std::uint64_t bits() const { return bits_; }
  bool operator==(const VertexName&) const = default;

 private:
  static constexpr std::uint64_t kTripleFlag = std::uint64_t{1} << 62, kApexFlag = std::uint64_t{1} << 61;
  explicit VertexName(std::uint64_t bits) : bits_(bits) {}
  std::uint64_t bits_;
};

/// A corner of a face polygon, in the face's own plane coordinates.
struct FaceCorner {
  VertexName name;
  double s, w;
};

/// What a run of faces adds to the mesh: polygons of corners, clockwise in (s, w), which is counter-clockwise
/// seen from outside. The polygons of one face are consecutive; holes run the other way.
struct FaceOutput {
  struct Face {
    std::int32_t view, edge;
    std::int32_t first_polygon;
  };
  std::vector<FaceCorner> corners;
  std::vector<std::int32_t> polygon_start;  ///< polygon p is corners[polygon_start[p]] … [p + 1]
  std::vector<Face> faces;
  std::vector<std::uint32_t> triangles;     ///< once triangulated: vertex numbers of the hull
  std::vector<std::int32_t> triangle_face;  ///< per triangle: index into the hull's faces
  std::vector<std::uint64_t> risky;         ///< diagonals whose ends have another face in common
  bool doubled = false;                     ///< a diagonal is another face's edge
  std::int64_t lines = 0, relations = 0;    ///< the work: lines made, pairs of lines looked at
  bool too_many = false;   ///< given up: more relations than ArrangementInput::most_relations
  int defects = 0;         ///< faces whose boundary does not close: doubles were not enough
  bool unbounded = false;  ///< a face reaches infinity
  bool tie = false;        ///< an exact comparison was zero

  void clear();
};

/// What every face needs; shared by all threads.
struct ArrangementInput {
  std::span<const ConeView> views;
  const PairTables* pairs;
  const RayIntervals* rays;
  const GridViews* grid;  ///< null: doubles decide
  Votes votes;
  std::int64_t most_relations = 0;  ///< in one run of faces
  bool cull = true;  ///< leave out lines that cannot matter; without, the same result is found slowly
  std::vector<std::int32_t> first_face;  ///< per view: number of its first contour edge among all
};

/// Computes the part of the hull that lies in one contour edge's cone face
///     X = C_i + ((1-s) d_a + s d_b) / w,  s in [0,1],
/// where every plane of another view is a straight line. Each line's stretch is cut at its crossings with the
/// lines of other views; the stretches along which exactly the right number of views agree, and those of the
/// two rays, are the boundary of the face's polygons.
class FaceSweep {
 public:
  void start(const ArrangementInput& input) { in_ = &input; }
  /// The faces behind edges begin … end - 1 of a view, at most kMostFaces.
  void run(int view, int begin, int end, FaceOutput& out);
  static constexpr int kMostFaces = 64;

 private:
  static constexpr std::int32_t kSide = -1;     ///< an end on one of the two rays that bound the face
  static constexpr std::int32_t kClipped = -2;  ///< no end, but where the line enters the window
  struct End {
    double s = 0, w = 0;
    std::int32_t ray = kSide;  ///< of the line's own view
    std::int32_t hit = -1;
  };
  struct Line {
    double wa, wb;     ///< w where the line meets s = 0 and s = 1
    double low, high;  ///< range of w between its ends
    End left, right;
    std::int32_t edge;
    std::int16_t view;
    bool upper;                                    ///< the inside of its view is below it (at smaller w)
    bool left_above = false, right_above = false;  ///< that end is a vertex above the window
  };
  struct ExactLine {
    Int128 above_a, above_b, below;  ///< wa = above_a / below, wb = above_b / below, up to a scale
  };
  /// A contour vertex of another view whose ray passes through the face.
  struct Vertex {
    double w;
    std::int32_t ray, hit;
  };
  /// The buckets of s that a line reaches, and the view it belongs to, as an index into views_.
  struct Reach {
    int first, last, view;
  };
  struct ViewLines {
    int view;
    int begin, end;       ///< in lines_: those that reach into the window
    int state;            ///< inside (1) or not at s = 0 above all lines that are kept
    int first_block = 0;  ///< in blocks_
  };
  /// A window that was split: the windows of its parts hold some of its lines each.
  struct Split {
    std::vector<PairTable::Bound> parts;
    std::vector<Line> lines;
    std::vector<ExactLine> exact;
    std::vector<ViewLines> views;
    int inside = 0;
  };
  bool take_part(const Split& whole, const PairTable::Bound& part);
  struct Crossing {
    double s;
    std::int32_t line;
    std::int8_t change;  ///< of the number of views inside, towards larger s
  };
  struct Edge {
    std::uint64_t from, to;  ///< corners within this face
    FaceCorner corner;       ///< at `from`
  };

  void take(int edge);
  void take_depths();
  void find_windows(int begin, int end);
  PairTable::Bound bound_of(int j, double low, double high);
  PairTable::Bound voted_window();
  void sweep(const PairTable::Bound& window);
  void find_runs(std::size_t depth);
  bool split_window(std::vector<PairTable::Bound>& parts);
  double w_of(const PairTable::FaceHit& hit, const Eigen::Vector3d& ray, double along_baseline) const {
    return hit.w / (hit.w * along_baseline + depth_.dot(ray));
  }
  double s_of(int j, int ray) const;
  bool add_view(int j);
  int add_lines(int j);
  void add_line(int j, int edge, const End& left, const End& right);
  void start_cutting();
  End entry_of(const Line& line) const;
  void cut_line(int f, bool strict);
  void fill_blocks();
  void meet(int f, int g, const End& entry, int& state);
  void fill_buckets();
  int bucket_of(double s) const;
  static bool is_long(const Line& line);
  bool cut_in_buckets(int f, const End& entry, bool strict, int& inside);
  void add_crossing(int f, int g, const End& entry, bool falls);
  bool tally_view(int f, const End& entry, const ViewLines& other, bool strict, int& inside);
  bool cut_by_view(int f, const End& entry, const ViewLines& other, bool strict, int& inside);
  void emit_run(int f, int from_crossing, int to_crossing, bool inner);
  void add_ray_edges();
  void link(FaceOutput& out);

  std::uint64_t face_number(int view, int edge) const {
    const std::int32_t number = in_->first_face[view] + edge;
    return static_cast<std::uint64_t>(number);
  }
  /// Whether f lies above (1) or below (-1) g at that end of either.
  int side(int f, int g, const End& at, int at_view);
  /// Whether end x lies at smaller s than end y.
  bool before(const End& x, int x_view, const End& y, int y_view);
  /// Whether f crosses g at smaller s than h.
  bool crosses_before(int f, const Crossing& g, const Crossing& h);
  int exact_side(int f, int g, const End& at, int at_view);
  bool exactly_before(const End& x, int x_view, const End& y, int y_view);
  bool exactly_crosses_before(int f, const Crossing& g, const Crossing& h);
  std::pair<Int128, Int128> exact_sides(const End& end, int view) const;

  const ArrangementInput* in_ = nullptr;
  int i_ = 0, edge_ = 0, a_ = 0, b_ = 0;
  Eigen::Vector3d da_, db_, step_;
  Eigen::Vector3d depth_;  ///< w of a point X of the face is 1 / (depth_ . (X - C_i))
  std::array<PairTable::Bound, kMostFaces> windows_;
  double keep_low_ = 0, keep_high_ = 0;  ///< lines that do not reach into this range of w are left out
  std::array<Split, 2> splits_;          ///< of the window, and of its parts
  struct Extent {
    double high, low;
    int change;  ///< of the view's state at s = 0, downwards
  };
  std::vector<Extent> downwards_;
  int first_line_ = 0;  ///< number of lines in the windows before this one
  int inside_ = 0;      ///< weight of the views that are inside all over that range
  bool tie_ = false, defect_ = false, unbounded_ = false;
  std::vector<Line> lines_;
  std::vector<ExactLine> exact_;  ///< beside lines_, with a grid only
  std::vector<ViewLines> views_;
  std::vector<Vertex> vertices_;    ///< of the view whose lines are being made, sorted by ray
  std::vector<int> vertex_of_ray_;  ///< one more than the index in vertices_; 0: none
  std::vector<LineBlock> blocks_;   ///< the lines again, each view's from a block of its own on
  RelateBlock relate_ = relate_kernel().relate;
  bool is_wide_ = false;
  int bucket_count_ = 0;
  std::vector<Reach> reach_;
  std::vector<int> bucket_start_, bucket_lines_;  ///< bucket b holds bucket_lines_[bucket_start_[b]] …
  std::vector<int> long_;                         ///< lines that are in no bucket
  std::vector<int> above_;                        ///< short lines with an end above the window
  std::vector<std::pair<int, bool>> states_;      ///< per view: where the line is entered; whether it crosses
  std::vector<int> order_;                        ///< in which views are asked: first those that cut most
  VoteWindow vote_window_;
  std::vector<Crossing> crossings_;
  std::vector<Edge> edges_;
  std::int64_t made_ = 0, related_ = 0, most_related_ = 0;
  std::vector<std::uint8_t> used_;
};

inline int FaceSweep::side(int f, int g, const End& at, int at_view) {
  if (in_->grid) return exact_side(f, g, at, at_view);
  const double at_a = lines_[f].wa - lines_[g].wa, at_b = lines_[f].wb - lines_[g].wb;
  return at_a + (at_b - at_a) * at.s >= 0 ? 1 : -1;
}

inline bool FaceSweep::before(const End& x, int x_view, const End& y, int y_view) {
  return in_->grid ? exactly_before(x, x_view, y, y_view) : x.s < y.s;
}

inline bool FaceSweep::crosses_before(int f, const Crossing& g, const Crossing& h) {
  return in_->grid ? exactly_crosses_before(f, g, h) : g.s < h.s;
}

}  // namespace floatstage::recon
