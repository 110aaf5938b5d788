#pragma once

#include <algorithm>
#include <array>
#include <queue>
#include <vector>

#include "core/image.h"
#include "core/matte_edits.h"

namespace floatstage::matting {

/// What a careful person draws next who sees the truth: into the largest fault of a matte, along it
/// (`scribble`) or with one click in its middle, as broad as it stays right.
class Operator {
 public:
  explicit Operator(const Image& truth) : truth_(truth) {}

  /// No points when nothing but outlines differs.
  MatteStroke next(const Image& matte, bool scribble) const {
    const std::vector<std::size_t> fault = largest_fault(matte);
    MatteStroke stroke;
    if (fault.empty()) return stroke;
    const bool subject = truth_.pixels[fault.front()] >= 128;
    stroke.label = subject ? MatteLabel::Foreground : MatteLabel::Background;
    // How deep in its label of the truth, and in the fault, a pixel lies.
    std::vector<std::uint8_t> label(truth_.pixels.size()), in(label.size());
    for (std::size_t p = 0; p < label.size(); ++p) label[p] = (truth_.pixels[p] >= 128) == subject;
    for (const std::size_t p : fault) in[p] = 1;
    const std::vector<float> room = depth(label), deep = depth(in);
    const std::size_t middle =
        *std::max_element(fault.begin(), fault.end(), [&](auto a, auto b) { return deep[a] < deep[b]; });
    std::vector<std::size_t> path = {middle};
    if (scribble) {
      const float least = deep[middle] / 2;
      const std::size_t one = walk(in, deep, least, middle).back();
      path = walk(in, deep, least, one);
    }
    float narrowest = 1e9f;
    for (const std::size_t p : path) narrowest = std::min(narrowest, room[p]);
    stroke.radius = std::clamp(narrowest - 1.5, 0.5, scribble ? 12.0 : 4.0);
    for (std::size_t i = 0; i < path.size(); i += 6) stroke.points.push_back(point(path[i]));
    if (path.size() > 1) stroke.points.push_back(point(path.back()));
    return stroke;
  }

 private:
  Eigen::Vector2d point(std::size_t p) const {
    return {static_cast<double>(p % truth_.width) + 0.5, static_cast<double>(p / truth_.width) + 0.5};
  }
  std::array<std::size_t, 4> around(std::size_t p) const {
    const std::size_t w = static_cast<std::size_t>(truth_.width), x = p % w, y = p / w;
    return {x > 0 ? p - 1 : p, x + 1 < w ? p + 1 : p, y > 0 ? p - w : p,
            y + 1 < static_cast<std::size_t>(truth_.height) ? p + w : p};
  }
  // In city blocks, the picture's sides do not bound.
  std::vector<float> depth(const std::vector<std::uint8_t>& in) const {
    std::vector<float> d(in.size(), 1e9f);
    std::queue<std::size_t> open;
    for (std::size_t p = 0; p < in.size(); ++p)
      if (!in[p]) d[p] = 0, open.push(p);
    for (; !open.empty(); open.pop())
      for (const std::size_t q : around(open.front()))
        if (d[q] > d[open.front()] + 1) d[q] = d[open.front()] + 1, open.push(q);
    return d;
  }
  // The fault of the largest area, counted without what is only two pixels thick.
  std::vector<std::size_t> largest_fault(const Image& matte) const {
    std::vector<std::uint8_t> wrong(truth_.pixels.size());
    for (std::size_t p = 0; p < wrong.size(); ++p)
      wrong[p] = (truth_.pixels[p] >= 128) != (matte.pixels[p] >= 128);
    const std::vector<float> deep = depth(wrong);
    std::vector<std::size_t> best;
    std::vector<std::uint8_t> seen(wrong.size());
    for (std::size_t start = 0; start < wrong.size(); ++start) {
      if (deep[start] < 2 || seen[start]) continue;
      std::vector<std::size_t> one = {start};
      seen[start] = 1;
      for (std::size_t i = 0; i < one.size(); ++i)
        for (const std::size_t q : around(one[i]))
          if (deep[q] >= 2 && !seen[q] && (truth_.pixels[q] >= 128) == (truth_.pixels[start] >= 128))
            seen[q] = 1, one.push_back(q);
      if (one.size() > best.size()) best = std::move(one);
    }
    return best;
  }
  // The shortest way within the fault to what is farthest from `from`.
  std::vector<std::size_t> walk(const std::vector<std::uint8_t>& in, const std::vector<float>& deep,
                                float least, std::size_t from) const {
    std::vector<std::size_t> before(in.size(), in.size());
    std::queue<std::size_t> open;
    open.push(from), before[from] = from;
    std::size_t last = from;
    for (; !open.empty(); open.pop()) {
      last = open.front();
      for (const std::size_t q : around(last))
        if (in[q] && deep[q] >= least && before[q] == in.size()) before[q] = last, open.push(q);
    }
    std::vector<std::size_t> way = {last};
    while (way.back() != from) way.push_back(before[way.back()]);
    std::reverse(way.begin(), way.end());
    return way;
  }

  const Image& truth_;
};

}  // namespace floatstage::matting
