#include "pipeline/export/web_frame.h"

#include <cmath>

#include <nlohmann/json.hpp>

#include "core/jpeg.h"
#include "core/text.h"
#include "pipeline/export/photo_sheet.h"

namespace floatstage::pipeline {
namespace {

using nlohmann::json;

constexpr int kSteps = 65535;

template <class T>
void put(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// Positions in 16 bits of the box, then indices on a multiple of four bytes, in as few bytes as do.
std::string mesh_bytes(const Mesh& mesh, const Eigen::AlignedBox3f& box) {
  std::string out;
  const Eigen::Vector3f size = box.sizes();
  for (const Eigen::Vector3f& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) {
      const float share = size[axis] > 0 ? (p[axis] - box.min()[axis]) / size[axis] : 0;
      put(out, static_cast<std::uint16_t>(std::lround(share * kSteps)));
    }
  out.resize((out.size() + 3) / 4 * 4);
  const bool narrow = mesh.positions.size() <= kSteps + 1;
  for (const std::uint32_t i : mesh.triangles)
    if (narrow)
      put(out, static_cast<std::uint16_t>(i));
    else
      put(out, i);
  return out;
}

json tiles_of(const PhotoSheet& sheet, const StraightInstant& instant, const Rig& rig) {
  json tiles = json::array();
  for (const RigCamera& camera : rig.cameras) {
    const int index = camera_index(instant.rig, camera.serial);
    const std::optional<SheetTile> tile =
        index < 0 ? std::nullopt : sheet.tiles[static_cast<std::size_t>(index)];
    if (!tile) {
      tiles.push_back(nullptr);
      continue;
    }
    const double scale = 1.0 / tile->shrink;
    tiles.push_back(
        {tile->x, tile->y, tile->width, tile->height, tile->left * scale, tile->top * scale, scale});
  }
  return tiles;
}

json numbers(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }

}  // namespace

std::string base64(std::string_view bytes) {
  static constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (k < count ? static_cast<std::uint8_t>(bytes[i + k]) : 0);
    for (std::size_t k = 0; k < 4; ++k) out += k <= count ? kLetters[three >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string web_frame(const StraightInstant& instant, const Rig& rig, int number, int quality) {
  const Eigen::AlignedBox3f box = instant.mesh.positions.empty()
                                      ? Eigen::AlignedBox3f(Eigen::Vector3f::Zero())
                                      : bounding_box(instant.mesh);
  const PhotoSheet sheet = photo_sheet(instant);
  const json frame = {{"low", numbers(box.min())},
                      {"high", numbers(box.max())},
                      {"vertices", instant.mesh.positions.size()},
                      {"tiles", tiles_of(sheet, instant, rig)},
                      {"mesh", base64(mesh_bytes(instant.mesh, box))},
                      {"sheet", base64(encode_jpeg(sheet.picture, quality))}};
  return text("frameLoaded(", number, ", ", frame.dump(), ");\n");
}

}  // namespace floatstage::pipeline
