#include "recon/block_pictures.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

constexpr int kBlocksAcross =
    128;  // of a picture's longer side: a quarter of a hundredth of its area a block

/// The most that a lens stretches the picture, somewhere in it.
double lens_stretch(const CameraModel& model) {
  if (std::holds_alternative<std::monostate>(model.lens)) return 1;
  constexpr int kSteps = 4;
  constexpr double kStep = 1e-3;
  double stretch = 1;
  for (int k = 0; k <= kSteps; ++k) {
    for (const bool across : {false, true}) {
      const Eigen::Vector2d pixel(across ? model.width * k / double{kSteps} : model.cx,
                                  across ? model.cy : model.height * k / double{kSteps});
      const auto ray = unproject(model, pixel);
      if (!ray) continue;
      const auto here = distort(model.lens, ray->head<2>());
      for (int axis = 0; here && axis < 2; ++axis) {
        const auto there = distort(model.lens, ray->head<2>() + kStep * Eigen::Vector2d::Unit(axis));
        if (there) stretch = std::max(stretch, (*there - *here).norm() / kStep);
      }
    }
  }
  return stretch;
}

/// The angle from the axis to the picture's corner or side that is furthest from it; a right angle when the
/// lens does not say.
double field_angle(const CameraModel& model) {
  double angle = 0;
  for (const double x : {0.0, 0.5, 1.0}) {
    for (const double y : {0.0, 0.5, 1.0}) {
      const auto ray = unproject(model, {x * model.width, y * model.height});
      if (!ray) return std::numbers::pi / 2;
      angle = std::max(angle, std::atan2(ray->head<2>().norm(), ray->z()));
    }
  }
  return std::min(angle, std::numbers::pi / 2);
}

void fill_from_matte(const Matte& matte, BlockPicture& picture) {
  const std::uint8_t* block_at = picture.block_at.data();
  for (int y = 0; y < matte.height; ++y) {
    const std::uint8_t* row = matte.row(y);
    std::uint8_t* blocks =
        picture.subject.data() + static_cast<std::size_t>(y / picture.block) * picture.columns;
    int x = 0;
    for (; x + 8 <= matte.width; x += 8) {
      std::uint64_t eight;
      std::memcpy(&eight, row + x, 8);
      if ((eight & 0x8080808080808080ULL) == 0) continue;
      for (int k = 0; k < 8; ++k) blocks[block_at[x + k]] |= row[x + k] >> 7;
    }
    for (; x < matte.width; ++x) blocks[block_at[x]] |= row[x] >> 7;
  }
}

bool touches_border(const Matte& matte) {
  for (int y = 0; y < matte.height; ++y) {
    const std::uint8_t* row = matte.row(y);
    if (row[0] >= 128 || row[matte.width - 1] >= 128) return true;
    if ((y == 0 || y == matte.height - 1) &&
        std::any_of(row, row + matte.width, [](std::uint8_t alpha) { return alpha >= 128; }))
      return true;
  }
  return false;
}

