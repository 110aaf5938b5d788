#include "recon/shared_view.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

constexpr int kSteps = 40;        // of the grid, from the fixation to as far as the cameras are
constexpr double kTooNear = 0.1;  // of a camera's distance: nobody performs in front of the lens

bool sees(const RigCamera& camera, const Vector3d& world, double nearest) {
  const Vector3d x = camera.cam_from_world * world;
  if (x.z() < nearest) return false;
  const std::optional<Eigen::Vector2d> pixel = project(camera.model, x);
  return pixel && inside(camera.model, *pixel);
}

class Asked {
 public:
  Asked(const Rig& rig, const Vector3d& fixation) : rig_(rig) {
    for (const RigCamera& c : rig.cameras)
      distances_.push_back((c.cam_from_world.center() - fixation).norm());
  }
  int seen_by(const Vector3d& point) const {
    int count = 0;
    for (std::size_t i = 0; i < distances_.size(); ++i)
      count += sees(rig_.cameras[i], point, kTooNear * distances_[i]);
    return count;
  }
  bool sees(std::size_t camera, const Vector3d& point) const {
    return recon::sees(rig_.cameras[camera], point, kTooNear * distances_[camera]);
  }
  const std::vector<double>& distances() const { return distances_; }

 private:
  static bool sees(const RigCamera& camera, const Vector3d& point, double nearest) {
    return recon::sees(camera, point, nearest);
  }
  const Rig& rig_;
  std::vector<double> distances_;
};

}  // namespace

Result<SharedView> shared_view(const Rig& rig, double share) {
  if (Result<void> ok = check(rig); !ok) return forward(ok);
  if (rig.cameras.size() < 2)
    return fail(ErrorCode::InvalidArgument, "one camera shares its view with nobody; give two or more");
  if (!(share >= 0 && share <= 1))
    return fail(ErrorCode::InvalidArgument, text("a share of the cameras is from 0 to 1, not ", share));
  SharedView view;
  view.fixation = focus_point(rig);
  view.seen_by = std::max(2, static_cast<int>(std::ceil(share * static_cast<double>(rig.cameras.size()))));
  const Asked asked(rig, view.fixation);
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    if (!asked.sees(i, view.fixation)) view.astray.push_back(static_cast<int>(i));
  // The median: one camera far away must not make the grid coarse, nor one that is close cut the stage off.
  std::vector<double> distances = asked.distances();
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2),
                   distances.end());
  const double reach = distances[distances.size() / 2], step = reach / kSteps;
  double nearest_unseen = reach;
  for (int z = -kSteps; z <= kSteps; ++z)
    for (int y = -kSteps; y <= kSteps; ++y)
      for (int x = -kSteps; x <= kSteps; ++x) {
        const Vector3d offset = step * Vector3d(x, y, z);
        const double distance = offset.norm();
        if (distance > reach) continue;
        if (asked.seen_by(view.fixation + offset) >= view.seen_by)
          view.box.extend(view.fixation + offset);
        else
          nearest_unseen = std::min(nearest_unseen, distance);
      }
  if (view.box.isEmpty())
    return fail(ErrorCode::BadData, text("there is no space that ", view.seen_by, " of the ",
                                         rig.cameras.size(), " cameras see"));
  view.radius = nearest_unseen;
  const Vector3d margin = Vector3d::Constant(step / 2);
  view.box = Eigen::AlignedBox3d(view.box.min() - margin, view.box.max() + margin);
  return view;
}

}  // namespace floatstage::recon
