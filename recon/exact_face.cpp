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

void FaceSweep::run(int view, int begin, int end, FaceOutput& out) {
  i_ = view;
  find_windows(begin, end);
  for (int edge = begin; edge < end; ++edge) {
    const PairTable::Bound& window = windows_[edge - begin];
    if (!(window.low < window.high)) continue;
    take(edge);
    take_depths();
    keep_low_ = in_->cull ? window.low * (1 - kSlack) : -kInfinity;
    keep_high_ = in_->cull ? window.high * (1 + kSlack) : kInfinity;
    run_face(out);
  }
}

void FaceSweep::take(int edge) {
  const ConeView& own = in_->views[i_];
  edge_ = a_ = edge;
  b_ = own.next[edge];
  da_ = own.rays[a_];
  db_ = own.rays[b_];
  step_ = db_ - da_;
}

/// The vector of the face's plane whose product with all (1-s) d_a + s d_b is 1.
void FaceSweep::take_depths() {
  const Eigen::Vector3d n = da_.cross(step_);
  depth_ = step_.cross(n) / n.squaredNorm();
}

/// The range of w in which each face can have hull at all. One view after the other, so that its tables are read in
/// order.
void FaceSweep::find_windows(int begin, int end) {
  std::fill_n(windows_.begin(), end - begin, PairTable::Bound{0, kInfinity});
  if (!in_->votes.strict) {
    for (int edge = begin; edge < end; ++edge) {
      take(edge);
      take_depths();
      windows_[edge - begin] = voted_window();
    }
    return;
  }
  const std::vector<int>& next = in_->views[i_].next;
  for (int j = 0; j < static_cast<int>(in_->views.size()); ++j) {
    if (j == i_) continue;
    const PairTable::Bound* bounds = in_->pairs->of(i_, j).bounds.data();
    const std::int32_t* vertices = in_->pairs->of(j, i_).face_start.data();
    for (int edge = begin; edge < end; ++edge) {
      PairTable::Bound& window = windows_[edge - begin];
      const PairTable::Bound &a = bounds[edge], &b = bounds[next[edge]];
      double low = std::min(a.low, b.low), high = std::max(a.high, b.high);
      if (vertices[edge] != vertices[edge + 1] && (low > window.low || high < window.high) &&
          window.low < window.high) {
        take(edge);
        take_depths();
        const PairTable::Bound wider = bound_of(j, low, high);
        low = wider.low;
        high = wider.high;
      }
      window.low = std::max(window.low, low);
      window.high = std::min(window.high, high);
    }
  }
}

/// Where view j can be inside, given where it can on the two rays: its lines reach further where they end within the
/// face.
PairTable::Bound FaceSweep::bound_of(int j, double low, double high) {
  const PairTable &mine = in_->pairs->of(i_, j), &theirs = in_->pairs->of(j, i_);
  const ConeView& other = in_->views[j];
  const double along_baseline = depth_.dot(other.center - in_->views[i_].center);
  for (int at = theirs.face_start[edge_]; at < theirs.face_start[edge_ + 1]; ++at) {
    const int ray = theirs.face_hits[at].ray;
    const double w = w_of(theirs.face_hits[at], other.rays[ray], along_baseline);
    const bool upper = mine.upper[ray] != 0, other_upper = mine.upper[other.prev[ray]] != 0;
    if (upper || other_upper) high = std::max(high, w);
    if (!upper || !other_upper) low = std::min(low, w);
  }
  return {low, high};
}

/// Whether view j's upper bounds all lie above the window and its lower ones below, which is how most views are. False
/// may mean "not seen at a glance".
bool FaceSweep::surely_inside(int j, const PairTable& mine, const PairTable& theirs) {
  const PairTable::Bound &a = mine.bounds[a_], &b = mine.bounds[b_];
  if (!(std::max(a.low, b.low) < keep_low_ && std::min(a.high, b.high) > keep_high_ && mine.is_interval(a_) &&
        mine.is_interval(b_)))
    return false;
  const ConeView& other = in_->views[j];
  const double along_baseline = depth_.dot(other.center - in_->views[i_].center);
  for (int at = theirs.face_start[edge_]; at < theirs.face_start[edge_ + 1]; ++at) {
    const int ray = theirs.face_hits[at].ray;
    const double w = w_of(theirs.face_hits[at], other.rays[ray], along_baseline);
    const bool upper = mine.upper[ray] != 0;
    if (upper != (mine.upper[other.prev[ray]] != 0) || !(upper ? w > keep_high_ : w < keep_low_)) return false;
  }
  return true;
}