/// Blocks that an edge passes through, and those whose centres are inside.
void fill_from_outline(const Silhouette& outline, BlockPicture& picture) {
  const double block = picture.block;
  const auto block_of = [&](double v, int count) {
    return std::clamp(static_cast<int>(std::floor(v / block)), 0, count - 1);
  };
  // Parity along the rows through the blocks' centres: where an edge crosses one, the blocks right of it
  // turn.
  for (int k = 0; k < outline.polygons(); ++k) {
    const int begin = outline.starts[k], end = outline.starts[k + 1];
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector2d &a = outline.points[i], &b = outline.points[i + 1 < end ? i + 1 : begin];
      const double low = std::min(a.y(), b.y()), high = std::max(a.y(), b.y());
      const int first = std::max(0, static_cast<int>(std::ceil(low / block - 0.5)));
      for (int row = first; row < picture.rows && (row + 0.5) * block < high; ++row) {
        const double y = (row + 0.5) * block, x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
        const int column = std::max(0, static_cast<int>(std::ceil(x / block - 0.5)));
        if (column < picture.columns)
          picture.subject[static_cast<std::size_t>(row) * picture.columns + column] ^= 1;
      }
    }
  }
  for (int row = 0; row < picture.rows; ++row) {
    std::uint8_t* blocks = picture.subject.data() + static_cast<std::size_t>(row) * picture.columns;
    std::uint8_t inside = outline.beyond_counts ? 1 : 0;
    for (int x = 0; x < picture.columns; ++x) {
      inside ^= blocks[x];
      blocks[x] = inside;
    }
  }
  for (int k = 0; k < outline.polygons(); ++k) {
    const int begin = outline.starts[k], end = outline.starts[k + 1];
    for (int i = begin; i < end; ++i) {
      const Eigen::Vector2d &a = outline.points[i], &b = outline.points[i + 1 < end ? i + 1 : begin];
      const double width = picture.columns * block, height = picture.rows * block;
      // The picture's own border is no outline.
      const auto on_border = [&](const Eigen::Vector2d& p) {
        return p.x() < 0.25 || p.y() < 0.25 || p.x() > width - block || p.y() > height - block;
      };
      if (outline.beyond_counts && on_border(a) && on_border(b)) continue;
      const int steps = 1 + static_cast<int>((b - a).cwiseAbs().maxCoeff() / (0.5 * block));
      for (int s = 0; s <= steps; ++s) {
        const Eigen::Vector2d p = a + (b - a) * (static_cast<double>(s) / steps);
        picture.subject[static_cast<std::size_t>(block_of(p.y(), picture.rows)) * picture.columns +
                        block_of(p.x(), picture.columns)] = 1;
      }
    }
  }
}

}  // namespace

void BlockPicture::sum_up(const std::vector<std::uint8_t>& blocks, std::vector<int>& sum) const {
  sum.assign(static_cast<std::size_t>(columns + 1) * (rows + 1), 0);
  for (int y = 0; y < rows; ++y) {
    int row = 0;
    const std::size_t above = static_cast<std::size_t>(y) * (columns + 1), here = above + columns + 1;
    for (int x = 0; x < columns; ++x) {
      row += blocks[index(x, y)];
      sum[here + x + 1] = sum[above + x + 1] + row;
    }
  }
}

void BlockPictures::fill(const Rig& rig, const HullInput& input) {
  pictures_.resize(rig.cameras.size());
  lenses_.resize(rig.cameras.size());
  known_ = 0;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const RigCamera& camera = rig.cameras[c];
    View& view = lenses_[c];
    if (!(view.model == camera.model)) {
      view.model = camera.model;
      view.pinhole = std::holds_alternative<std::monostate>(camera.model.lens);
      view.stretch = lens_stretch(camera.model);
      const double angle = field_angle(camera.model);
      view.cosine = std::cos(angle);
      view.sine = std::sin(angle);
    }
    view.rotation = camera.cam_from_world.rotation.toRotationMatrix();
    view.translation = camera.cam_from_world.translation;
    BlockPicture& picture = pictures_[c];
    picture.known = input.knows(c);
    if (!picture.known) continue;
    ++known_;
    const int longer = std::max(camera.model.width, camera.model.height);
    const int block = std::max(1, (longer + kBlocksAcross - 1) / kBlocksAcross);
    if (picture.block != block || picture.block_at.size() != static_cast<std::size_t>(longer)) {
      picture.block = block;
      picture.block_at.resize(static_cast<std::size_t>(longer));
      for (int x = 0; x < longer; ++x)
        picture.block_at[static_cast<std::size_t>(x)] = static_cast<std::uint8_t>(x / block);
    }
    picture.columns = (camera.model.width + picture.block - 1) / picture.block;
    picture.rows = (camera.model.height + picture.block - 1) / picture.block;
    picture.subject.assign(static_cast<std::size_t>(picture.columns) * picture.rows, 0);
    if (const Silhouette* outline = input.outline(c)) {
      fill_from_outline(*outline, picture);
    } else {
      fill_from_matte(input.matte(c), picture);
    }
    picture.sum_up(picture.subject, picture.sums);
    const int blocks = picture.count(0, 0, picture.columns - 1, picture.rows - 1);
    const Silhouette* given = input.outline(c);
    picture.inside = blocks > 0 && !(given ? given->beyond_counts : touches_border(input.matte(c)));
    picture.whole = picture.inside;
  }
}

