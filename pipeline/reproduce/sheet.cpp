#include "pipeline/reproduce/sheet.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "pipeline/label.h"

namespace floatstage::pipeline {
namespace {

constexpr int kGap = 4, kMargin = 8;             // px
constexpr std::uint8_t kGround = 40;             // level between pictures
constexpr int kWidest = 480;                     // px: larger pictures are shown as means of 2 x 2, 3 x 3 …
constexpr int kCloseUp = 96, kCloseUpSteps = 8;  // px

Image shrunk_to_fit(const Image& rgb) {
  const int n = (std::max(rgb.width, rgb.height) + kWidest - 1) / kWidest;
  if (n <= 1) return rgb;
  Image small(rgb.width / n, rgb.height / n, 3);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      for (int c = 0; c < 3; ++c) {
        int sum = 0;
        for (int k = 0; k < n * n; ++k) sum += rgb.at(x * n + k % n, y * n + k / n)[c];
        small.at(x, y)[c] = static_cast<std::uint8_t>((sum + n * n / 2) / (n * n));
      }
  return small;
}

}  // namespace

Image sheet_of(const std::vector<SheetRow>& rows) {
  int width = 0, height = 0;
  std::vector<int> heights;
  for (const SheetRow& row : rows) {
    int across = 0, down = 0;
    for (const SheetCell& cell : row) {
      across += cell.picture.width + (across > 0 ? kGap : 0);
      down = std::max(down, cell.picture.height);
    }
    width = std::max(width, across);
    height += down + (height > 0 ? kGap : 0);
    heights.push_back(down);
  }
  Image sheet(width, height, 3, kGround);
  int top = 0;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    int left = 0;
    for (const SheetCell& cell : rows[r]) {
      for (int y = 0; y < cell.picture.height; ++y)
        std::memcpy(sheet.at(left, top + y), cell.picture.at(0, y),
                    3 * static_cast<std::size_t>(cell.picture.width));
      label(sheet, left, top, heights[r], cell.name);
      left += cell.picture.width + kGap;
    }
    top += heights[r] + kGap;
  }
  return sheet;
}

PictureWindow window_about(const Image& mask) {
  int x0 = mask.width, y0 = mask.height, x1 = 0, y1 = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (*mask.at(x, y) < 128) continue;
      x0 = std::min(x0, x), y0 = std::min(y0, y), x1 = std::max(x1, x + 1), y1 = std::max(y1, y + 1);
    }
  if (x1 <= x0) return {0, 0, mask.width, mask.height};
  x0 = std::max(x0 - kMargin, 0), y0 = std::max(y0 - kMargin, 0);
  x1 = std::min(x1 + kMargin, mask.width), y1 = std::min(y1 + kMargin, mask.height);
  return {x0, y0, x1 - x0, y1 - y0};
}

PictureWindow worst_window(const Image& picture, const Image& truth, const Image& mask, int side) {
  side = std::min({side, mask.width, mask.height});
  PictureWindow worst{0, 0, side, side};
  double most = -1;
  const int step = std::max(side / kCloseUpSteps, 1);
  for (int y0 = 0; y0 + side <= mask.height; y0 += step)
    for (int x0 = 0; x0 + side <= mask.width; x0 += step) {
      double sum = 0;
      for (int y = y0; y < y0 + side; ++y)
        for (int x = x0; x < x0 + side; ++x) {
          if (*mask.at(x, y) < 128) continue;
          for (int c = 0; c < 3; ++c) sum += std::abs(picture.at(x, y)[c] - truth.at(x, y)[c]);
        }
      if (sum > most) most = sum, worst.x = x0, worst.y = y0;
    }
  return worst;
}

Image cut(const Image& picture, const PictureWindow& window, int zoom) {
  Image out(window.width * zoom, window.height * zoom, 3);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      std::memcpy(out.at(x, y), picture.at(window.x + x / zoom, window.y + y / zoom), 3);
  return out;
}

std::vector<SheetRow> rows_of(const ComparedView& view, const std::vector<std::string>& methods,
                              const std::string& worst_of) {
  const PictureWindow whole = window_about(view.mask),
                      close = worst_window(view.rendered.at(worst_of), view.truth, view.mask, kCloseUp);
  std::vector<SheetRow> rows(2);
  int zoom = 1;
  auto add = [&](const std::string& name, const Image& picture) {
    rows[0].push_back({name, shrunk_to_fit(cut(picture, whole, 1))});
    zoom = std::max(1, rows[0].back().picture.width / close.width);
    rows[1].push_back({name, cut(picture, close, zoom)});
  };
  add("truth", view.truth);
  for (const std::string& method : methods) add(method, view.rendered.at(method));
  return rows;
}

}  // namespace floatstage::pipeline
