#include "recon/exact_face.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace floatstage {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSlack = 1e-9;  // widens windows that only save work

double w_at(double wa, double wb, double s) { return wa + (wb - wa) * s; }

}  // namespace

void FaceOutput::clear() {
  corners.clear();
  polygon_start.assign(1, 0);
  faces.clear();
  defects = 0;
  unbounded = tie = false;
}

void FaceSweep::run(int view, int edge, FaceOutput& out) {
  const ConeView& own = in_->views[view];
  i_ = view;
  edge_ = a_ = edge;
  b_ = own.next[edge];
  da_ = own.rays[a_];
  db_ = own.rays[b_];
  step_ = db_ - da_;
  lines_.clear();
  exact_.clear();
  vertices_.clear();
  views_.clear();
  edges_.clear();
  tie_ = defect_ = unbounded_ = false;
  const bool strict = in_->votes.strict;
  window_low_ = 0;
  window_high_ = kInfinity;
  for (int j = 0; j < static_cast<int>(in_->views.size()); ++j) {
    if (j != view && !add_view(j) && strict)
      return;  // the views so far have nothing in common along the whole face
  }
  if (!find_window()) return;
  for (ViewLines& group : views_) {
    add_lines(group);
    if (strict && group.begin == group.end && group.state <= 0) return;  // outside all over the window
  }
  for (const ViewLines& group : views_) {
    for (int f = group.begin; f < group.end && !defect_; ++f) {
      if (lines_[f].high >= window_low_ && lines_[f].low <= window_high_) cut_line(f, strict);
    }
  }
  add_ray_edges();
  if (!edges_.empty()) link(out);
  out.tie |= tie_;
  out.unbounded |= unbounded_;
  out.defects += defect_;
}

/// Where a view can be inside at all, from the points at which its lines begin and end. Narrows the window;
/// false when nothing is left of it.
bool FaceSweep::add_view(int j) {
  const PairTable& mine = in_->pairs->of(i_, j);
  ViewLines group{};
  group.view = j;
  group.vertices = static_cast<int>(vertices_.size());
  group.lowest = group.least = kInfinity;
  group.highest = group.most = -kInfinity;
  add_vertices(j);
  group.vertices_end = static_cast<int>(vertices_.size());
  const auto extend = [&](int line_edge, double w) {
    group.least = std::min(group.least, w);
    group.most = std::max(group.most, w);
    if (mine.upper[line_edge]) {
      group.highest = std::max(group.highest, w);
    } else {
      group.lowest = std::min(group.lowest, w);
    }
  };
  for (int h = mine.ray_start[a_]; h < mine.ray_start[a_ + 1]; ++h) {
    extend(mine.hits[h].edge, mine.hits[h].w);
    group.net += mine.upper[mine.hits[h].edge] ? 1 : -1;
  }
  for (int h = mine.ray_start[b_]; h < mine.ray_start[b_ + 1]; ++h) extend(mine.hits[h].edge, mine.hits[h].w);
  for (int v = group.vertices; v < group.vertices_end; ++v) {
    extend(vertices_[v].ray, vertices_[v].w);
    extend(in_->views[j].prev[vertices_[v].ray], vertices_[v].w);
  }
  if (mine.top) group.highest = kInfinity;
  if (mine.top + group.net > 0) group.lowest = -kInfinity;
  views_.push_back(group);
  window_low_ = std::max(window_low_, group.lowest);
  window_high_ = std::min(window_high_, group.highest);
  return window_low_ < window_high_;
}

