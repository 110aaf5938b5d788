// Method:  what gradients agree on over pictures of other scenes
// ADR:     0206

#include "core/added_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <utility>

#include "core/statistics.h"

namespace floatstage {
namespace {

constexpr int kFewCameras = 3, kFewInstants = 8;
constexpr double kAgree = 0.8;         // of the pictures have the contour
constexpr double kLeastContrast = 24;  // 8-bit steps over two pixels …
constexpr double kOverNoise = 8;       // … or times the noise, whichever is more
constexpr int kFine = 6;               // turns of dark and bright in one row: writing, no outline
constexpr double kTallest = 0.2, kWidest = 0.75, kLargest = 0.08;  // of the picture's height, width, area
constexpr int kFewestPixels = 24;
constexpr double kChanges = 3;      // times what a contour's own colours spread, around it
constexpr double kGlyphSteps = 16;  // that writing's colour differs by

// Pictures of one size with other scenes behind what was added.
struct Stack {
  std::vector<std::size_t> cameras = {};  // of each picture
  std::vector<const Image*> pictures = {};
  PixelBox part = {};
  bool over_time = false;
};

struct Gradient {
  int x = 0, y = 0;
};

std::vector<std::uint8_t> grey_of(const Image& p) {
  std::vector<std::uint8_t> grey(static_cast<std::size_t>(p.width) * static_cast<std::size_t>(p.height));
  for (std::size_t i = 0; i < grey.size(); ++i) {
    const std::uint8_t* rgb = p.pixels.data() + 3 * i;
    grey[i] = static_cast<std::uint8_t>((77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2]) >> 8);
  }
  return grey;
}

class OverlaySearch {
 public:
  explicit OverlaySearch(const Stack& stack)
      : stack_(stack), w_(stack.pictures[0]->width), h_(stack.pictures[0]->height) {
    for (const Image* p : stack.pictures) grey_.push_back(grey_of(*p));
    least_ = std::max(kLeastContrast, kOverNoise * noise());
  }

  // Boxes, and for each the pictures that show what is in it.
  std::vector<std::pair<PixelBox, std::vector<std::size_t>>> find() {
    std::vector<std::pair<PixelBox, std::vector<std::size_t>>> found;
    mark_contours();
    for (const PixelBox& box : groups()) {
      if (!is_overlay(box)) continue;
      std::vector<std::size_t> who = showing(box);
      if (!who.empty()) found.emplace_back(with_margin(along_the_line(box)), std::move(who));
    }
    return found;
  }

 private:
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(w_) + static_cast<std::size_t>(x);
  }
  Gradient gradient(std::size_t k, int x, int y) const {
    const std::vector<std::uint8_t>& g = grey_[k];
    return {g[index(x + 1, y)] - g[index(x - 1, y)], g[index(x, y + 1)] - g[index(x, y - 1)]};
  }
  bool outer(int x, int y) const { return 4 * x < w_ || 4 * x >= 3 * w_ || 4 * y < h_ || 4 * y >= 3 * h_; }
  bool within(int x, int y, int by) const {
    const PixelBox& p = stack_.part;
    return x >= p.x + by && y >= p.y + by && x < p.x + p.width - by && y < p.y + p.height - by;
  }

  // The median difference of neighbours: noise wherever more than half of a picture is calm.
  double noise() const {
    std::vector<int> steps;
    for (const auto& g : grey_)
      for (int y = 0; y < h_; y += 4)
        for (int x = 1; x < w_; x += 4) steps.push_back(std::abs(g[index(x, y)] - g[index(x - 1, y)]));
    return steps.empty() ? 0 : median(std::move(steps));
  }

