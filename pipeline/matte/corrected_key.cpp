#include "pipeline/matte/corrected_key.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "matting/closed_form.h"
#include "matting/view_cut.h"

namespace floatstage::pipeline {
namespace {

constexpr int kLongest = 480;    // px: in a cut of 1024x768, five of its pixels are eleven
constexpr int kThick = 2;        // the cut's pixels around one: less wide is an outline or a strand
constexpr int kAround = 2;       // the cut's pixels around a part that is replaced with it
constexpr double kLacks = 0.05;  // of the inside: as kAllowed of recon/silhouette_audit.cpp

// A part of one picture's grid of pixels, by coordinates.
using Part = std::vector<std::pair<int, int>>;

/// Where the key, at the cut's size, differs from the cut: 1 it lacks the pixel, -1 it has too much, 0 else.
struct Difference {
  int w, h;
  std::vector<signed char> sign;

  Difference(const Image& key, const Image& cut) : w(cut.width), h(cut.height), sign(cut.pixels.size(), 0) {
    const Image small = matting::shrunk(key, w, h);
    for (std::size_t p = 0; p < sign.size(); ++p)
      sign[p] = static_cast<signed char>((cut.pixels[p] >= 128) - (small.pixels[p] >= 128));
  }
  int at(int x, int y) const {
    return x < 0 || y < 0 || x >= w || y >= h ? 0 : sign[static_cast<std::size_t>(y) * w + x];
  }
  bool thick(int x, int y) const {
    for (int dy = -kThick; dy <= kThick; ++dy)
      for (int dx = -kThick; dx <= kThick; ++dx)
        if (at(x + dx, y + dy) != at(x, y)) return false;
    return true;
  }
};

// What hangs together with a differing pixel, and is of its sign.
Part part_around(const Difference& difference, int x, int y, std::vector<bool>& seen) {
  Part part = {{x, y}};
  seen[static_cast<std::size_t>(y) * difference.w + x] = true;
  for (std::size_t i = 0; i < part.size(); ++i) {
    const auto [px, py] = part[i];
    for (const auto& [dx, dy] : {std::pair(1, 0), std::pair(-1, 0), std::pair(0, 1), std::pair(0, -1)}) {
      const int qx = px + dx, qy = py + dy;
      if (difference.at(qx, qy) != difference.at(x, y)) continue;
      if (const std::size_t q = static_cast<std::size_t>(qy) * difference.w + qx; !seen[q]) {
        seen[q] = true;
        part.emplace_back(qx, qy);
      }
    }
  }
  return part;
}

// The cut's pixels whose opacities are taken from the refined cut.
std::vector<bool> replaced(const Difference& difference) {
  std::vector<bool> marked(difference.sign.size(), false), seen = marked;
  for (int y = 0; y < difference.h; ++y)
    for (int x = 0; x < difference.w; ++x) {
      if (difference.at(x, y) == 0 || seen[static_cast<std::size_t>(y) * difference.w + x]) continue;
      const Part part = part_around(difference, x, y, seen);
      if (std::none_of(part.begin(), part.end(),
                       [&](const auto& p) { return difference.thick(p.first, p.second); }))
        continue;
      for (const auto& [px, py] : part)
        for (int v = std::max(0, py - kAround); v <= std::min(difference.h - 1, py + kAround); ++v)
          for (int u = std::max(0, px - kAround); u <= std::min(difference.w - 1, px + kAround); ++u)
            marked[static_cast<std::size_t>(v) * difference.w + u] = true;
    }
  return marked;
}

// The cut's pixels that only subject surrounds.
std::vector<bool> inside_of(const Image& cut) {
  std::vector<bool> inside(cut.pixels.size(), false);
  for (int y = 0; y < cut.height; ++y)
    for (int x = 0; x < cut.width; ++x) {
      bool all = true;
      for (int v = std::max(0, y - 1); v <= std::min(cut.height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(cut.width - 1, x + 1); ++u)
          all = all && *cut.at(u, v) >= 128;
      inside[static_cast<std::size_t>(y) * cut.width + x] = all;
    }
  return inside;
}

}  // namespace

Image coarse_cut(const Image& mask) {
  const double scale = std::min(1.0, static_cast<double>(kLongest) / std::max(mask.width, mask.height));
  return matting::shrunk(mask, std::max(1, static_cast<int>(mask.width * scale)),
                         std::max(1, static_cast<int>(mask.height * scale)));
}

Result<Image> corrected_key(const Image& picture, const Image& key, const Image& cut) {
  if (picture.channels != 3 || key.channels != 1 || cut.channels != 1 || cut.empty() ||
      key.width != picture.width || key.height != picture.height || cut.width > key.width ||
      cut.height > key.height)
    return fail(ErrorCode::InvalidArgument, "a key is of its picture's size, and the cut no larger");
  const std::vector<bool> marked = replaced(Difference(key, cut)), inside = inside_of(cut);
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y * cut.height / key.height) * static_cast<std::size_t>(cut.width) +
           static_cast<std::size_t>(x * cut.width / key.width);
  };
  std::size_t within = 0, lacks = 0;
  for (int y = 0; y < key.height; ++y)
    for (int x = 0; x < key.width; ++x)
      if (inside[at(x, y)]) ++within, lacks += *key.at(x, y) < 128;
  const bool pattern = static_cast<double>(lacks) > kLacks * static_cast<double>(within);
  if (!pattern && std::find(marked.begin(), marked.end(), true) == marked.end()) return key;
  const Result<Image> fine = matting::refine_matte(picture, cut, matting::key_refinement(), {});
  if (!fine) return forward(fine);
  Image out = key;
  for (int y = 0; y < key.height; ++y)
    for (int x = 0; x < key.width; ++x) {
      std::uint8_t& alpha = *out.at(x, y);
      if (marked[at(x, y)]) alpha = *fine->at(x, y);
      if (pattern && inside[at(x, y)]) alpha = std::max(alpha, *fine->at(x, y));
    }
  return out;
}

}  // namespace floatstage::pipeline
