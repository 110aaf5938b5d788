#include "calib/coverage.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

#include <Eigen/Dense>

#include "core/text.h"

namespace floatstage::calib {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

// How a flat board lies in a picture, as far as a parallel projection tells: px a metre and the compression
// along the picture's axes, both as if the lens were straight. Good enough to say what is missing.
struct Lie {
  double size = 0;
  double turned = 0, leaned = 0;  // degrees
};

std::optional<Lie> lie_of(const Target& target, const TargetView& view) {
  if (target.kind != TargetKind::Board || view.points.size() < 4) return std::nullopt;
  Eigen::Vector2d mean_p = Eigen::Vector2d::Zero(), mean_b = Eigen::Vector2d::Zero();
  const auto on_board = [&](const SeenPoint& p) {
    return Eigen::Vector2d(target.points[at(point_index(target, p.id))].position.head<2>());
  };
  for (const SeenPoint& p : view.points) mean_p += p.pixel, mean_b += on_board(p);
  mean_p /= static_cast<double>(view.points.size());
  mean_b /= static_cast<double>(view.points.size());
  Eigen::Matrix2d pb = Eigen::Matrix2d::Zero(), bb = Eigen::Matrix2d::Zero();
  for (const SeenPoint& p : view.points) {
    const Eigen::Vector2d b = on_board(p) - mean_b;
    pb += (p.pixel - mean_p) * b.transpose();
    bb += b * b.transpose();
  }
  if (bb.determinant() < 1e-3 * bb.trace() * bb.trace() * 0.25) return std::nullopt;  // nearly one line
  const Eigen::JacobiSVD<Eigen::Matrix2d> svd(Eigen::Matrix2d(pb * bb.inverse()), Eigen::ComputeFullU);
  Lie lie;
  lie.size = svd.singularValues()[0];
  if (!(lie.size > 0)) return std::nullopt;
  const double tilt =
      std::acos(std::clamp(svd.singularValues()[1] / lie.size, 0.0, 1.0)) * 180 / std::numbers::pi;
  // The direction in which the picture of the board is short.
  const Eigen::Vector2d along = svd.matrixU().col(1).cwiseAbs();
  lie.turned = tilt * along.x();
  lie.leaned = tilt * along.y();
  return lie;
}

double diagonal(const Target& target) {
  Eigen::AlignedBox3d box;
  for (const TargetPoint& p : target.points) box.extend(p.position);
  return box.diagonal().norm();
}

const char* kAcross[] = {"left", "middle", "right"};
const char* kDown[] = {"upper", "middle", "lower"};

// The emptiest ninth of a picture, in words; absent when every ninth has something in half of its cells.
std::optional<std::string> empty_region(const CameraCoverage& c) {
  double least = 0.5;
  std::optional<std::string> name;
  for (int v = 0; v < 3; ++v)
    for (int u = 0; u < 3; ++u) {
      int filled = 0, all = 0;
      for (int row = v * kCoverageRows / 3; row < (v + 1) * kCoverageRows / 3; ++row)
        for (int column = u * kCoverageColumns / 3; column < (u + 1) * kCoverageColumns / 3; ++column, ++all)
          filled += c.cells[at(row * kCoverageColumns + column)] > 0;
      const double share = static_cast<double>(filled) / all;
      if (share >= least) continue;
      least = share;
      name = u == 1 && v == 1 ? "middle"
             : v == 1         ? text(kAcross[u], " side")
             : u == 1         ? text(kDown[v], " side")
                              : text(kDown[v], " ", kAcross[u], " corner");
    }
  return name;
}

std::vector<int> groups_of(const std::vector<std::vector<int>>& common) {
  std::vector<int> group(common.size());
  std::iota(group.begin(), group.end(), 0);
  for (std::size_t a = 0; a < common.size(); ++a)
    for (std::size_t b = 0; b < common.size(); ++b)
      if (common[a][b] > 0 && group[a] != group[b]) {
        const int from = std::max(group[a], group[b]), to = std::min(group[a], group[b]);
        std::replace(group.begin(), group.end(), from, to);
      }
  return group;
}

struct Link {
  int a = 0, b = 0, frames = 0;
};

// The links of a greatest spanning forest: what holds the rig together, the strongest first.
std::vector<Link> backbone(const Coverage& c) {
  std::vector<Link> all, out;
  const auto n = static_cast<int>(c.cameras.size());
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b)
      if (c.common[at(a)][at(b)] > 0) all.push_back({a, b, c.common[at(a)][at(b)]});
  std::stable_sort(all.begin(), all.end(), [](const Link& x, const Link& y) { return x.frames > y.frames; });
  std::vector<int> group(at(n));
  std::iota(group.begin(), group.end(), 0);
  for (const Link& l : all) {
    const int from = group[at(l.b)], to = group[at(l.a)];
    if (from == to) continue;
    std::replace(group.begin(), group.end(), from, to);
    out.push_back(l);
  }
  return out;
}

bool is_board(const CameraCoverage& c) { return c.farthest > 0; }

}  // namespace