  // Where the pictures agree on a contour.
  void mark_contours() {
    contour_.assign(index(0, h_), 0);
    const std::size_t n = grey_.size();
    std::vector<Gradient> all(n);
    std::vector<int> xs(n), ys(n);
    for (int y = 1; y + 1 < h_; ++y)
      for (int x = 1; x + 1 < w_; ++x) {
        if (!outer(x, y) || !within(x, y, 2)) continue;
        std::size_t strong = 0;
        for (std::size_t k = 0; k < n && strong + (n - k) >= (n + 1) / 2; ++k) {
          all[k] = gradient(k, x, y);
          xs[k] = all[k].x, ys[k] = all[k].y;
          strong += std::max(std::abs(xs[k]), std::abs(ys[k])) >= least_ / 2;
        }
        if (strong < (n + 1) / 2) continue;
        const Gradient m{percentile_in_place(std::span<int>(xs), 0.5),
                         percentile_in_place(std::span<int>(ys), 0.5)};
        const double size = std::hypot(m.x, m.y), slack = std::max(10.0, size / 3);
        if (size < least_) continue;
        const auto agree = std::count_if(all.begin(), all.end(), [&](const Gradient& g) {
          return std::abs(g.x - m.x) <= slack && std::abs(g.y - m.y) <= slack;
        });
        if (static_cast<double>(agree) >= kAgree * static_cast<double>(n))
          contour_[index(x, y)] = std::abs(m.x) * 2 < std::abs(m.y) ? 3 : m.x > 0 ? 1 : 2;
      }
  }