void FaceSweep::add_vertices(int j) {
  const PairTable& theirs = in_->pairs->of(j, i_);
  const ConeView& other = in_->views[j];
  const AxisTable& axis = in_->pairs->axis(i_, j);
  const bool forward = i_ < j;
  const auto &own_flat = forward ? axis.low : axis.high, &other_flat = forward ? axis.high : axis.low;
  const Eigen::Vector3d baseline = other.center - in_->views[i_].center;
  const Eigen::Vector2d u = own_flat[a_], v = own_flat[b_];
  for (int at = theirs.face_start[edge_]; at < theirs.face_start[edge_ + 1]; ++at) {
    const PairTable::FaceHit& hit = theirs.face_hits[at];
    const int q = hit.ray;
    Vertex vertex{0, 0, q, theirs.first_id + hit.index};
    if (in_->grid) {
      const auto [ta, tb] = exact_sides({0, 0, q, 0}, j);
      vertex.s = static_cast<double>(ta) / (static_cast<double>(ta) - static_cast<double>(tb));
    } else {
      const Eigen::Vector2d& p = other_flat[q];
      const double ta = u.x() * p.y() - u.y() * p.x(), tb = v.x() * p.y() - v.y() * p.x();
      vertex.s = ta / (ta - tb);
    }
    // From the point itself: the lines through it may be steep.
    const Eigen::Vector3d d = da_ + vertex.s * step_;
    const double w = hit.w;
    vertex.w = w * d.squaredNorm() / (w * d.dot(baseline) + d.dot(other.rays[q]));
    vertices_.push_back(vertex);
  }
}

bool FaceSweep::find_window() {
  const bool strict = in_->votes.strict;
  keep_low_ = -kInfinity;
  keep_high_ = kInfinity;
  if (!strict) {
    window_low_ = 0;
    window_high_ = kInfinity;
    std::vector<double> lows, highs;
    for (const ViewLines& group : views_) {
      if (in_->views[group.view].mandatory) {
        window_low_ = std::max(window_low_, group.lowest);
        window_high_ = std::min(window_high_, group.highest);
      } else {
        lows.push_back(group.lowest);
        highs.push_back(-group.highest);
      }
    }
    const int needed = in_->votes.ordinary - (in_->views[i_].mandatory ? 0 : 1);
    if (needed > static_cast<int>(lows.size())) return false;
    if (needed > 0) {
      std::nth_element(lows.begin(), lows.begin() + (needed - 1), lows.end());
      std::nth_element(highs.begin(), highs.begin() + (needed - 1), highs.end());
      window_low_ = std::max(window_low_, lows[needed - 1]);
      window_high_ = std::min(window_high_, -highs[needed - 1]);
    }
  }
  if (!(window_low_ < window_high_)) return false;
  window_low_ *= 1 - kSlack;
  window_high_ *= 1 + kSlack;
  if (strict) {
    keep_low_ = window_low_;
    keep_high_ = window_high_;
  }
  return true;
}

