#include <algorithm>
#include <cmath>

#include "recon/exact/exact_face.h"

// Which lines of the other views reach into a face's window, and what the others say about it.

namespace floatstage::recon {

/// Takes in what view j says about the window; false when it is outside all over it. Most views are inside
/// all over it and have no line there.
bool FaceSweep::add_view(int j) {
  const PairTable &mine = in_->pairs->of(i_, j), &theirs = in_->pairs->of(j, i_);
  const ConeView& other = in_->views[j];
  const double along_baseline = depth_.dot(other.center - in_->views[i_].center);
  const PairTable::Bound &a = mine.bounds[a_], &b = mine.bounds[b_];
  // Whether the view's upper bounds all lie above the window and its lower ones below.
  bool inside = std::max(a.low, b.low) < keep_low_ && std::min(a.high, b.high) > keep_high_ &&
                mine.is_interval(a_) && mine.is_interval(b_);
  const int first = theirs.face_start[edge_], last = theirs.face_start[edge_ + 1];
  vertices_.resize(static_cast<std::size_t>(last - first));
  Vertex* vertex = vertices_.data();
  for (int at = first; at < last; ++at, ++vertex) {
    const PairTable::FaceHit& hit = theirs.face_hits[at];
    const double w = w_of(hit, other.rays[hit.ray], along_baseline);
    *vertex = {w, hit.ray, theirs.first_id + hit.index};
    if (!inside) continue;
    const bool upper = mine.upper[hit.ray] != 0;
    inside = upper == (mine.upper[other.prev[hit.ray]] != 0) && (upper ? w > keep_high_ : w < keep_low_);
  }
  if (inside) {
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

/// Makes the lines of a view that reach into the window, and returns its state at s = 0 above them. What the
/// others would say is kept in two ways: those above the window count in that state, and where a kept line
/// ends above the window its end stands for a vertical line from there upwards, so that the states below it
/// are the true ones.
int FaceSweep::add_lines(int j) {
  const PairTable &mine = in_->pairs->of(i_, j), &theirs = in_->pairs->of(j, i_);
  const int a = mine.ray_start[a_], a_end = mine.ray_start[a_ + 1], b = mine.ray_start[b_],
            b_end = mine.ray_start[b_ + 1];
  const std::size_t rays = in_->views[j].next.size(), vertices = vertices_.size();
  if (vertex_of_ray_.size() < rays) vertex_of_ray_.resize(rays, 0);
  // Read without a check of every index: these loops are half of what making lines costs.
  const int* const next = in_->views[j].next.data();
  const RayHit* const hits = mine.hits.data();
  const std::uint8_t* const upper = mine.upper.data();
  const Vertex* const vertex = vertices_.data();
  int* const vertex_of_ray = vertex_of_ray_.data();
  for (std::size_t v = 0; v < vertices; ++v) vertex_of_ray[vertex[v].ray] = static_cast<int>(v) + 1;
  // s grows with phi where this face is not an upper bound for the other view's rays; an upper bound of the
  // other view runs towards larger phi.
  const bool s_with_phi = theirs.upper[edge_] == 0;
  const auto runs_right = [&](int edge) { return (upper[edge] != 0) == s_with_phi; };
  const auto reaches = [&](double v, double w) {
    return !(std::max(v, w) < keep_low_ || std::min(v, w) > keep_high_);
  };
  const auto vertex_end = [&](int number) {
    const Vertex& end = vertex[number - 1];
    return End{s_of(j, end.ray), end.w, end.ray, end.hit};
  };
  const auto hit_end = [&](int h, double s) { return End{s, hits[h].w, kSide, mine.first_id + h}; };
  int state = mine.top;
  for (int h = a; h < a_end; ++h) {
    const int edge = hits[h].edge, number = vertex_of_ray[runs_right(edge) ? next[edge] : edge];
    const double w = hits[h].w;
    int other = b;  // without vertices the same lines meet both rays, in the same order
    double other_w;
    if (number != 0) {
      other_w = vertex[number - 1].w;
    } else {
      if (b + (h - a) < b_end && hits[b + (h - a)].edge == edge) other = b + (h - a);
      while (other < b_end && hits[other].edge != edge) ++other;
      if (other == b_end) {
        defect_ = true;  // only rounding can make a line end nowhere
        continue;
      }
      other_w = hits[other].w;
    }
    if (reaches(w, other_w)) {
      add_line(j, edge, hit_end(h, 0), number != 0 ? vertex_end(number) : hit_end(other, 1));
    } else if (w > keep_high_) {
      state += upper[edge] ? 1 : -1;
    }
  }
  if (vertices == 0) return state;
  for (int h = b; h < b_end; ++h) {
    const int edge = hits[h].edge, number = vertex_of_ray[runs_right(edge) ? edge : next[edge]];
    if (number == 0) continue;  // it came from the other ray
    if (reaches(vertex[number - 1].w, hits[h].w)) add_line(j, edge, vertex_end(number), hit_end(h, 1));
  }
  for (std::size_t v = 0; v < vertices; ++v) {
    const int edge = vertex[v].ray, here = static_cast<int>(v) + 1, after = vertex_of_ray[next[edge]];
    if (after == 0 || !reaches(vertex[v].w, vertex[after - 1].w)) continue;
    const bool right = runs_right(edge);
    add_line(j, edge, vertex_end(right ? here : after), vertex_end(right ? after : here));
  }
  for (std::size_t v = 0; v < vertices; ++v) vertex_of_ray[vertex[v].ray] = 0;
  return state;
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

void FaceSweep::add_line(int j, int edge, const End& left, const End& right) {
  const PairTable& pair = in_->pairs->of(i_, j);
  Line& line = lines_.emplace_back();
  line.low = std::min(left.w, right.w);
  line.high = std::max(left.w, right.w);
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
  }
}

}  // namespace floatstage::recon
