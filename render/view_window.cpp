#include "render/view_window.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/text.h"

namespace floatstage::render {
namespace {

constexpr int kWindowGrid = 16;  // px
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr std::size_t kTogether = 32;  // blocks, looked at with what those before them cover
constexpr float kRounding = 1e-5F;     // of a sum's terms: many times what a few roundings come to

float f(double v) { return static_cast<float>(v); }

/// What vertices cover of a view, px.
class Extent {
 public:
  explicit Extent(const View& view)
      : width_(f(view.model.width)), height_(f(view.model.height)), near_plane_(f(view.near_plane)) {
    transform_ = (Eigen::Matrix4d() << view.model.k(), Eigen::Vector3d::Zero(), 0, 0, 0, 1)
                     .finished()
                     .topRows<3>()
                     .cast<float>() *
                 view.view_from_world.matrix().cast<float>();
  }

  void add(const Eigen::Vector3f& position) {
    const Eigen::Vector3f p = transform_ * position.homogeneous();
    if (p.z() < near_plane_) {
      crosses_near_ = true;
      return;
    }
    const float x = p.x() / p.z(), y = p.y() / p.z();
    low_x_ = std::min(low_x_, x);
    low_y_ = std::min(low_y_, y);
    high_x_ = std::max(high_x_, x);
    high_y_ = std::max(high_y_, y);
  }

  /// What is cut at the near plane can cover anything.
  bool is_whole_view() const { return crosses_near_ && low_x_ <= high_x_; }

  /// Which of `count` blocks may change anything: 0 or 1 each. Those of which all vertices are known to lie
  /// behind the near plane and within what is covered do not.
  void find_beyond(const VertexBlocks& blocks, std::size_t first, std::size_t count, int* beyond) const;

  Window window(int margin) const;

 private:
  Eigen::Matrix<float, 3, 4> transform_;
  float width_, height_, near_plane_;
  float low_x_ = kInfinity, low_y_ = kInfinity, high_x_ = -kInfinity, high_y_ = -kInfinity;
  bool crosses_near_ = false;
};

// Vertices in front of the view are inside where x - low z >= 0 and so on: half spaces. A box is inside
// where the corner is that lies farthest out. What is inside by less than rounding could hide is not.
void Extent::find_beyond(const VertexBlocks& blocks, std::size_t first, std::size_t count,
                         int* beyond) const {
  const Eigen::RowVector4f x = transform_.row(0), y = transform_.row(1), z = transform_.row(2);
  const Eigen::RowVector4f near_plane(0, 0, 0, near_plane_);
  struct HalfSpace {
    Eigen::RowVector4f inside, terms;  // of a point's coordinates: at least 0 inside; what was summed for it
  };
  const std::array<HalfSpace, 5> half_spaces{
      HalfSpace{z - near_plane, z.cwiseAbs() + near_plane},
      HalfSpace{x - low_x_ * z, x.cwiseAbs() + std::abs(low_x_) * z.cwiseAbs()},
      HalfSpace{high_x_ * z - x, x.cwiseAbs() + std::abs(high_x_) * z.cwiseAbs()},
      HalfSpace{y - low_y_ * z, y.cwiseAbs() + std::abs(low_y_) * z.cwiseAbs()},
      HalfSpace{high_y_ * z - y, y.cwiseAbs() + std::abs(high_y_) * z.cwiseAbs()}};
  const Eigen::Vector4f farthest =
      blocks.box.min().cwiseAbs().cwiseMax(blocks.box.max().cwiseAbs()).homogeneous();
  std::fill_n(beyond, count, 0);
  for (const HalfSpace& half_space : half_spaces) {
    const Eigen::RowVector4f& n = half_space.inside;
    const float* corner[3];
    for (int axis = 0; axis < 3; ++axis)
      corner[axis] = (n[axis] > 0 ? blocks.low : blocks.high)[static_cast<std::size_t>(axis)].data() + first;
    const float least = kRounding * half_space.terms.dot(farthest.transpose()) - n[3];
    const float nx = n[0], ny = n[1], nz = n[2];
    const float *cx = corner[0], *cy = corner[1], *cz = corner[2];
    for (std::size_t b = 0; b < count; ++b)  // not a number is beyond, too
      beyond[b] |= nx * cx[b] + ny * cy[b] + nz * cz[b] > least ? 0 : 1;
  }
}

Window Extent::window(int margin) const {
  if (!(low_x_ <= high_x_)) return {};
  const bool whole = is_whole_view();
  const float low_x = whole ? 0 : low_x_, low_y = whole ? 0 : low_y_;
  const float high_x = whole ? width_ : high_x_, high_y = whole ? height_ : high_y_;
  auto down = [](float v) { return static_cast<int>(std::floor(v / kWindowGrid)) * kWindowGrid; };
  auto up = [](float v) { return static_cast<int>(std::ceil(v / kWindowGrid)) * kWindowGrid; };
  const float grow = static_cast<float>(margin);
  const float x0 = std::clamp(low_x, 0.F, width_) - grow, x1 = std::clamp(high_x, 0.F, width_) + grow;
  const float y0 = std::clamp(low_y, 0.F, height_) - grow, y1 = std::clamp(high_y, 0.F, height_) + grow;
  if (high_x < -grow || low_x > width_ + grow || high_y < -grow || low_y > height_ + grow) return {};
  const int left = down(x0), top = down(y0);
  return {left, top, up(x1) - left, up(y1) - top};
}

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
  Extent extent(view);
  for (const Eigen::Vector3f& position : positions) extent.add(position);
  return extent.window(margin);
}

// One vertex of each block first: what they cover is nearly everything, and few blocks reach beyond it.
Window window_of(const View& view, const std::vector<Eigen::Vector3f>& positions, const VertexBlocks& blocks,
                 int margin) {
  Extent extent(view);
  for (std::size_t i = 0; i < positions.size(); i += VertexBlocks::kVertices) extent.add(positions[i]);
  std::array<int, kTogether> beyond{};
  for (std::size_t first = 0; first < blocks.count() && !extent.is_whole_view(); first += kTogether) {
    const std::size_t count = std::min(kTogether, blocks.count() - first);
    extent.find_beyond(blocks, first, count, beyond.data());
    for (std::size_t b = 0; b < count; ++b) {
      if (beyond[b] == 0) continue;
      const std::size_t begin = (first + b) * VertexBlocks::kVertices;
      const std::size_t end = std::min(begin + VertexBlocks::kVertices, positions.size());
      for (std::size_t i = begin; i < end; ++i) extent.add(positions[i]);
    }
  }
  return extent.window(margin);
}

}  // namespace floatstage::render
