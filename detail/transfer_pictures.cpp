#include "detail/transfer_pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/png.h"
#include "core/text.h"

namespace floatstage::detail {
namespace {

using Mask = std::vector<std::uint8_t>;

Image of_mask(const Mask& mask, int width, int height) {
  Image out(width, height, 1);
  for (std::size_t i = 0; i < mask.size(); ++i) out.pixels[i] = mask[i] != 0 ? 255 : 0;
  return out;
}

void dot(Image& image, int x, int y, int radius, std::array<std::uint8_t, 3> color) {
  for (int v = std::max(0, y - radius); v <= std::min(image.height - 1, y + radius); ++v)
    for (int u = std::max(0, x - radius); u <= std::min(image.width - 1, x + radius); ++u)
      std::copy(color.begin(), color.end(), image.at(u, v));
}

// The seam before (red) and after (green) the displacement, on the parent.
Image of_seams(const LightPicture& parent, const Transfer& t) {
  Image out = to_image(parent);
  const auto draw = [&](const Mask& child, std::array<std::uint8_t, 3> color) {
    for (int y = 0; y + 1 < out.height; ++y)
      for (int x = 0; x + 1 < out.width; ++x) {
        const std::size_t i = parent.index(x, y);
        if (child[i] != child[i + 1] || child[i] != child[parent.index(x, y + 1)]) dot(out, x, y, 1, color);
      }
  };
  if (!t.first_seam.child.empty()) draw(t.first_seam.child, {230, 30, 30});
  draw(t.seam.child, {40, 220, 60});
  return out;
}

// Edges of the parent in red, of the child in yellow, what was matched in cyan.
Image of_edges(const LightPicture& parent, const Transfer& t) {
  Image out = to_image(parent);
  for (std::uint8_t& v : out.pixels) v = static_cast<std::uint8_t>(v / 2);
  const Structure& s = t.structure;
  for (std::size_t i = 0; i < s.edges_parent.size(); ++i) {
    const int x = static_cast<int>(i % static_cast<std::size_t>(out.width)),
              y = static_cast<int>(i / static_cast<std::size_t>(out.width));
    if (s.edges_parent[i] != 0) dot(out, x, y, 0, {230, 40, 40});
    if (s.edges_child[i] != 0) dot(out, x, y, 0, {240, 220, 40});
  }
  for (const EdgePair& e : s.along_edges)
    dot(out, static_cast<int>(e.parent.x()), static_cast<int>(e.parent.y()), 0, {60, 120, 255});
  for (const EdgePair& e : s.on_seam)
    dot(out, static_cast<int>(e.parent.x()), static_cast<int>(e.parent.y()), 1, {40, 240, 240});
  return out;
}

// Grey does not move; red right, the opposite left, brighter up; full colour at 6 px.
Image of_displacement(const LightPicture& d) {
  Image out(d.width, d.height, 3, 128);
  for (std::size_t i = 0; i < d.pixels.size(); ++i) {
    const auto step = [](float v) {
      return static_cast<int>(std::lround(std::clamp(v / 6.0F, -1.0F, 1.0F) * 120));
    };
    const int x = step(d.pixels[i][0]), y = step(d.pixels[i][1]);
    out.pixels[3 * i] = static_cast<std::uint8_t>(128 + x);
    out.pixels[3 * i + 1] = static_cast<std::uint8_t>(128 + y);
    out.pixels[3 * i + 2] = static_cast<std::uint8_t>(128 - x);
  }
  return out;
}

Image of_alpha(const Field& alpha) {
  Image out(alpha.width, alpha.height, 1);
  for (std::size_t i = 0; i < alpha.values.size(); ++i)
    out.pixels[i] = static_cast<std::uint8_t>(std::lround(255 * alpha.values[i]));
  return out;
}

}  // namespace

Result<void> save_steps(const LightPicture& child, const LightPicture& parent, const Transfer& t,
                        const std::filesystem::path& folder, const std::string& name) {
  const auto save = [&](const char* step, const Image& picture) {
    return save_png(picture, folder / text(name, "-", step, ".png"));
  };
  if (Result<void> ok = save("1-parent", to_image(parent)); !ok) return ok;
  if (Result<void> ok = save("2-child", to_image(child)); !ok) return ok;
  if (Result<void> ok = save("3-tones", to_image(t.toned)); !ok) return ok;
  if (Result<void> ok = save("4-same", of_mask(t.same, child.width, child.height)); !ok) return ok;
  if (Result<void> ok = save("5-seams", of_seams(parent, t)); !ok) return ok;
  if (!t.structure.edges_child.empty()) {
    if (Result<void> ok = save("6-edges", of_edges(parent, t)); !ok) return ok;
    if (Result<void> ok = save("6-moves", of_displacement(t.structure.displacement)); !ok) return ok;
  }
  if (Result<void> ok = save("7-adjusted", to_image(t.adjusted)); !ok) return ok;
  return save("8-mask", of_alpha(t.alpha));
}

}  // namespace floatstage::detail