  // Boxes around contours that are nearer to one another than letters of a word.
  std::vector<PixelBox> groups() const {
    const int cell = std::max(4, h_ / 80), columns = (w_ + cell - 1) / cell, rows = (h_ + cell - 1) / cell;
    std::vector<int> count(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
    const auto at = [&](int c, int r) {
      return static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c);
    };
    for (int y = 0; y < h_; ++y)
      for (int x = 0; x < w_; ++x) count[at(x / cell, y / cell)] += contour_[index(x, y)] != 0;
    std::vector<PixelBox> boxes;
    std::vector<std::pair<int, int>> queue;
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; ++c) {
        if (count[at(c, r)] <= 0) continue;
        int pixels = 0, x0 = w_, y0 = h_, x1 = -1, y1 = -1;
        queue.assign(1, {c, r});
        pixels += std::exchange(count[at(c, r)], -1);
        while (!queue.empty()) {
          const auto [i, j] = queue.back();
          queue.pop_back();
          for (int y = j * cell; y < std::min(h_, (j + 1) * cell); ++y)
            for (int x = i * cell; x < std::min(w_, (i + 1) * cell); ++x)
              if (contour_[index(x, y)])
                x0 = std::min(x0, x), x1 = std::max(x1, x), y0 = std::min(y0, y), y1 = std::max(y1, y);
          for (int v = std::max(0, j - 1); v <= std::min(rows - 1, j + 1); ++v)
            for (int u = std::max(0, i - 3); u <= std::min(columns - 1, i + 3); ++u)
              if (count[at(u, v)] > 0) {
                pixels += std::exchange(count[at(u, v)], -1);
                queue.emplace_back(u, v);
              }
        }
        if (pixels >= kFewestPixels) boxes.push_back({x0, y0, x1 - x0 + 1, y1 - y0 + 1});
      }
    return boxes;
  }

  // Most turns of dark and bright along a row.
  int turns_in(const PixelBox& box) const {
    int most = 0;
    for (int y = box.y; y < box.y + box.height; ++y) {
      int turns = 0, last = 0;
      for (int x = box.x; x < box.x + box.width; ++x) {
        const int now = contour_[index(x, y)];
        if (now != 0 && now != 3 && now != last) ++turns, last = now;
      }
      most = std::max(most, turns);
    }
    return most;
  }

  // How far a tenth of the pictures are from the usual one at a place.
  double spread(int x, int y) const {
    std::vector<int> values;
    for (const auto& g : grey_) values.push_back(g[index(x, y)]);
    const int middle = median(values);
    for (int& v : values) v = std::abs(v - middle);
    return percentile(std::move(values), 0.9);
  }

  bool is_overlay(const PixelBox& b) const {
    const int right = b.x + b.width, bottom = b.y + b.height;
    const bool aside = 4 * right <= w_ || 4 * b.x >= 3 * w_ || 4 * bottom <= h_ || 4 * b.y >= 3 * h_;
    if (!aside || b.height < 5 || b.width < 6 || b.height > kTallest * h_ || b.width > kWidest * w_ ||
        static_cast<double>(b.width) * b.height > kLargest * w_ * h_)
      return false;
    const bool fine = turns_in(b) >= kFine;
    if (stack_.over_time && !fine) return false;
    return changes_around(b) || (fine && !stack_.over_time);
  }

  bool changes_around(const PixelBox& b) const {
    std::vector<double> within_it, around;
    constexpr int kNear = 3, kFar = 9;
    for (int y = b.y - kFar; y < b.y + b.height + kFar; ++y)
      for (int x = b.x - kFar; x < b.x + b.width + kFar; ++x) {
        if (!within(x, y, 1)) continue;
        const bool in =
            x >= b.x - kNear && y >= b.y - kNear && x < b.x + b.width + kNear && y < b.y + b.height + kNear;
        if (!in)
          around.push_back(spread(x, y));
        else if (x >= b.x && y >= b.y && x < b.x + b.width && y < b.y + b.height && contour_[index(x, y)])
          within_it.push_back(spread(x, y));
      }
    if (around.empty() || within_it.empty()) return false;
    return median(std::move(around)) >=
           kChanges * std::max(median(std::move(within_it)), least_ / kOverNoise);
  }

  // Pictures that have most of the box's contours.
  std::vector<std::size_t> showing(const PixelBox& b) const {
    std::vector<std::size_t> who;
    for (std::size_t k = 0; k < grey_.size(); ++k) {
      int all = 0, here = 0;
      for (int y = b.y; y < b.y + b.height; ++y)
        for (int x = b.x; x < b.x + b.width; ++x) {
          const int kind = contour_[index(x, y)];
          if (kind == 0) continue;
          const Gradient g = gradient(k, x, y);
          ++all;
          here +=
              std::max(std::abs(g.x), std::abs(g.y)) >= least_ / 2 && (kind == 3 || (g.x > 0) == (kind == 1));
        }
      if (2 * here > all) who.push_back(stack_.cameras[k]);
    }
    return who;
  }

  // The colour of the writing: of what stays the same in the box, the rarer end.
  int glyph_grey(const PixelBox& b) const {
    std::vector<int> steady;
    for (int y = b.y; y < b.y + b.height; ++y)
      for (int x = b.x; x < b.x + b.width; ++x)
        if (contour_[index(x, y)])
          for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}})
            if (within(x + dx, y + dy, 1) && spread(x + dx, y + dy) <= kGlyphSteps)
              steady.push_back(grey_[0][index(x + dx, y + dy)]);
    if (steady.empty()) return -1;
    const int low = percentile(steady, 0.1), high = percentile(steady, 0.9), middle = median(steady);
    return high - middle >= middle - low ? high : low;
  }

  // Whether most pictures show strokes of that colour, side by side with another, in columns x0 … x1.
  bool written(const PixelBox& b, int x0, int x1, int grey) const {
    std::size_t yes = 0;
    for (std::size_t k = 0; k < grey_.size(); ++k) {
      int strokes = 0;
      for (int y = b.y; y < b.y + b.height; ++y)
        for (int x = std::max(x0, 1); x < std::min(x1, w_ - 1); ++x) {
          if (!within(x, y, 1) || std::abs(grey_[k][index(x, y)] - grey) > kGlyphSteps) continue;
          const Gradient g = gradient(k, x, y);
          strokes += std::max(std::abs(g.x), std::abs(g.y)) >= 2 * least_;
        }
      yes += 2 * strokes >= b.height;
    }
    return static_cast<double>(yes) >= kAgree * static_cast<double>(grey_.size());
  }

  // Digits that change, before and behind what stays.
  PixelBox along_the_line(PixelBox b) const {
    const int grey = glyph_grey(b), step = std::max(4, b.height), steps = 8;
    if (grey < 0 || b.height > h_ / 10) return b;
    for (int i = 0; i < steps && written(b, b.x + b.width, b.x + b.width + step, grey); ++i) b.width += step;
    for (int i = 0; i < steps && written(b, b.x - step, b.x, grey); ++i) b.x -= step, b.width += step;
    return b;
  }

  PixelBox with_margin(const PixelBox& b) const {
    const int by = std::clamp(b.height / 4, 3, 8);  // outlines, shadows and what a codec made of them
    const PixelBox& p = stack_.part;
    const int x0 = std::max(p.x, b.x - by), y0 = std::max(p.y, b.y - by);
    return {x0, y0, std::min(p.x + p.width, b.x + b.width + by) - x0,
            std::min(p.y + p.height, b.y + b.height + by) - y0};
  }

  const Stack& stack_;
  int w_, h_;
  double least_ = 0;
  std::vector<std::vector<std::uint8_t>> grey_;
  std::vector<std::uint8_t> contour_;  // 0 none, 1 brighter to the right, 2 darker, 3 lies flat
};

