#include "render/view_window.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.h"

namespace floatstage::render {
namespace {

constexpr int kWindowGrid = 16;  // px

float f(double v) { return static_cast<float>(v); }

}  // namespace

Result<void> check(const View& view) {
  if (!std::holds_alternative<std::monostate>(view.model.lens))
    return fail(ErrorCode::InvalidArgument,
                "the view has a lens; a virtual camera is a pinhole: pass pinhole(model)");
  if (Result<void> ok = check(view.model); !ok)
    return fail(ErrorCode::InvalidArgument, text("the view: ", ok.error().message));
  if (!(view.near_plane > 0) || !(view.far_plane > view.near_plane) || !std::isfinite(view.far_plane))
    return fail(ErrorCode::InvalidArgument, text("the view's planes ", view.near_plane, " and ",
                                                 view.far_plane, " m are not 0 < near < far"));
  if (!view.view_from_world.translation.allFinite() || !view.view_from_world.rotation.coeffs().allFinite() ||
      std::abs(view.view_from_world.rotation.norm() - 1) > 1e-6)
    return fail(ErrorCode::InvalidArgument, "the view's transform is not a finite rotation and translation");
  return {};
}

Window window_of(const View& view, const std::vector<Eigen::Vector3f>& positions, int margin) {
  const CameraModel& m = view.model;
  const Eigen::Matrix<float, 3, 4> transform =
      (Eigen::Matrix4d() << m.k(), Eigen::Vector3d::Zero(), 0, 0, 0, 1)
          .finished()
          .topRows<3>()
          .cast<float>() *
      view.view_from_world.matrix().cast<float>();
  const float near_plane = f(view.near_plane), infinity = std::numeric_limits<float>::infinity();
  float low_x = infinity, low_y = infinity, high_x = -infinity, high_y = -infinity;
  bool crosses_near = false;
  for (const Eigen::Vector3f& position : positions) {
    const Eigen::Vector3f p = transform * position.homogeneous();
    if (p.z() < near_plane) {
      crosses_near = true;
      continue;
    }
    const float x = p.x() / p.z(), y = p.y() / p.z();
    low_x = std::min(low_x, x);
    low_y = std::min(low_y, y);
    high_x = std::max(high_x, x);
    high_y = std::max(high_y, y);
  }
  if (!(low_x <= high_x)) return {};
  if (crosses_near) {  // what is cut at the near plane can cover anything
    low_x = low_y = 0;
    high_x = f(m.width);
    high_y = f(m.height);
  }
  auto down = [](float v) { return static_cast<int>(std::floor(v / kWindowGrid)) * kWindowGrid; };
  auto up = [](float v) { return static_cast<int>(std::ceil(v / kWindowGrid)) * kWindowGrid; };
  const float grow = static_cast<float>(margin);
  const float x0 = std::clamp(low_x, 0.F, f(m.width)) - grow, x1 = std::clamp(high_x, 0.F, f(m.width)) + grow;
  const float y0 = std::clamp(low_y, 0.F, f(m.height)) - grow,
              y1 = std::clamp(high_y, 0.F, f(m.height)) + grow;
  if (high_x < -grow || low_x > f(m.width) + grow || high_y < -grow || low_y > f(m.height) + grow) return {};
  const int left = down(x0), top = down(y0);
  return {left, top, up(x1) - left, up(y1) - top};
}

}  // namespace floatstage::render