/// Makes the lines of a view that reach into the window. What the others would say is kept in two ways: those
/// above the window count in `state`, and where a kept line ends above the window its end stands for a
/// vertical line from there upwards, so that the states below it are the true ones.
void FaceSweep::add_lines(ViewLines& group) {
  const int j = group.view;
  const PairTable &mine = in_->pairs->of(i_, j), &theirs = in_->pairs->of(j, i_);
  const ConeView& other = in_->views[j];
  const int a = mine.ray_start[a_], a_end = mine.ray_start[a_ + 1], b = mine.ray_start[b_],
            b_end = mine.ray_start[b_ + 1];
  group.begin = static_cast<int>(lines_.size());
  group.end = group.begin;
  group.state = mine.top;
  if (group.most < keep_low_) return;
  if (group.least > keep_high_) {
    group.state += group.net;
    return;
  }
  // s grows with phi where this face is not an upper bound for the other view's rays; an upper bound of the
  // other view runs towards larger phi.
  const bool s_with_phi = theirs.upper[edge_] == 0;
  const auto runs_right = [&](int edge) { return (mine.upper[edge] != 0) == s_with_phi; };
  const auto vertex_end = [&](int ray, End& end) {
    const auto first = vertices_.begin() + group.vertices, last = vertices_.begin() + group.vertices_end;
    const auto at = std::lower_bound(first, last, ray, [](const Vertex& v, int r) { return v.ray < r; });
    if (at == last || at->ray != ray) return false;
    end = {at->s, at->w, ray, at->hit};
    return true;
  };
  const auto ray_end = [&](int edge, int h, int h_end, double s) {
    while (h < h_end && mine.hits[h].edge != edge) ++h;
    if (h < h_end) return End{s, mine.hits[h].w, kSide, mine.first_id + h};
    defect_ = true;  // only rounding can make a line end nowhere
    return End{};
  };
  for (int h = a; h < a_end; ++h) {
    const int edge = mine.hits[h].edge;
    End right;
    if (!vertex_end(runs_right(edge) ? other.next[edge] : edge, right)) right = ray_end(edge, b, b_end, 1);
    const double w = mine.hits[h].w;
    if (!add_line(j, edge, {0, w, kSide, mine.first_id + h}, right) && w > keep_high_) {
      group.state += mine.upper[edge] ? 1 : -1;
    }
  }
  if (group.vertices < group.vertices_end) {
    for (int h = b; h < b_end; ++h) {
      const int edge = mine.hits[h].edge;
      End left;
      if (!vertex_end(runs_right(edge) ? edge : other.next[edge], left))
        continue;  // it came from the other ray
      add_line(j, edge, left, {1, mine.hits[h].w, kSide, mine.first_id + h});
    }
    for (int v = group.vertices; v < group.vertices_end; ++v) {
      const End here{vertices_[v].s, vertices_[v].w, vertices_[v].ray, vertices_[v].hit};
      End after;
      if (!vertex_end(other.next[here.ray], after)) continue;
      const bool right = runs_right(here.ray);
      add_line(j, here.ray, right ? here : after, right ? after : here);
    }
  }
  group.end = static_cast<int>(lines_.size());
}

bool FaceSweep::add_line(int j, int edge, const End& left, const End& right) {
  const double low = std::min(left.w, right.w), high = std::max(left.w, right.w);
  if (high < keep_low_ || low > keep_high_) return false;
  const PairTable& pair = in_->pairs->of(i_, j);
  Line& line = lines_.emplace_back();
  line.low = low;
  line.high = high;
  line.left_above = left.ray != kSide && left.w > keep_high_;
  line.right_above = right.ray != kSide && right.w > keep_high_;
  line.edge = edge;
  line.view = static_cast<std::int16_t>(j);
  line.upper = pair.upper[edge] != 0;
  line.left = left;
  line.right = right;
  if (in_->grid) {
    const GridViews& grid = *in_->grid;
    const GridViews::Vector n = cross(grid.rays[j][edge], grid.rays[j][in_->views[j].next[edge]]);
    const ExactLine exact{dot(n, grid.rays[i_][a_]), dot(n, grid.rays[i_][b_]),
                          dot(n, grid.centers[j] - grid.centers[i_])};
    const double scale = grid.center_scale / grid.ray_scale / static_cast<double>(exact.below);
    line.wa = static_cast<double>(exact.above_a) * scale;
    line.wb = static_cast<double>(exact.above_b) * scale;
    exact_.push_back(exact);
  } else {
    line.wa = pair.slope[edge].dot(da_);
    line.wb = pair.slope[edge].dot(db_);
  }
  return true;
}

/// The states of the other views are true in the window only: there the line is followed from where it
/// enters.
FaceSweep::End FaceSweep::entry_of(const Line& line) const {
  const double w = line.left.w;
  if (w >= keep_low_ && w <= keep_high_) return line.left;
  const double level = w > keep_high_ ? keep_high_ : keep_low_, s = (level - line.wa) / (line.wb - line.wa);
  return {s >= line.left.s ? std::min(s, line.right.s) : line.left.s, level, kClipped, -1};
}

