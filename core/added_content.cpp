#include "core/added_content.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include "core/text.h"

namespace floatstage {
namespace {

constexpr int kReach = 3;  // px outside of a box, and along it, whose mean stands for its side

PixelBox cut(const PixelBox& box, const PixelBox& to) {
  const int x0 = std::max(box.x, to.x), y0 = std::max(box.y, to.y);
  const int x1 = std::min(box.x + box.width, to.x + to.width),
            y1 = std::min(box.y + box.height, to.y + to.height);
  return {x0, y0, x1 - x0, y1 - y0};
}

using Mean = std::array<double, 4>;

// Of a few pixels around (x, y), as far as they are within `part`; nothing where none is.
std::optional<Mean> mean_of(const Image& p, int x0, int y0, int x1, int y1, const PixelBox& part) {
  const PixelBox box = cut({x0, y0, x1 - x0 + 1, y1 - y0 + 1}, part);
  if (box.empty()) return std::nullopt;
  Mean sum{};
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x)
      for (int c = 0; c < p.channels; ++c) sum[static_cast<std::size_t>(c)] += p.at(x, y)[c];
  for (double& s : sum) s /= box.width * box.height;
  return sum;
}

void fill_overlay(const PixelBox& box, const PixelBox& part, Image& picture) {
  const int right = box.x + box.width, bottom = box.y + box.height;
  std::vector<std::optional<Mean>> above, below;
  for (int x = box.x; x < right; ++x) {
    above.push_back(mean_of(picture, x - 1, box.y - kReach, x + 1, box.y - 1, part));
    below.push_back(mean_of(picture, x - 1, bottom, x + 1, bottom + kReach - 1, part));
  }
  for (int y = box.y; y < bottom; ++y) {
    const auto before = mean_of(picture, box.x - kReach, y - 1, box.x - 1, y + 1, part),
               after = mean_of(picture, right, y - 1, right + kReach - 1, y + 1, part);
    for (int x = box.x; x < right; ++x) {
      const auto column = static_cast<std::size_t>(x - box.x);
      Mean sum{};
      double weights = 0;
      const auto add = [&](const std::optional<Mean>& side, int distance) {
        if (!side) return;
        const double weight = 1.0 / distance;
        weights += weight;
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += weight * (*side)[c];
      };
      add(before, x - box.x + 1), add(after, right - x);
      add(above[column], y - box.y + 1), add(below[column], bottom - y);
      for (int c = 0; c < picture.channels && weights > 0; ++c)
        picture.at(x, y)[c] = static_cast<std::uint8_t>(sum[static_cast<std::size_t>(c)] / weights + 0.5);
    }
  }
}

}  // namespace

PixelBox inside(const AddedContent& a, int width, int height) {
  return {a.left, a.top, std::max(0, width - a.left - a.right), std::max(0, height - a.top - a.bottom)};
}

Image seen_by_lens(const AddedContent& added, int width, int height) {
  Image seen(width, height, 1);
  const auto fill = [&seen](const PixelBox& box, std::uint8_t value) {
    for (int y = box.y; y < box.y + box.height; ++y)
      std::fill_n(seen.at(box.x, y), std::max(box.width, 0), value);
  };
  const PixelBox part = inside(added, width, height);
  fill(part, 255);
  for (const PixelBox& overlay : added.overlays) fill(cut(overlay, part), 0);
  return seen;
}

Image without(const AddedContent& added, Image picture) {
  const PixelBox part = inside(added, picture.width, picture.height);
  if (picture.empty() || part.empty()) return picture;
  for (const PixelBox& overlay : added.overlays)
    if (const PixelBox box = cut(overlay, part); !box.empty()) fill_overlay(box, part, picture);
  if (!added.bars()) return picture;
  const int right = part.x + part.width - 1, bottom = part.y + part.height - 1;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const int u = std::clamp(x, part.x, right), v = std::clamp(y, part.y, bottom);
      if (u != x || v != y) std::copy_n(picture.at(u, v), picture.channels, picture.at(x, y));
    }
  return picture;
}

std::string describe(const AddedContent& a) {
  std::string bars;
  const auto bar = [&](const char* side, int lines) {
    if (lines > 0) bars += text(bars.empty() ? "" : ", ", side, " ", lines, " px");
  };
  bar("left", a.left), bar("top", a.top), bar("right", a.right), bar("bottom", a.bottom);
  if (a.overlays.empty()) return bars;
  std::string boxes;
  for (const PixelBox& b : a.overlays)
    boxes += text(boxes.empty() ? "" : ", ", b.width, "x", b.height, " at (", b.x, ", ", b.y, ")");
  return text(bars, bars.empty() ? "" : "; ", a.overlays.size(),
              a.overlays.size() == 1 ? " overlay: " : " overlays: ", boxes);
}

std::vector<std::string> describe(const std::map<std::string, AddedContent>& by_serial) {
  std::vector<std::pair<AddedContent, std::vector<std::string>>> alike;
  for (const auto& [serial, content] : by_serial) {
    if (content.none()) continue;
    const auto same = std::find_if(alike.begin(), alike.end(),
                                   [&wanted = content](const auto& a) { return a.first == wanted; });
    if (same == alike.end())
      alike.push_back({content, {serial}});
    else
      same->second.push_back(serial);
  }
  std::vector<std::string> all;
  for (const auto& [content, serials] : alike) {
    std::string names;
    for (const std::string& s : serials) names += text(names.empty() ? "'" : ", '", s, "'");
    all.push_back(text(serials.size() == 1 ? "camera " : "cameras ", names, ": ", describe(content)));
  }
  return all;
}

}  // namespace floatstage