PairTable::Bound FaceSweep::voted_window() {
  vote_window_.clear({0, kInfinity});
  for (int j = 0; j < static_cast<int>(in_->views.size()); ++j) {
    if (j == i_) continue;
    const auto& bounds = in_->pairs->of(i_, j).bounds;
    vote_window_.add(bound_of(j, std::min(bounds[a_].low, bounds[b_].low), std::max(bounds[a_].high, bounds[b_].high)),
                     in_->views[j].mandatory);
  }
  return vote_window_.find(in_->votes, in_->views[i_].mandatory);
}

/// Where the ray of a vertex of view j passes through the face.
double FaceSweep::s_of(int j, int ray) const {
  if (in_->grid) {
    const auto [ta, tb] = exact_sides({0, 0, ray, 0}, j);
    return static_cast<double>(ta) / (static_cast<double>(ta) - static_cast<double>(tb));
  }
  const AxisTable& axis = in_->pairs->axis(i_, j);
  const bool forward = i_ < j;
  const auto &own_flat = forward ? axis.low : axis.high, &other_flat = forward ? axis.high : axis.low;
  const Eigen::Vector2d &p = other_flat[ray], &u = own_flat[a_], &v = own_flat[b_];
  const double ta = u.x() * p.y() - u.y() * p.x(), tb = v.x() * p.y() - v.y() * p.x();
  return ta / (ta - tb);
}

void FaceSweep::LineColumns::clear() {
  for (std::vector<double>* column : {&wa, &wb, &left, &right, &low, &high}) column->clear();
}

void FaceSweep::LineColumns::push(const Line& line) {
  wa.push_back(line.wa);
  wb.push_back(line.wb);
  left.push_back(line.left.s);
  right.push_back(line.right.s);
  low.push_back(line.low);
  high.push_back(line.high);
}

void FaceSweep::run_face(FaceOutput& out) {
  lines_.clear();
  columns_.clear();
  exact_.clear();
  views_.clear();
  edges_.clear();
  tie_ = defect_ = unbounded_ = false;
  inside_ = 0;
  const bool strict = in_->votes.strict;
  for (int j = 0; j < static_cast<int>(in_->views.size()); ++j) {
    if (j != i_ && !add_view(j) && strict) return;  // outside all over the window
  }
  order_.resize(views_.size());
  for (std::size_t k = 0; k < order_.size(); ++k) order_[k] = static_cast<int>(k);
  for (const ViewLines& group : views_) {
    for (int f = group.begin; f < group.end && !defect_; ++f) cut_line(f, strict);
  }
  add_ray_edges();
  if (!edges_.empty()) link(out);
  out.tie |= tie_;
  out.unbounded |= unbounded_;
  out.defects += defect_;
}

/// Takes in what view j says about the window; false when it is outside all over it. Most views are inside all over
/// it and have no line there.
bool FaceSweep::add_view(int j) {
  const PairTable &mine = in_->pairs->of(i_, j), &theirs = in_->pairs->of(j, i_);
  if (surely_inside(j, mine, theirs)) {
    inside_ += in_->votes.weight[j];
    return true;
  }
  ViewLines group{j, static_cast<int>(lines_.size()), 0, 0};
  group.state = add_lines(j);
  group.end = static_cast<int>(lines_.size());
  if (group.begin < group.end) {
    views_.push_back(group);
    return true;
  }
  if (group.state > 0) inside_ += in_->votes.weight[j];
  return group.state > 0;
}

