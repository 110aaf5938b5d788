// Parents finding: M. Eisemann, "Error-Concealed Image-Based Rendering", section 4.2.1, with D. Lowe's ratio
// test (IJCV 2004), RANSAC (M. Fischler, R. Bolles 1981) and the direct linear transform (R. Hartley, A.
// Zisserman, "Multiple View Geometry", 4.1). Differs: matches are one to one, and ten must lie on the
// homography, because ten raw matches alone are met by unrelated photographs; a second, guided matching feeds
// the fit (ADR 0214).

#include "detail/pair_relation.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include <opencv2/calib3d.hpp>

#include "core/statistics.h"
#include "core/text.h"
#include "detail/quad.h"

namespace floatstage::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

constexpr int kFewest = 10;
constexpr float kDecide = 0.49F * 0.49F, kRefit = 0.8F * 0.8F;  // of squared distances
constexpr double kRansacPixels = 3;                             // of the shrunk parent
constexpr double kInside = 0.985;  // a contained photograph's corners may be off by the fit's error

struct Match {
  int child, parent;
  float distance;
};

struct Matches {
  std::vector<cv::Point2d> child, parent;
};

// Each parent's feature goes to the child's that is most like it; keypoints of several directions at one
// place count once.
std::vector<Match> one_to_one(std::vector<Match> found, const PhotoFeatures& child,
                              const PhotoFeatures& parent) {
  std::stable_sort(found.begin(), found.end(),
                   [](const Match& a, const Match& b) { return a.distance < b.distance; });
  std::map<std::pair<double, double>, bool> child_taken, parent_taken;
  std::vector<Match> kept;
  for (const Match& m : found) {
    const Vector2d &c = child.points[static_cast<std::size_t>(m.child)],
                   &p = parent.points[static_cast<std::size_t>(m.parent)];
    if (child_taken.contains({c.x(), c.y()}) || parent_taken.contains({p.x(), p.y()})) continue;
    child_taken[{c.x(), c.y()}] = parent_taken[{p.x(), p.y()}] = true;
    kept.push_back(m);
  }
  return kept;
}

Matches points_of(const std::vector<Match>& matches, const PhotoFeatures& child,
                  const PhotoFeatures& parent) {
  Matches out;
  for (const Match& m : matches) {
    const Vector2d &c = child.points[static_cast<std::size_t>(m.child)],
                   &p = parent.points[static_cast<std::size_t>(m.parent)];
    out.child.emplace_back(c.x() / child.scale, c.y() / child.scale);
    out.parent.emplace_back(p.x() / parent.scale, p.y() / parent.scale);
  }
  return out;
}

// From the shrunk child's pixels to the shrunk parent's; zero where there is none.
Matrix3d fit(const Matches& matches, int method, cv::Mat* inliers = nullptr) {
  cv::Mat unused;
  const cv::Mat h = cv::findHomography(matches.child, matches.parent, method, kRansacPixels,
                                       inliers != nullptr ? *inliers : unused, 5000, 0.9999);
  Matrix3d out = Matrix3d::Zero();
  if (h.rows == 3 && h.cols == 3)
    for (int i = 0; i < 9; ++i) out(i / 3, i % 3) = h.at<double>(i / 3, i % 3);
  return out;
}

double error_of(const Matrix3d& h, const Matches& m, std::size_t i) {
  const std::optional<Vector2d> at = transformed(h, {m.child[i].x, m.child[i].y});
  return at ? (*at - Vector2d(m.parent[i].x, m.parent[i].y)).norm() : 1e9;
}

/// The shrunk parent's features by place.
class Places {
 public:
  explicit Places(const PhotoFeatures& features) : features_(features) {
    for (int i = 0; i < features.count(); ++i) cells_[key(at(i))].push_back(i);
  }
  Vector2d at(int i) const { return features_.points[static_cast<std::size_t>(i)] / features_.scale; }
  /// Calls `visit` with each within kWindow of a place.
  template <class Visit>
  void around(const Vector2d& place, const Visit& visit) const {
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const auto cell = cells_.find(key(place + kWindow * Vector2d(dx, dy)));
        if (cell == cells_.end()) continue;
        for (const int i : cell->second)
          if ((at(i) - place).squaredNorm() <= kWindow * kWindow) visit(i);
      }
  }
  static constexpr double kWindow = 32;  // px in which a match must be the only one alike

 private:
  static std::int64_t key(const Vector2d& p) {
    return (static_cast<std::int64_t>(std::floor(p.y() / kWindow)) << 32) +
           static_cast<std::int64_t>(std::floor(p.x() / kWindow));
  }
  const PhotoFeatures& features_;
  std::unordered_map<std::int64_t, std::vector<int>> cells_;
};

