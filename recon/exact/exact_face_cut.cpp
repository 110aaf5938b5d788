#include <algorithm>
#include <bit>
#include <cmath>

#include "recon/exact/exact_face.h"

// Cutting a face's lines at their crossings, and finding which stretches of them are the hull's.

namespace floatstage::recon {
namespace {

constexpr std::size_t kProbes = 4;  // views that are asked one by one before the buckets are
constexpr int kWide = 96;           // more lines are sorted into buckets before they are related
constexpr double kMargin = 1e-9;    // of s, by which lines reach into the neighbouring bucket
constexpr double kLong = 1.0 / 16;  // of s: such a line is related to all others
constexpr int kMostBuckets = 4096;

double w_at(double wa, double wb, double s) { return wa + (wb - wa) * s; }

}  // namespace

void FaceSweep::start_cutting() {
  const int count = static_cast<int>(lines_.size());
  order_.resize(views_.size());
  for (std::size_t k = 0; k < order_.size(); ++k) order_[k] = static_cast<int>(k);
  is_wide_ = in_->cull && count > kWide;
  if (is_wide_) fill_buckets();
  if (in_->cull && !in_->grid) fill_blocks();
}

/// The states of the other views are true in the window only: there the line is followed from where it
/// enters.
FaceSweep::End FaceSweep::entry_of(const Line& line) const {
  const double w = line.left.w;
  if (w >= keep_low_ && w <= keep_high_) return line.left;
  const double level = w > keep_high_ ? keep_high_ : keep_low_, s = (level - line.wa) / (line.wb - line.wa);
  return {s >= line.left.s ? std::min(s, line.right.s) : line.left.s, level, kClipped, -1};
}

/// The lines once more, as relate_kernel() reads them.
void FaceSweep::fill_blocks() {
  std::size_t needed = 0;
  for (ViewLines& group : views_) {
    group.first_block = static_cast<int>(needed);
    needed += static_cast<std::size_t>(group.end - group.begin + LineBlock::kLines - 1) / LineBlock::kLines;
  }
  if (blocks_.size() < needed) blocks_.resize(needed);
  const Line* const lines = lines_.data();
  for (const ViewLines& group : views_) {
    LineBlock* block = blocks_.data() + group.first_block;
    for (int first = group.begin; first < group.end; first += LineBlock::kLines, ++block) {
      const int count = std::min(group.end - first, LineBlock::kLines);
      unsigned upper = 0, left_above = 0, right_above = 0;
      for (int k = 0; k < count; ++k) {
        const Line& line = lines[first + k];
        block->wa[k] = line.wa;
        block->wb[k] = line.wb;
        block->left[k] = line.left.s;
        block->right[k] = line.right.s;
        block->low[k] = line.low;
        block->high[k] = line.high;
        upper |= static_cast<unsigned>(line.upper) << k;
        left_above |= static_cast<unsigned>(line.left_above) << k;
        right_above |= static_cast<unsigned>(line.right_above) << k;
      }
      block->used = static_cast<std::uint8_t>((1U << count) - 1);
      block->upper = static_cast<std::uint8_t>(upper);
      block->left_above = static_cast<std::uint8_t>(left_above);
      block->right_above = static_cast<std::uint8_t>(right_above);
    }
  }
}

/// What cut_by_view() finds line by line.
bool FaceSweep::tally_view(int f, const End& entry, const ViewLines& other, bool strict, int& inside) {
  const Line& line = lines_[f];
  const CutLine cut{line.wa, line.wb, entry.s, line.right.s, line.low, line.high};
  const std::size_t before_count = crossings_.size();
  int state = other.state;
  const LineBlock* block = blocks_.data() + other.first_block;
  for (int first = other.begin; first < other.end; first += LineBlock::kLines, ++block) {
    const BlockRelation relation = relate_(*block, cut);
    state += relation.change;
    for (unsigned bits = relation.crosses; bits != 0; bits &= bits - 1) {
      const int k = std::countr_zero(bits);
      add_crossing(f, first + k, entry, (relation.falls_below >> k & 1) != 0);
    }
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

/// What line g does to line f: a crossing, or its part of the state of its view where f is entered.
void FaceSweep::meet(int f, int g, const End& entry, int& state) {
  const Line &line = lines_[f], &cutter = lines_[g];
  const int sign = cutter.upper ? 1 : -1;  // of passing it downwards
  const bool starts_later = before(entry, line.view, cutter.left, cutter.view);
  const bool spans = !starts_later && before(entry, line.view, cutter.right, cutter.view);
  if (!starts_later) state += (cutter.right_above && !spans ? sign : 0) - (cutter.left_above ? sign : 0);
  if (cutter.high < line.low) return;
  if (cutter.low > line.high) {
    if (spans) state += sign;
    return;
  }
  const bool ends_earlier = before(cutter.right, cutter.view, line.right, line.view);
  const End &from = starts_later ? cutter.left : entry, &to = ends_earlier ? cutter.right : line.right;
  const int from_view = starts_later ? cutter.view : line.view,
            to_view = ends_earlier ? cutter.view : line.view;
  if (!before(from, from_view, to, to_view)) return;
  const int first = side(f, g, from, from_view), last = side(f, g, to, to_view);
  if (spans && first < 0) state += sign;
  if (first == last) return;
  add_crossing(f, g, entry, first > 0);
}

bool FaceSweep::cut_by_view(int f, const End& entry, const ViewLines& other, bool strict, int& inside) {
  const std::size_t before_count = crossings_.size();
  int state = other.state;
  for (int g = other.begin; g < other.end; ++g) meet(f, g, entry, state);
  if (strict && state <= 0 && crossings_.size() == before_count) return false;
  if (state > 0) inside += in_->votes.weight[other.view];
  return true;
}

/// Long faces, such as those behind the border of a picture, meet thousands of lines, most of them short.
void FaceSweep::fill_buckets() {
  const int count = static_cast<int>(lines_.size());
  // As many buckets as short lines fit side by side: then a line reaches two of them on average.
  double length = 0;
  int shorts = 0;
  for (const Line& line : lines_) {
    if (is_long(line)) continue;
    length += line.right.s - line.left.s;
    ++shorts;
  }
  bucket_count_ = std::clamp(static_cast<int>(shorts / std::max(length, 1e-3)), 1, kMostBuckets);
  long_.clear();
  reach_.resize(lines_.size());
  bucket_start_.assign(static_cast<std::size_t>(bucket_count_) + 2, 0);
  above_.clear();
  for (std::size_t k = 0; k < views_.size(); ++k) {
    for (int f = views_[k].begin; f < views_[k].end; ++f) {
      const Line& line = lines_[f];
      reach_[f] = {bucket_of(line.left.s - kMargin), bucket_of(line.right.s + kMargin), static_cast<int>(k)};
      if (is_long(line)) {
        long_.push_back(f);
        continue;
      }
      if (line.left_above || line.right_above) above_.push_back(f);
      for (int bucket = reach_[f].first; bucket <= reach_[f].last; ++bucket) ++bucket_start_[bucket + 2];
    }
  }
  for (int bucket = 0; bucket <= bucket_count_; ++bucket) bucket_start_[bucket + 1] += bucket_start_[bucket];
  bucket_lines_.resize(static_cast<std::size_t>(bucket_start_[bucket_count_ + 1]));
  for (int f = 0; f < count; ++f) {
    if (is_long(lines_[f])) continue;
    for (int bucket = reach_[f].first; bucket <= reach_[f].last; ++bucket)
      bucket_lines_[bucket_start_[bucket + 1]++] = f;
  }
}

bool FaceSweep::is_long(const Line& line) { return !(line.right.s - line.left.s < kLong); }

int FaceSweep::bucket_of(double s) const {
  // Written so that what is not a number goes to the first bucket.
  return s > 0 ? std::min(static_cast<int>(std::min(s, 1.0) * bucket_count_), bucket_count_ - 1) : 0;
}

/// The same as asking every view, but only of lines that share a stretch of s with line f.
bool FaceSweep::cut_in_buckets(int f, const End& entry, bool strict, int& inside) {
  states_.resize(views_.size());
  for (std::size_t k = 0; k < views_.size(); ++k) states_[k] = {views_[k].state, false};
  const auto ask = [&](int g) {
    ++related_;
    const std::size_t before_count = crossings_.size();
    meet(f, g, entry, states_[reach_[g].view].first);
    states_[reach_[g].view].second |= crossings_.size() != before_count;
  };
  const int own = reach_[f].view, first = bucket_of(entry.s - kMargin), last = reach_[f].last;
  for (int bucket = first; bucket <= last; ++bucket) {
    for (int at = bucket_start_[bucket]; at < bucket_start_[bucket + 1]; ++at) {
      const int g = bucket_lines_[at];
      // Each line once, where the two first share a bucket.
      if (reach_[g].view == own || std::max(reach_[g].first, first) != bucket) continue;
      ask(g);
    }
  }
  for (const int g : long_) {
    if (reach_[g].view != own) ask(g);
  }
  for (const int g : above_) {
    if (reach_[g].last >= first || reach_[g].view == own) continue;
    const int sign = lines_[g].upper ? 1 : -1;
    states_[reach_[g].view].first += (lines_[g].right_above ? sign : 0) - (lines_[g].left_above ? sign : 0);
  }
  for (std::size_t k = 0; k < views_.size(); ++k) {
    if (static_cast<int>(k) == own) continue;
    if (states_[k].first > 0) {
      inside += in_->votes.weight[views_[k].view];
    } else if (strict && !states_[k].second) {
      const auto at = std::find(order_.begin(), order_.end(), static_cast<int>(k));
      std::iter_swap(at, order_.begin() + (at - order_.begin()) / 2);
      return false;
    }
  }
  return true;
}

void FaceSweep::cut_line(int f, bool strict) {
  crossings_.clear();
  const End entry = entry_of(lines_[f]);
  int inside = inside_;
  // Most lines are outside all along in one of the views that are asked first.
  const bool fast = in_->cull && !in_->grid;
  const std::size_t asked =
      is_wide_ ? std::min<std::size_t>(order_.size(), strict ? kProbes : 0) : order_.size();
  for (std::size_t k = 0; k < asked; ++k) {
    const ViewLines& other = views_[order_[k]];
    if (other.view == lines_[f].view) continue;
    related_ += other.end - other.begin;
    if (fast ? tally_view(f, entry, other, strict, inside) : cut_by_view(f, entry, other, strict, inside))
      continue;
    std::swap(order_[k], order_[k / 2]);  // it will soon be asked early
    return;
  }
  if (is_wide_) {
    crossings_.clear();
    inside = inside_;
    if (!cut_in_buckets(f, entry, strict, inside)) return;
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
    const auto numbered = [&](int index) {
      const int number = first_line_ + index;
      return static_cast<std::uint64_t>(number);
    };
    const std::uint64_t low = numbered(std::min(f, c.line)), high = numbered(std::max(f, c.line));
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

}  // namespace floatstage::recon