/// Makes the lines of a view that reach into the window, and returns its state at s = 0 above them. What the others
/// would say is kept in two ways: those above the window count in that state, and where a kept line ends above the
/// window its end stands for a vertical line from there upwards, so that the states below it are the true ones.
int FaceSweep::add_lines(int j) {
  const PairTable &mine = in_->pairs->of(i_, j), &theirs = in_->pairs->of(j, i_);
  const ConeView& other = in_->views[j];
  const int a = mine.ray_start[a_], a_end = mine.ray_start[a_ + 1], b = mine.ray_start[b_],
            b_end = mine.ray_start[b_ + 1];
  vertices_.clear();
  const double along_baseline = depth_.dot(other.center - in_->views[i_].center);
  for (int at = theirs.face_start[edge_]; at < theirs.face_start[edge_ + 1]; ++at) {
    const PairTable::FaceHit& hit = theirs.face_hits[at];
    vertices_.push_back({w_of(hit, other.rays[hit.ray], along_baseline), hit.ray, theirs.first_id + hit.index});
  }
  // s grows with phi where this face is not an upper bound for the other view's rays; an upper bound of the
  // other view runs towards larger phi.
  const bool s_with_phi = theirs.upper[edge_] == 0;
  const auto runs_right = [&](int edge) { return (mine.upper[edge] != 0) == s_with_phi; };
  const auto vertex_end = [&](int ray, End& end) {
    constexpr std::ptrdiff_t kFew = 8;  // up to here a linear search beats a binary one
    auto at = vertices_.begin();
    if (vertices_.end() - at > kFew)
      at = std::lower_bound(at, vertices_.end(), ray, [](const Vertex& v, int r) { return v.ray < r; });
    while (at != vertices_.end() && at->ray < ray) ++at;
    if (at == vertices_.end() || at->ray != ray) return false;
    end = {0, at->w, ray, at->hit};
    return true;
  };
  const auto ray_end = [&](int edge, int h, double s) {
    while (h < b_end && mine.hits[h].edge != edge) ++h;
    if (h < b_end) return End{s, mine.hits[h].w, kSide, mine.first_id + h};
    defect_ = true;  // only rounding can make a line end nowhere
    return End{};
  };
  int state = mine.top;
  for (int h = a; h < a_end; ++h) {
    const int edge = mine.hits[h].edge;
    End right;
    if (vertices_.empty() || !vertex_end(runs_right(edge) ? other.next[edge] : edge, right)) {
      // Without vertices the same lines meet both rays, in the same order.
      const int same = b + (h - a);
      right = ray_end(edge, same < b_end && mine.hits[same].edge == edge ? same : b, 1);
    }
    const double w = mine.hits[h].w;
    if (!add_line(j, edge, {0, w, kSide, mine.first_id + h}, right) && w > keep_high_) {
      state += mine.upper[edge] ? 1 : -1;
    }
  }
  if (vertices_.empty()) return state;
  for (int h = b; h < b_end; ++h) {
    const int edge = mine.hits[h].edge;
    End left;
    if (!vertex_end(runs_right(edge) ? edge : other.next[edge], left)) continue;  // it came from the other ray
    add_line(j, edge, left, {1, mine.hits[h].w, kSide, mine.first_id + h});
  }
  for (const Vertex& vertex : vertices_) {
    const End here{0, vertex.w, vertex.ray, vertex.hit};
    End after;
    if (!vertex_end(other.next[here.ray], after)) continue;
    const bool right = runs_right(here.ray);
    add_line(j, here.ray, right ? here : after, right ? after : here);
  }
  return state;
}

