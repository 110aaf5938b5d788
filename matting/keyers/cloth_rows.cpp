#include "matting/keyers/cloth_rows.h"

#include <algorithm>

#include "matting/keyers/cloth_kernels.h"

namespace floatstage::matting {
namespace {

// A row taken apart.
struct Planes {
  std::uint8_t *r, *g, *b;
  std::size_t room;
};

Planes taken_apart(const std::uint8_t* rgb, int count, std::vector<std::uint8_t>& scratch) {
  const std::size_t room = padded(static_cast<std::size_t>(count));
  if (scratch.size() < 3 * room) scratch.resize(3 * room);
  const Planes planes{scratch.data(), scratch.data() + room, scratch.data() + 2 * room, room};
  cloth_kernels().split(rgb, static_cast<std::size_t>(count), planes.r, planes.g, planes.b);
  return planes;
}

}  // namespace

void ClothRows::classify(const std::uint8_t* rgb, int, int width, std::vector<std::uint8_t>& scratch,
                         std::uint64_t* subject, std::uint64_t* faint, std::uint64_t* doubt) const {
  const Planes p = taken_apart(rgb, width, scratch);
  cloth_kernels().classify(measure_, p.r, p.g, p.b, p.room, subject, faint, doubt);
}

void ClothRows::opacities(const std::uint8_t* rgb, int, int, int count, std::uint8_t* out) const {
  for (int i = 0; i < count; ++i, rgb += 3)
    out[i] = static_cast<std::uint8_t>(std::clamp(measure_.value(rgb[0], rgb[1], rgb[2]), 0.0f, 255.0f));
}

float ClothRows::at(const std::uint8_t* rgb, int, int) const {
  return measure_.along.of(rgb[0], rgb[1], rgb[2]);
}

void ClothRows::quantize(const std::uint8_t* rgb, int, int, int count, std::vector<std::uint8_t>& scratch,
                         std::int32_t* out) const {
  const Planes p = taken_apart(rgb, count, scratch);
  cloth_kernels().quantize(measure_.along, p.r, p.g, p.b, p.room, out);
}

}  // namespace floatstage::matting