/// |x'/z' - x/z| <= r sqrt(1 + (x/z)²) / (z - r) for any point within r.
BallExtent BlockPictures::extent(std::size_t camera, const Vector3d& center, double radius) const {
  const View& view = lenses_[camera];
  const CameraModel& model = view.model;
  const Vector3d p = view.rotation * center + view.translation;
  // Without the cone, all that lies in the plane of the lens would be near, however far to the side.
  if (p.z() <= -radius || view.cosine * p.head<2>().norm() - view.sine * p.z() > radius)
    return {.beside = true};
  if (p.z() <= 1.5 * radius) return {.near = true};
  const double inverse = 1 / p.z(), x = p.x() * inverse, y = p.y() * inverse;
  Eigen::Vector2d pixel(model.fx * x + model.skew * y + model.cx, model.fy * y + model.cy);
  if (!view.pinhole) {
    const auto bent = project(model, p);
    if (!bent) return {.near = true};
    pixel = *bent;
  }
  const double reach = view.stretch * radius / (p.z() - radius) * std::sqrt(1 + x * x + y * y),
               du = model.fx * reach, dv = model.fy * reach;
  return {pixel.x() - du, pixel.x() + du, pixel.y() - dv, pixel.y() + dv};
}

BlockPictures::Answer BlockPictures::ask(std::size_t camera, const Vector3d& center, double radius,
                                         bool small) const {
  const BlockPicture& picture = pictures_[camera];
  const double width = lenses_[camera].model.width, height = lenses_[camera].model.height;
  const BallExtent e = extent(camera, center, radius);
  const Answer outside = picture.whole ? Answer::Background : Answer::NotSeen;
  if (e.beside) return outside;
  if (e.near) return Answer::Subject;
  if (e.right < 0 || e.bottom < 0 || e.left >= width || e.top >= height) return outside;
  if (!picture.whole) {
    const double x = (e.left + e.right) / 2, y = (e.top + e.bottom) / 2;
    if (small && (x < 0 || y < 0 || x >= width || y >= height)) return Answer::NotSeen;
    const bool all_seen = e.left >= 0 && e.top >= 0 && e.right < width && e.bottom < height;
    if (!all_seen && !small) return Answer::Subject;
  }
  const auto block_of = [&](double v, double end) {
    return static_cast<int>(picture.block_at[static_cast<std::size_t>(std::clamp(v, 0.0, end - 1))]);
  };
  const int subject = picture.count(block_of(e.left, width), block_of(e.top, height),
                                    block_of(e.right, width), block_of(e.bottom, height));
  return subject > 0 ? Answer::Subject : Answer::Background;
}

bool BlockPictures::blocks_of(std::size_t camera, const Vector3d& center, double radius, int& x0, int& y0,
                              int& x1, int& y1) const {
  const BlockPicture& picture = pictures_[camera];
  const BallExtent e = extent(camera, center, radius);
  if (e.beside || e.near || e.right < 0 || e.bottom < 0) return false;
  const auto block_of = [&](double v) { return static_cast<int>(std::clamp(v, 0.0, 1e6)) / picture.block; };
  if (e.left >= picture.columns * picture.block || e.top >= picture.rows * picture.block) return false;
  x0 = block_of(e.left);
  y0 = block_of(e.top);
  x1 = std::min(picture.columns - 1, block_of(e.right));
  y1 = std::min(picture.rows - 1, block_of(e.bottom));
  return x0 <= x1 && y0 <= y1;
}

}  // namespace floatstage::recon
