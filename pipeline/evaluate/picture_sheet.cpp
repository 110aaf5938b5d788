#include "pipeline/evaluate/picture_sheet.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "pipeline/label.h"

namespace floatstage::pipeline {
namespace {

constexpr int kMargin = 8, kGap = 4, kGain = 3;

struct Box {
  int x0, y0, x1, y1;  // end exclusive
};

Box silhouette_box(const Image& silhouette) {
  Box box{silhouette.width, silhouette.height, 0, 0};
  for (int y = 0; y < silhouette.height; ++y) {
    for (int x = 0; x < silhouette.width; ++x) {
      if (silhouette.at(x, y)[0] < 128) continue;
      box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x + 1), std::max(box.y1, y + 1)};
    }
  }
  if (box.x1 <= box.x0) return {0, 0, silhouette.width, silhouette.height};
  return {std::max(box.x0 - kMargin, 0), std::max(box.y0 - kMargin, 0),
          std::min(box.x1 + kMargin, silhouette.width), std::min(box.y1 + kMargin, silhouette.height)};
}

Image difference(const Image& a, const Image& b, const Image& mask) {
  Image d(a.width, a.height, 3);
  for (std::size_t i = 0; i < d.pixels.size(); ++i)
    if (mask.pixels[i / 3])
      d.pixels[i] = static_cast<std::uint8_t>(std::min(255, kGain * std::abs(a.pixels[i] - b.pixels[i])));
  return d;
}

void paste(const Image& from, const Box& box, Image& to, int left) {
  for (int y = box.y0; y < box.y1; ++y)
    std::memcpy(to.at(left, y - box.y0), from.at(box.x0, y), static_cast<std::size_t>(box.x1 - box.x0) * 3);
}

}  // namespace

Image sheet_row(const HeldOutView& view, const std::vector<std::string>& methods) {
  const Box box = silhouette_box(view.silhouette);
  const int width = box.x1 - box.x0, columns = static_cast<int>(methods.size()) + 2;
  Image sheet(columns * (width + kGap) - kGap, box.y1 - box.y0, 3, 40);
  int left = 0;
  auto add = [&](const Image& picture, const std::string& name) {
    paste(picture, box, sheet, left);
    label(sheet, left, 0, sheet.height, name);
    left += width + kGap;
  };
  add(view.truth, "truth");
  for (const std::string& m : methods) add(view.rendered.at(m), m);
  add(difference(view.truth, view.rendered.at(methods.back()), view.mask), "difference");
  return sheet;
}

}  // namespace floatstage::pipeline