Coverage coverage_of(const Observations& o) {
  Coverage out;
  std::map<std::pair<int, int>, std::set<int>> seen_by;  // target and frame → cameras
  for (const CalibrationCamera& c : o.cameras) {
    out.cameras.emplace_back();
    out.cameras.back().serial = c.serial;
  }
  for (const TargetView& v : o.views) {
    CameraCoverage& c = out.cameras[at(v.camera)];
    const CalibrationCamera& camera = o.cameras[at(v.camera)];
    ++c.views;
    seen_by[{v.target, v.frame}].insert(v.camera);
    for (const SeenPoint& p : v.points) {
      const int column = static_cast<int>(p.pixel.x() / camera.width * kCoverageColumns),
                row = static_cast<int>(p.pixel.y() / camera.height * kCoverageRows);
      if (column >= 0 && column < kCoverageColumns && row >= 0 && row < kCoverageRows)
        ++c.cells[at(row * kCoverageColumns + column)];
    }
    const std::optional<Lie> lie = lie_of(o.targets[at(v.target)], v);
    if (!lie) continue;
    c.nearest = std::max(c.nearest, lie->size);
    c.farthest = c.farthest > 0 ? std::min(c.farthest, lie->size) : lie->size;
    c.fills = std::max(c.fills, lie->size * diagonal(o.targets[at(v.target)]) / camera.width);
    c.turned += lie->turned > kTilted;
    c.leaned += lie->leaned > kTilted;
    c.facing += lie->turned <= kTilted && lie->leaned <= kTilted;
  }
  for (CameraCoverage& c : out.cameras)
    c.covered =
        static_cast<double>(std::count_if(c.cells.begin(), c.cells.end(), [](int n) { return n > 0; })) /
        static_cast<double>(c.cells.size());
  out.common.assign(o.cameras.size(), std::vector<int>(o.cameras.size()));
  for (const auto& [frame, cameras] : seen_by)
    for (const int a : cameras)
      for (const int b : cameras)
        if (a != b) ++out.common[at(a)][at(b)];
  out.group = groups_of(out.common);
  return out;
}

std::vector<Advice> advise(const Coverage& c, const CoverageGoals& goals) {
  std::vector<Advice> out;
  const auto n = static_cast<int>(c.cameras.size());
  const auto serial = [&](int i) { return c.cameras[at(i)].serial; };
  for (int i = 0; i < n; ++i)
    if (c.cameras[at(i)].views == 0)
      out.push_back({AdviceKind::NeverSeen, serial(i), "",
                     text("show the target to camera '", serial(i), "': it has not seen it yet")});
  // One camera of each group that is not the first's, with the camera of another group that has seen most.
  std::set<int> told;
  for (int i = 0; i < n; ++i) {
    if (c.group[at(i)] == c.group[0] || c.cameras[at(i)].views == 0 || !told.insert(c.group[at(i)]).second)
      continue;
    // Neighbours in the list mostly stand beside each other; a ring closes.
    int best = -1;
    for (int step = 1; step < n && best < 0; ++step)
      for (const int k : {(i + n - step) % n, (i + step) % n})
        if (best < 0 && c.group[at(k)] != c.group[at(i)] && c.cameras[at(k)].views > 0) best = k;
    if (best >= 0)
      out.push_back({AdviceKind::NoCommonView, serial(i), serial(best),
                     text("show the target to cameras '", serial(i), "' and '", serial(best),
                          "' at once: nothing joins '", serial(i), "' to the others yet")});
  }
  for (const Link& l : backbone(c))
    if (l.frames < goals.common)
      out.push_back({AdviceKind::WeakLink, serial(l.a), serial(l.b),
                     text("show the target to cameras '", serial(l.a), "' and '", serial(l.b),
                          "' at once: only ", l.frames, " common views, ", goals.common, " are wanted")});
  for (const CameraCoverage& v : c.cameras)
    if (v.views > 0 && v.views < goals.views)
      out.push_back({AdviceKind::FewViews, v.serial, "",
                     text("more views for camera '", v.serial, "': ", v.views, " of ", goals.views)});
  for (const CameraCoverage& v : c.cameras) {
    if (v.views == 0) continue;
    if (v.covered < goals.covered)
      if (const std::optional<std::string> region = empty_region(v))
        out.push_back({AdviceKind::Region, v.serial, "",
                       text("hold it into the ", *region, " of camera '", v.serial, "'")});
    if (!is_board(v)) continue;
    if (v.depth_ratio() < goals.depth_ratio) {
      constexpr double kFilled = 0.6;
      const bool nearer = v.fills < kFilled;
      out.push_back(
          {nearer ? AdviceKind::Nearer : AdviceKind::Farther, v.serial, "",
           text("hold it ", nearer ? "nearer to" : "farther from", " camera '", v.serial,
                "': its distances differ by a factor of only ", std::round(10 * v.depth_ratio()) / 10)});
    }
    if (v.turned < goals.tilted)
      out.push_back({AdviceKind::Turn, v.serial, "",
                     text("turn it to the left and right before camera '", v.serial, "'")});
    if (v.leaned < goals.tilted)
      out.push_back(
          {AdviceKind::Lean, v.serial, "", text("lean it forward and back before camera '", v.serial, "'")});
  }
  return out;
}

double completeness(const Coverage& c, const CoverageGoals& goals) {
  double reached = 0, wanted = 0;
  const auto add = [&](double have, double want) {
    reached += std::clamp(have / want, 0.0, 1.0);
    wanted += 1;
  };
  for (const CameraCoverage& v : c.cameras) {
    add(v.views, goals.views);
    add(v.covered, goals.covered);
    if (v.views > 0 && !is_board(v)) continue;  // a wand has neither
    add(v.depth_ratio() - 1, goals.depth_ratio - 1);
    add(v.turned, goals.tilted);
    add(v.leaned, goals.tilted);
  }
  std::vector<Link> links = backbone(c);
  for (std::size_t i = 0; i + 1 < c.cameras.size(); ++i)
    add(i < links.size() ? links[i].frames : 0, goals.common);
  return wanted > 0 ? reached / wanted : 0;
}

}  // namespace floatstage::calib
