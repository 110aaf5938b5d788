// Method:  a sweep along s in the plane of one contour edge, where planes of other views are straight lines
// Paper:   none: a line sweep over segments that are cut where they cross, in the coordinates X = C +
//          ((1-s) da + s db) / w
// Differs: vertices have names instead of places, so that neighbouring faces meet without a tolerance
// ADR:     0070, 0074

#include "recon/exact/exact_face.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace floatstage::recon {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSlack = 1e-9;    // widens windows that only save work
constexpr std::size_t kMany = 24;  // lines, from which a window is worth splitting

}  // namespace

void FaceOutput::clear() {
  corners.clear();
  polygon_start.assign(1, 0);
  faces.clear();
  lines = relations = 0;
  defects = 0;
  unbounded = tie = too_many = false;
}

void FaceSweep::run(int view, int begin, int end, FaceOutput& out) {
  i_ = view;
  made_ = related_ = 0;
  most_related_ = in_->most_relations - out.relations;
  find_windows(begin, end);
  for (int edge = begin; edge < end && related_ <= most_related_; ++edge) {
    const PairTable::Bound& window = windows_[edge - begin];
    if (!(window.low < window.high)) continue;
    take(edge);
    take_depths();
    if (!depth_.allFinite()) {  // an edge without length: only moving its ends helps
      ++out.defects;
      continue;
    }
    edges_.clear();
    first_line_ = 0;
    tie_ = defect_ = unbounded_ = false;
    sweep(in_->cull ? window : PairTable::Bound{-kInfinity, kInfinity});
    add_ray_edges();
    if (!edges_.empty()) link(out);
    out.tie |= tie_;
    out.unbounded |= unbounded_;
    out.defects += defect_;
  }
  out.lines += made_;
  out.relations += related_;
  out.too_many |= related_ > most_related_;
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

/// The range of w in which each face can have hull at all. One view after the other, so that its tables are
/// read in order.
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

/// Where view j can be inside, given where it can on the two rays: its lines reach further where they end
/// within the face.
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

PairTable::Bound FaceSweep::voted_window() {
  vote_window_.clear({0, kInfinity});
  for (int j = 0; j < static_cast<int>(in_->views.size()); ++j) {
    if (j == i_) continue;
    const auto& bounds = in_->pairs->of(i_, j).bounds;
    vote_window_.add(
        bound_of(j, std::min(bounds[a_].low, bounds[b_].low), std::max(bounds[a_].high, bounds[b_].high)),
        in_->views[j].mandatory);
  }
  return vote_window_.find(in_->votes, in_->views[i_].mandatory);
}

/// Finds the runs of hull boundary in a window of w.
void FaceSweep::sweep(const PairTable::Bound& window) {
  keep_low_ = window.low * (1 - kSlack);
  keep_high_ = window.high * (1 + kSlack);
  lines_.clear();
  exact_.clear();
  views_.clear();
  inside_ = 0;
  const bool strict = in_->votes.strict;
  for (int j = 0; j < static_cast<int>(in_->views.size()); ++j) {
    if (j != i_ && !add_view(j) && strict) return;  // outside all over the window
  }
  find_runs(0);
}

/// Those of the window whose lines were made.
void FaceSweep::find_runs(std::size_t depth) {
  const bool strict = in_->votes.strict;
  made_ += static_cast<std::int64_t>(lines_.size());
  if (strict && in_->cull && depth < splits_.size() && lines_.size() > kMany) {
    Split& split = splits_[depth];
    if (split_window(split.parts)) {
      // Copied, not swapped: memory that changed places would have to grow anew in later frames.
      split.lines = lines_;
      split.exact = exact_;
      split.views = views_;
      split.inside = inside_;
      for (const PairTable::Bound& part : split.parts)
        if (take_part(split, part)) find_runs(depth + 1);
      return;
    }
  }
  start_cutting();
  for (const ViewLines& group : views_) {
    for (int f = group.begin; f < group.end && !defect_ && related_ <= most_related_; ++f)
      cut_line(f, strict);
  }
  first_line_ += static_cast<int>(lines_.size());
}

/// The lines of a window that reach into a part of it, as if they were made anew; false when some view is
/// outside all over it.
bool FaceSweep::take_part(const Split& whole, const PairTable::Bound& part) {
  keep_low_ = part.low * (1 - kSlack);
  keep_high_ = part.high * (1 + kSlack);
  lines_.clear();
  exact_.clear();
  views_.clear();
  inside_ = whole.inside;
  for (const ViewLines& all : whole.views) {
    ViewLines group{all.view, static_cast<int>(lines_.size()), 0, all.state};
    for (int f = all.begin; f < all.end; ++f) {
      const Line& line = whole.lines[f];
      if (line.high < keep_low_ || line.low > keep_high_) {
        if (line.left.ray == kSide && line.left.w > keep_high_) group.state += line.upper ? 1 : -1;
        continue;
      }
      Line& kept = lines_.emplace_back(line);
      kept.left_above = line.left.ray != kSide && line.left.w > keep_high_;
      kept.right_above = line.right.ray != kSide && line.right.w > keep_high_;
      if (in_->grid) exact_.push_back(whole.exact[f]);
    }
    group.end = static_cast<int>(lines_.size());
    if (group.begin < group.end)
      views_.push_back(group);
    else if (group.state > 0)
      inside_ += in_->votes.weight[group.view];
    else
      return false;
  }
  return true;
}

/// Leaves out of the window the ranges of w in which some view has no line and is outside. Views that the
/// subject fills to the border have their inside in several ranges, and only together leave little. False
/// when that leaves out hardly any.
bool FaceSweep::split_window(std::vector<PairTable::Bound>& parts) {
  parts.assign(1, {keep_low_, keep_high_});
  const auto leave_out = [&](double low, double high) {
    low *= 1 + kSlack;
    high *= 1 - kSlack;
    if (!(low < high)) return;
    for (std::size_t p = parts.size(); p-- > 0;) {
      PairTable::Bound& part = parts[p];
      if (high <= part.low || low >= part.high) continue;
      const PairTable::Bound above{high, part.high};
      part.high = low;
      const bool has_below = part.low < part.high, has_above = above.low < above.high;
      if (has_below && has_above) {
        parts.push_back(above);
      } else if (has_above) {
        part = above;
      } else if (!has_below) {
        part = parts.back();
        parts.pop_back();
      }
    }
  };
  for (const ViewLines& group : views_) {
    downwards_.clear();
    for (int f = group.begin; f < group.end; ++f) {
      const Line& line = lines_[f];
      downwards_.push_back({line.high, line.low, line.left.ray != kSide ? 0 : (line.upper ? 1 : -1)});
    }
    std::sort(downwards_.begin(), downwards_.end(),
              [](const Extent& x, const Extent& y) { return x.high > y.high; });
    double level = keep_high_;  // down to which the lines so far reach
    int state = group.state;
    for (const Extent& extent : downwards_) {
      if (extent.high < level && state <= 0) leave_out(extent.high, level);
      level = std::min(level, extent.low);
      state += extent.change;
    }
    if (state <= 0) leave_out(keep_low_, level);
  }
  std::size_t left = 0;
  for (const Line& line : lines_) {
    for (const PairTable::Bound& part : parts) left += line.high >= part.low && line.low <= part.high;
  }
  return 4 * left < 3 * lines_.size();
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

}  // namespace floatstage::recon
