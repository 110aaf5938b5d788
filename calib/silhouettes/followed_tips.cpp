// Method:  local extremes of outlines along epipolar planes, followed by the nearest place in the next
// picture Paper:   frontier points inside of outlines: R. Cipolla, K. Åström, P. Giblin, "Motion from the
// frontier of
//          curved surfaces", 1995
// Differs: nothing is matched by looks: which tips of two cameras are one is told by their angles over time
//          (silhouette_times.cpp)
// ADR:     0257

#include "calib/silhouettes/followed_tips.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace floatstage::calib {
namespace {

using Eigen::Vector2d;

constexpr int kReach = 12;        // points of the outline to each side that a tip stands out from
constexpr double kStandsOut = 1;  // px
constexpr double kFarthest = 12;  // px from one picture to the next
constexpr double kBorder = 3;     // px
constexpr int kFewestPictures = 10;

struct Tip {
  double angle;
  Vector2d at;
};

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

bool near_border(const CameraModel& model, const Vector2d& p) {
  return p.x() < kBorder || p.y() < kBorder || p.x() > model.width - kBorder ||
         p.y() > model.height - kBorder;
}

/// Tips of one closed polygon; `angles` grow outwards.
void add_tips(const CameraModel& model, std::span<const Vector2d> points, std::span<const double> angles,
              std::vector<Tip>& out) {
  const int count = static_cast<int>(points.size());
  const auto around = [&](int i) { return static_cast<std::size_t>((i + count) % count); };
  for (int i = 0; i < count; ++i) {
    const double here = angles[around(i)];
    double before = here, after = here;
    bool most = true;
    for (int j = 1; j <= kReach && most; ++j) {
      const double left = angles[around(i - j)], right = angles[around(i + j)];
      most = left <= here && right < here;  // NaN: no
      before = std::min(before, left), after = std::min(after, right);
    }
    if (!most || here - std::max(before, after) < kStandsOut) continue;
    const Vector2d &p = points[around(i)], &from = points[around(i - kReach)],
                   &to = points[around(i + kReach)];
    // A hollow is no tip: what covers what may meet there.
    if (cross(p - from, to - p) > 0 && !near_border(model, p)) out.push_back({here, p});
  }
}

/// The one of `tips` that is nearest to `place`, as long as `place` is the nearest of `places` to it.
class Follower {
 public:
  explicit Follower(std::size_t frames) : frames_(frames) {}

  void add(std::size_t frame, const std::vector<Tip>& tips) {
    std::vector<Open> next;
    for (const Tip& tip : tips) {
      const std::optional<std::size_t> known = curve_of(tip, tips);
      if (!known) curves_.emplace_back(frames_, NAN);
      const std::size_t curve = known ? *known : curves_.size() - 1;
      curves_[curve][frame] = tip.angle;
      next.push_back({curve, tip.at});
    }
    open_ = std::move(next);
  }

  std::vector<std::vector<double>> take() {
    std::erase_if(curves_, [](const std::vector<double>& one) {
      return std::count_if(one.begin(), one.end(), [](double v) { return !std::isnan(v); }) < kFewestPictures;
    });
    return std::move(curves_);
  }

 private:
  struct Open {
    std::size_t curve;
    Vector2d at;
  };

  // The curve that ends nearest to the tip, unless another tip is nearer to that end.
  std::optional<std::size_t> curve_of(const Tip& tip, const std::vector<Tip>& tips) const {
    const Open* nearest = nullptr;
    double least = kFarthest;
    for (const Open& one : open_)
      if (const double far = (one.at - tip.at).norm(); far < least) least = far, nearest = &one;
    if (nearest == nullptr) return std::nullopt;
    for (const Tip& other : tips)
      if ((nearest->at - other.at).norm() < least) return std::nullopt;
    return nearest->curve;
  }

  std::size_t frames_;
  std::vector<std::vector<double>> curves_;
  std::vector<Open> open_;
};

}  // namespace

std::vector<std::vector<double>> followed_tips(const PlanePencil& pencil, const RigCamera& rig_camera,
                                               std::size_t camera, PencilEnd end,
                                               std::span<const std::vector<Silhouette>> frames,
                                               double angle_per_pixel) {
  const double outwards = (end == PencilEnd::Largest ? 1 : -1) / angle_per_pixel;
  const Eigen::Matrix3d world_from_cam = rig_camera.cam_from_world.rotation.conjugate().toRotationMatrix();
  Follower follower(frames.size());
  std::vector<double> angles;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Silhouette& outline = frames[k][camera];
    std::vector<Tip> tips;
    for (int polygon = 0; polygon < outline.polygons(); ++polygon) {
      const auto begin = static_cast<std::size_t>(outline.starts[static_cast<std::size_t>(polygon)]),
                 stop = static_cast<std::size_t>(outline.starts[static_cast<std::size_t>(polygon) + 1]);
      if (stop - begin < 6 * kReach) continue;  // a speck
      const auto points = std::span(outline.points).subspan(begin, stop - begin);
      angles.clear();
      for (const Vector2d& p : points) {
        const auto ray = unproject(rig_camera.model, p);
        angles.push_back(ray ? outwards * pencil.angle_of(world_from_cam * *ray) : NAN);
      }
      add_tips(rig_camera.model, points, angles, tips);
    }
    if (end == PencilEnd::Smallest)
      for (Tip& tip : tips) tip.angle = -tip.angle;
    follower.add(k, tips);
  }
  return follower.take();
}

}  // namespace floatstage::calib