/// The ends' s are filled in here.
bool FaceSweep::add_line(int j, int edge, End left, End right) {
  const double low = std::min(left.w, right.w), high = std::max(left.w, right.w);
  if (high < keep_low_ || low > keep_high_) return false;
  if (left.ray != kSide) left.s = s_of(j, left.ray);
  if (right.ray != kSide) right.s = s_of(j, right.ray);
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
    line.wa = left.ray == kSide ? left.w : pair.slope[edge].dot(da_);
    line.wb = right.ray == kSide ? right.w : pair.slope[edge].dot(db_);
    columns_.push(line);
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

namespace {
enum Relation : std::uint8_t {
  kBelow = 1,     ///< where the line that is cut is entered, it passes below this one
  kCrosses = 2,
  kFallsBelow = 4,
};
}  // namespace

/// How line f lies to every other line, without a branch: what cut_by_view() finds one by one.
void FaceSweep::relate(int f, double entry) {
  const Line& line = lines_[f];
  const std::size_t count = lines_.size();
  columns_.relation.resize(count);
  const double wa = line.wa, wb = line.wb, right = line.right.s, low = line.low, high = line.high;
  for (std::size_t g = 0; g < count; ++g) {
    const double from = std::max(entry, columns_.left[g]), to = std::min(right, columns_.right[g]);
    const double at_a = wa - columns_.wa[g], change = wb - columns_.wb[g] - at_a;
    const bool below_first = at_a + change * from < 0, below_last = at_a + change * to < 0;
    const bool spans = static_cast<int>(columns_.left[g] <= entry) & static_cast<int>(entry < columns_.right[g]);
    const bool overlap = from < to, under = columns_.low[g] > high, over = columns_.high[g] < low;
    const int mixed = static_cast<int>(overlap) & static_cast<int>(!under) & static_cast<int>(!over);
    const int below = static_cast<int>(spans) &
                      (static_cast<int>(under) | (mixed & static_cast<int>(below_first)));
    const int crosses = mixed & (static_cast<int>(below_first) ^ static_cast<int>(below_last));
    columns_.relation[g] = static_cast<std::uint8_t>(below | crosses * kCrosses |
                                                     static_cast<int>(below_last) * kFallsBelow);
  }
}

bool FaceSweep::tally_view(int f, const End& entry, const ViewLines& other, bool strict, int& inside) {
  const std::size_t before_count = crossings_.size();
  int state = other.state;
  for (int g = other.begin; g < other.end; ++g) {
    const Line& cutter = lines_[g];
    const int relation = columns_.relation[g], sign = cutter.upper ? 1 : -1;
    if (relation & kBelow) state += sign;
    if (static_cast<int>(cutter.left_above) | static_cast<int>(cutter.right_above)) {
      const bool starts_later = entry.s < cutter.left.s, spans = !starts_later && entry.s < cutter.right.s;
      if (!starts_later) state += (cutter.right_above && !spans ? sign : 0) - (cutter.left_above ? sign : 0);
    }
    if (relation & kCrosses) add_crossing(f, g, entry, (relation & kFallsBelow) != 0);
  }
  if (strict && state <= 0 && crossings_.size() == before_count) return false;
  if (state > 0) inside += in_->votes.weight[other.view];
  return true;
}

/// Falling below an upper bound enters its view.
void FaceSweep::add_crossing(int f, int g, const End& entry, bool falls) {
  const Line &line = lines_[f], &cutter = lines_[g];
  const double from = std::max(entry.s, cutter.left.s), to = std::min(line.right.s, cutter.right.s);
  const double at_a = line.wa - cutter.wa, at_b = line.wb - cutter.wb;
  double s = at_a / (at_a - at_b);
  s = s >= from ? std::min(s, to) : from;  // also when both lines are one and s is not a number
  crossings_.push_back({s, g, static_cast<std::int8_t>(falls == cutter.upper ? 1 : -1)});
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
    add_crossing(f, g, entry, first > 0);
  }
  if (strict && state <= 0 && crossings_.size() == before_count) return false;
  if (state > 0) inside += in_->votes.weight[other.view];
  return true;
}

void FaceSweep::cut_line(int f, bool strict) {
  crossings_.clear();
  const End entry = entry_of(lines_[f]);
  int inside = inside_;
  const bool fast = in_->cull && !in_->grid;
  if (fast) relate(f, entry.s);
  for (std::size_t k = 0; k < order_.size(); ++k) {
    const ViewLines& other = views_[order_[k]];
    if (other.view == lines_[f].view) continue;
    if (fast ? tally_view(f, entry, other, strict, inside) : cut_by_view(f, entry, other, strict, inside)) continue;
    std::swap(order_[k], order_[k / 2]);  // it will soon be asked early
    return;
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
