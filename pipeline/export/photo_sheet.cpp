#include "pipeline/export/photo_sheet.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace floatstage::pipeline {
namespace {

constexpr int kGuard = 8;  // px around the mesh: the spline's reach, and mattes softer than the hull
constexpr int kBlock = 8;  // px: of JPEG, so that no tile shares one with another

int up_to_blocks(int n) { return (n + kBlock - 1) / kBlock * kBlock; }

// The part of a photograph that shows the mesh.
std::optional<PixelBox> part_of(const RigCamera& camera, const Mesh& mesh) {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector3f& p : mesh.positions)
    if (const auto pixel = project(camera.model, camera.cam_from_world * p.cast<double>()))
      box.extend(*pixel);
  if (box.isEmpty()) return std::nullopt;
  const auto from = [](double v, int most) {
    return static_cast<int>(std::clamp(std::floor(v) - kGuard, 0.0, static_cast<double>(most)));
  };
  const auto to = [](double v, int most) {
    return static_cast<int>(std::clamp(std::ceil(v) + kGuard, 0.0, static_cast<double>(most)));
  };
  const int w = camera.model.width, h = camera.model.height;
  const int x = from(box.min().x(), w), y = from(box.min().y(), h);
  const PixelBox part{x, y, to(box.max().x(), w) - x, to(box.max().y(), h) - y};
  return part.empty() ? std::nullopt : std::optional(part);
}

// Tiles in rows, the tallest first. False where they do not fit.
bool arrange(std::vector<std::optional<SheetTile>>& tiles, int longest, int& width, int& height) {
  std::vector<SheetTile*> order;
  double area = 0;
  int widest = 0;
  for (std::optional<SheetTile>& tile : tiles)
    if (tile) {
      order.push_back(&*tile);
      area += 2.0 * up_to_blocks(tile->width) * up_to_blocks(tile->height);
      widest = std::max(widest, 2 * tile->width);
    }
  std::stable_sort(order.begin(), order.end(),
                   [](const SheetTile* a, const SheetTile* b) { return a->height > b->height; });
  const int row_width =
      std::clamp(static_cast<int>(1.2 * std::sqrt(area)), widest, std::max(widest, longest));
  int x = 0, y = 0, row = 0;
  width = height = 0;
  for (SheetTile* tile : order) {
    const int wide = up_to_blocks(2 * tile->width);
    if (x > 0 && x + wide > up_to_blocks(row_width)) {
      x = 0;
      y += row;
      row = 0;
    }
    tile->x = x;
    tile->y = y;
    x += wide;
    row = std::max(row, up_to_blocks(tile->height));
    width = std::max(width, x);
    height = std::max(height, y + row);
  }
  return width <= longest && height <= longest;
}

// The mean of the photograph's pixels under each of the sheet's.
std::uint8_t mean_of(const Image& image, int x0, int y0, int step, int channel) {
  int sum = 0, count = 0;
  for (int y = y0; y < std::min(y0 + step, image.height); ++y)
    for (int x = x0; x < std::min(x0 + step, image.width); ++x, ++count) sum += image.at(x, y)[channel];
  return static_cast<std::uint8_t>(count > 0 ? (sum + count / 2) / count : 0);
}

void draw(const Image& photograph, const Image& matte, const SheetTile& tile, Image& sheet) {
  for (int y = 0; y < tile.height; ++y)
    for (int x = 0; x < tile.width; ++x) {
      const int px = tile.left + x * tile.shrink, py = tile.top + y * tile.shrink;
      std::uint8_t *color = sheet.at(tile.x + x, tile.y + y),
                   *alpha = sheet.at(tile.x + tile.width + x, tile.y + y);
      for (int k = 0; k < 3; ++k) color[k] = mean_of(photograph, px, py, tile.shrink, k);
      std::fill_n(alpha, 3, matte.empty() ? std::uint8_t{255} : mean_of(matte, px, py, tile.shrink, 0));
    }
}

}  // namespace

PhotoSheet photo_sheet(const StraightInstant& instant, int longest) {
  PhotoSheet sheet;
  std::vector<std::optional<PixelBox>> parts;
  for (const RigCamera& camera : instant.rig.cameras) parts.push_back(part_of(camera, instant.mesh));
  int width = 1, height = 1;
  for (int shrink = 1;; shrink *= 2) {
    sheet.tiles.clear();
    for (const std::optional<PixelBox>& part : parts)
      sheet.tiles.push_back(
          part ? std::optional(SheetTile{0, 0, (part->width + shrink - 1) / shrink,
                                         (part->height + shrink - 1) / shrink, part->x, part->y, shrink})
               : std::nullopt);
    if (arrange(sheet.tiles, longest, width, height)) break;
  }
  sheet.picture = Image(std::max(width, kBlock), std::max(height, kBlock), 3);
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (sheet.tiles[i]) draw(instant.pictures[i], instant.mattes[i], *sheet.tiles[i], sheet.picture);
  return sheet;
}

}  // namespace floatstage::pipeline