bool FaceSweep::cut_by_view(int f, const End& entry, const ViewLines& other, bool strict, int& inside) {
  const Line& line = lines_[f];
  const std::size_t before_count = crossings_.size();
  int state = other.state;
  for (int g = other.begin; g < other.end; ++g) {
    const Line& cutter = lines_[g];
    const int sign = cutter.upper ? 1 : -1;  // of passing it downwards
    const bool starts_later = before(entry, line.view, cutter.left, cutter.view);
    const bool spans = !starts_later && before(entry, line.view, cutter.right, cutter.view);
    if (!starts_later) state += (cutter.right_above && !spans ? sign : 0) - (cutter.left_above ? sign : 0);
    if (cutter.high < line.low) continue;
    if (cutter.low > line.high) {
      if (spans) state += sign;
      continue;
    }
    const bool ends_earlier = before(cutter.right, cutter.view, line.right, line.view);
    const End &from = starts_later ? cutter.left : entry, &to = ends_earlier ? cutter.right : line.right;
    const int from_view = starts_later ? cutter.view : line.view,
              to_view = ends_earlier ? cutter.view : line.view;
    if (!before(from, from_view, to, to_view)) continue;
    const int first = side(f, g, from, from_view), last = side(f, g, to, to_view);
    if (spans && first < 0) state += sign;
    if (first == last) continue;
    const double at_a = line.wa - cutter.wa, at_b = line.wb - cutter.wb;
    double s = at_a / (at_a - at_b);
    s = s >= from.s ? std::min(s, to.s) : from.s;  // also when both lines are one and s is not a number
    // Falling below an upper bound enters its view.
    crossings_.push_back({s, g, static_cast<std::int8_t>((first > 0) == cutter.upper ? 1 : -1)});
  }
  if (strict && state <= 0 && crossings_.size() == before_count) return false;
  if (state > 0) inside += in_->votes.weight[other.view];
  return true;
}

void FaceSweep::cut_line(int f, bool strict) {
  crossings_.clear();
  const End entry = entry_of(lines_[f]);
  int inside = 0;
  for (const ViewLines& other : views_) {
    if (other.view == lines_[f].view) continue;
    if (!cut_by_view(f, entry, other, strict, inside)) return;
  }
  // The run is the hull's where exactly one side of the line is: the inner one, or the outer.
  const int own = in_->votes.weight[lines_[f].view];
  const auto kind_of = [&](int weight) {
    const bool inner = in_->votes.decides(i_, weight + own), outer = in_->votes.decides(i_, weight);
    return inner == outer ? -1 : (inner ? 0 : 1);
  };
  if (crossings_.size() > 1) {
    std::sort(crossings_.begin(), crossings_.end(),
              [&](const Crossing& x, const Crossing& y) { return crosses_before(f, x, y); });
  }
  int open = -2;  // crossing at which the run began; -1: the line's left end; -2: no run
  int kind = kind_of(inside);
  if (kind >= 0) open = -1;
  for (int c = 0; c < static_cast<int>(crossings_.size()); ++c) {
    inside += crossings_[c].change * in_->votes.weight[lines_[crossings_[c].line].view];
    const int now = kind_of(inside);
    if (now == kind) continue;
    if (open != -2) emit_run(f, open, c, kind == 0);
    open = now >= 0 ? c : -2;
    kind = now;
  }
  if (open != -2) emit_run(f, open, -1, kind == 0);
}