PixelBox cut(const PixelBox& a, const PixelBox& b) {
  const int x0 = std::max(a.x, b.x), y0 = std::max(a.y, b.y);
  return {x0, y0, std::min(a.x + a.width, b.x + b.width) - x0, std::min(a.y + a.height, b.y + b.height) - y0};
}

bool meet(const PixelBox& a, const PixelBox& b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

void add(PixelBox box, std::vector<PixelBox>& boxes) {
  for (std::size_t i = 0; i < boxes.size();) {
    if (!meet(box, boxes[i])) {
      ++i;
      continue;
    }
    const PixelBox& o = boxes[i];
    const int x1 = std::max(box.x + box.width, o.x + o.width),
              y1 = std::max(box.y + box.height, o.y + o.height);
    box.x = std::min(box.x, o.x), box.y = std::min(box.y, o.y);
    box.width = x1 - box.x, box.height = y1 - box.y;
    boxes.erase(boxes.begin() + static_cast<std::ptrdiff_t>(i));
    i = 0;
  }
  boxes.push_back(box);
}

void search(const Stack& stack, std::vector<AddedContent>& out) {
  if (stack.part.width < 16 || stack.part.height < 16) return;
  for (const auto& [box, cameras] : OverlaySearch(stack).find())
    for (const std::size_t camera : cameras) add(box, out[camera].overlays);
}

}  // namespace

std::vector<AddedContent> find_added(std::span<const std::vector<Image>> pictures) {
  std::vector<AddedContent> out(pictures.size());
  std::map<std::array<int, 2>, Stack> sizes;  // cameras alike
  for (std::size_t i = 0; i < pictures.size(); ++i) {
    if (pictures[i].empty() || pictures[i][0].empty() || pictures[i][0].channels != 3) continue;
    out[i] = added_bars(pictures[i]);
    const Image& first = pictures[i][0];
    Stack& alike = sizes[{first.width, first.height}];
    const PixelBox part = inside(out[i], first.width, first.height);
    alike.part = alike.pictures.empty() ? part : cut(part, alike.part);
    alike.cameras.push_back(i);
    alike.pictures.push_back(&first);
    Stack own{.part = part, .over_time = true};
    for (const Image& p : pictures[i])
      if (p.width == first.width && p.height == first.height && p.channels == 3)
        own.pictures.push_back(&p), own.cameras.push_back(i);
    if (own.pictures.size() >= kFewInstants) {
      std::vector<AddedContent> mine(pictures.size());
      search(own, mine);
      for (const PixelBox& box : mine[i].overlays) add(box, out[i].overlays);
    }
  }
  for (const auto& [size, alike] : sizes)
    if (alike.pictures.size() >= kFewCameras) search(alike, out);
  for (AddedContent& a : out)
    std::sort(a.overlays.begin(), a.overlays.end(),
              [](const PixelBox& p, const PixelBox& q) { return std::pair(p.y, p.x) < std::pair(q.y, q.x); });
  return out;
}

}  // namespace floatstage