float squared_distance(const std::uint8_t* a, const std::uint8_t* b) {
  int sum = 0;
  for (int k = 0; k < PhotoFeatures::kLength; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return static_cast<float>(sum);
}

// The child's features, each with the most alike within `reach` of where the homography puts it, if nothing
// else around is nearly as alike.
std::vector<Match> guided(const PhotoFeatures& child, const PhotoFeatures& parent, const Places& places,
                          const Matrix3d& h, double reach) {
  std::vector<Match> found;
  for (int i = 0; i < child.count(); ++i) {
    const std::optional<Vector2d> at =
        transformed(h, child.points[static_cast<std::size_t>(i)] / child.scale);
    if (!at) continue;
    std::vector<std::pair<int, float>> around;
    Match best{i, -1, Nearest::kNone};
    places.around(*at, [&](int p) {
      const float distance = squared_distance(child.descriptor(i), parent.descriptor(p));
      around.emplace_back(p, distance);
      if ((places.at(p) - *at).norm() <= reach && distance < best.distance) best = {i, p, distance};
    });
    if (best.parent < 0) continue;
    float second = Nearest::kNone;
    for (const auto& [p, distance] : around)
      if ((places.at(p) - places.at(best.parent)).norm() > 1) second = std::min(second, distance);
    if (best.distance < kRefit * second) found.push_back(best);
  }
  return one_to_one(std::move(found), child, parent);
}

// Least squares over those within a tolerance that shrinks to what the matches themselves scatter.
Matrix3d refit(Matrix3d h, const PhotoFeatures& child, const PhotoFeatures& parent, PairRelation& relation) {
  const Places places(parent);
  double reach = kRansacPixels;
  for (int round = 0; round < 4; ++round) {
    const Matches all = points_of(guided(child, parent, places, h, reach), child, parent);
    std::vector<double> errors;
    for (std::size_t i = 0; i < all.child.size(); ++i) errors.push_back(error_of(h, all, i));
    if (errors.size() < static_cast<std::size_t>(kFewest)) break;
    const double tolerance = std::clamp(3 * 1.4826 * median(errors), 0.5, reach);
    Matches near;
    double squares = 0;
    for (std::size_t i = 0; i < errors.size(); ++i)
      if (errors[i] <= tolerance) {
        near.child.push_back(all.child[i]);
        near.parent.push_back(all.parent[i]);
        squares += errors[i] * errors[i];
      }
    if (near.child.size() < static_cast<std::size_t>(kFewest)) break;
    const Matrix3d better = fit(near, 0);
    if (better.isZero()) break;
    h = better;
    relation.inliers = static_cast<int>(near.child.size());
    relation.rms = std::sqrt(squares / static_cast<double>(near.child.size())) * parent.scale;
  }
  return h;
}

void judge(const PhotoFeatures& child, const PhotoFeatures& parent, PairRelation& relation) {
  const std::optional<Quad> quad = sane_quad(relation.parent_from_child, child.width, child.height);
  if (!relation.parent_from_child.allFinite()) relation.parent_from_child.setZero();
  if (!quad) {
    relation.why = "where it would lie, it folds over or is seen too obliquely";
    return;
  }
  const double area = area_of(*quad), child_area = static_cast<double>(child.width) * child.height;
  relation.zoom = std::sqrt(child_area / area);
  relation.inside = share_inside(*quad, parent.width, parent.height);
  if (relation.inside < kInside)
    relation.why = text("reaches beyond it: ", std::floor(100 * relation.inside), " % lie inside");
}

}  // namespace

PairRelation relate(const PhotoFeatures& child, const PhotoFeatures& parent,
                    const std::vector<Nearest>& nearest) {
  PairRelation relation;
  std::vector<Match> found;
  for (std::size_t i = 0; i < nearest.size(); ++i)
    if (nearest[i].index >= 0 && nearest[i].second < Nearest::kNone &&
        nearest[i].first < kDecide * nearest[i].second)
      found.push_back({static_cast<int>(i), nearest[i].index, nearest[i].first});
  const std::vector<Match> matched = one_to_one(std::move(found), child, parent);
  relation.matches = static_cast<int>(matched.size());
  if (relation.matches < kFewest) {
    relation.why = text(relation.matches, " features agree, at least ", kFewest, " are wanted");
    return relation;
  }
  const Matches points = points_of(matched, child, parent);
  cv::Mat inliers;
  const Matrix3d first = fit(points, cv::RANSAC, &inliers);
  const int on_it = first.isZero() ? 0 : cv::countNonZero(inliers);
  if (on_it < kFewest) {
    relation.why = text(relation.matches, " features agree, but only ", on_it, " on one homography");
    return relation;
  }
  relation.inliers = on_it;
  const Matrix3d shrunk = refit(first, child, parent, relation);
  const Matrix3d from = Eigen::DiagonalMatrix<double, 3>(1 / child.scale, 1 / child.scale, 1),
                 to = Eigen::DiagonalMatrix<double, 3>(parent.scale, parent.scale, 1);
  relation.parent_from_child = to * shrunk * from;
  relation.parent_from_child /= relation.parent_from_child(2, 2);
  judge(child, parent, relation);
  return relation;
}

}  // namespace floatstage::detail