void FaceSweep::emit_run(int f, int from, int to, bool inner) {
  const Line& line = lines_[f];
  // Corner keys within the face: hits are unique; at a triple point the quadrant tells touching cells apart.
  const auto corner = [&](int crossing, const End& end, bool after) -> std::pair<std::uint64_t, FaceCorner> {
    if (crossing < 0) {
      return {static_cast<std::uint64_t>(end.hit),
              {VertexName::hit(end.hit), end.s, w_at(line.wa, line.wb, end.s)}};
    }
    const Crossing& c = crossings_[crossing];
    const bool inside_cutter = (c.change > 0) == after;
    const std::uint64_t low = std::min(f, c.line), high = std::max(f, c.line);
    const std::uint64_t low_inside = f < c.line ? inner : inside_cutter,
                        high_inside = f < c.line ? inside_cutter : inner;
    const std::uint64_t key = std::uint64_t{1} << 63 | low << 33 | high << 2 | low_inside << 1 | high_inside;
    const Line& cutter = lines_[c.line];
    const VertexName name = VertexName::triple(face_number(i_, edge_), face_number(line.view, line.edge),
                                               face_number(cutter.view, cutter.edge));
    return {key, {name, c.s, w_at(line.wa, line.wb, c.s)}};
  };
  const auto [left_key, left] = corner(from, line.left, true);
  const auto [right_key, right] = corner(to, line.right, false);
  if (std::min(left.w, right.w) <= 0) {
    unbounded_ |= std::max(left.w, right.w) > 0;
    return;
  }
  // Outside the window the other views' states are not the true ones, and there is no hull.
  if (std::min(left.w, right.w) < keep_low_ || std::max(left.w, right.w) > keep_high_) return;
  // Clockwise in (s, w): along its upper boundary a cell is walked towards larger s.
  if (line.upper == inner) {
    edges_.push_back({left_key, right_key, left});
  } else {
    edges_.push_back({right_key, left_key, right});
  }
}

void FaceSweep::add_ray_edges() {
  const auto& intervals = in_->rays->of_view[i_];
  const auto& start = in_->rays->start[i_];
  const VertexName apex = VertexName::apex(i_, in_->views[i_].loop[edge_]);
  const auto add = [&](int ray, double s, bool up) {
    for (int k = start[ray]; k < start[ray + 1]; ++k) {
      const RayInterval& interval = intervals[k];
      const FaceCorner low{VertexName::hit(interval.low), s, interval.w_low};
      const FaceCorner high = interval.high == RayInterval::kApex
                                  ? FaceCorner{apex, s, kInfinity}
                                  : FaceCorner{VertexName::hit(interval.high), s, interval.w_high};
      const FaceCorner &from = up ? low : high, &to = up ? high : low;
      edges_.push_back({from.name.bits(), to.name.bits(), from});
    }
  };
  add(a_, 0, true);
  add(b_, 1, false);
}

void FaceSweep::link(FaceOutput& out) {
  const int count = static_cast<int>(edges_.size());
  constexpr int kFew = 12;  // up to here a linear search beats sorting
  if (count > kFew) {
    std::sort(edges_.begin(), edges_.end(), [](const Edge& x, const Edge& y) { return x.from < y.from; });
  }
  const auto starting_at = [&](std::uint64_t key) {
    if (count > kFew) {
      const auto at = std::lower_bound(edges_.begin(), edges_.end(), key,
                                       [](const Edge& e, std::uint64_t k) { return e.from < k; });
      return at != edges_.end() && at->from == key ? static_cast<int>(at - edges_.begin()) : -1;
    }
    for (int k = 0; k < count; ++k) {
      if (edges_[k].from == key) return k;
    }
    return -1;
  };
  const std::size_t corners_before = out.corners.size(), polygons_before = out.polygon_start.size();
  used_.assign(static_cast<std::size_t>(count), 0);
  for (int k = 0; k < count && !defect_; ++k) {
    if (used_[k]) continue;
    int at = k;
    do {
      used_[at] = 1;
      out.corners.push_back(edges_[at].corner);
      at = starting_at(edges_[at].to);
      defect_ |= at < 0 || (at != k && used_[at]);
    } while (at != k && !defect_);
    out.polygon_start.push_back(static_cast<std::int32_t>(out.corners.size()));
  }
  if (defect_) {
    out.corners.erase(out.corners.begin() + static_cast<std::ptrdiff_t>(corners_before), out.corners.end());
    out.polygon_start.resize(polygons_before);
    return;
  }
  out.faces.push_back({i_, edge_, static_cast<std::int32_t>(polygons_before) - 1});
}

}  // namespace floatstage
