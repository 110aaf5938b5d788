// Method:  the cheapest split of a frame into subject and background: a minimum cut
// Paper:   Y. Boykov, M.-P. Jolly, "Interactive graph cuts", 2001; J. Sun and others, "Background cut",
//          2006
// Differs: edges that the backdrop has itself cost nothing extra
// ADR:     0102, 0347

#include "matting/frame_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "core/check.h"
#include "core/grid_cut.h"
#include "matting/cut_kernels.h"
#include "matting/keyers/cloth_kernels.h"

namespace floatstage::matting {
namespace {

constexpr float kUnit = 1000;  // whole steps of the cut, which keep it exact and repeatable
constexpr std::uint8_t kSubject = 2;
constexpr float kFloor = 0.05f;  // of the smoothness: edges are never for nothing

struct Step {
  int dx, dy;
  bool diagonal;
};
// The neighbours that come later, row by row.
constexpr Step kSteps[] = {{1, 0, false}, {0, 1, false}, {1, 1, true}, {-1, 1, true}};
// All of them, in the order in which pairs are met row by row.
constexpr Step kAround[] = {{-1, -1, true}, {0, -1, false}, {1, -1, true}, {-1, 0, false},
                            {1, 0, false},  {0, 1, false},  {1, 1, true},  {-1, 1, true}};

int whole(float v) { return v < 0 ? -whole(-v) : static_cast<int>(static_cast<double>(kUnit * v) + 0.5); }

// What parting two pixels costs, by how they differ; beside each other and over a corner.
class Prices {
 public:
  Prices(float beta, float smooth, std::uint32_t most) : beta_(beta), smooth_(smooth) {
    for (std::uint32_t d = 0; d <= most; ++d) {
      const float alike = std::exp(-beta * static_cast<float>(d));
      for (const bool diagonal : {false, true}) {
        of_[diagonal].push_back(price(alike, diagonal));
        whole_[diagonal].push_back(whole(of_[diagonal].back()));
      }
      if (alike < 0.9f * kFloor) break;  // and so are all that differ more
    }
  }
  /// The largest difference in the tables; what differs more costs the same.
  std::uint32_t most() const { return static_cast<std::uint32_t>(of_[0].size() - 1); }
  const int* whole_of(bool diagonal) const { return whole_[diagonal].data(); }
  float of(int difference, bool diagonal) const {
    return of_[diagonal][std::min(static_cast<std::size_t>(difference), of_[0].size() - 1)];
  }
  float of(int difference, bool diagonal, float calm) const {
    return price(std::exp(-beta_ * calm * static_cast<float>(difference)), diagonal);
  }

 private:
  float price(float alike, bool diagonal) const {
    return smooth_ * std::max(alike, kFloor) / (diagonal ? 1.41421356f : 1);
  }
  float beta_, smooth_;
  std::array<std::vector<float>, 2> of_;
  std::array<std::vector<int>, 2> whole_;
};

// The pixels that are asked, in a box of their own with a border around it.
class Asked {
 public:
  int x0, y0, x1 = 0, y1 = 0;     // of the box
  std::vector<std::uint8_t> is;   // 1 where asked
  std::vector<std::uint8_t> all;  // 1 where all neighbours are as well

  Asked(const std::vector<std::uint8_t>& asked, const Image& picture)
      : x0(picture.width), y0(picture.height), width_(picture.width), height_(picture.height) {
    const auto is_asked = [](std::uint8_t v) { return v != 0 && v != kSubject; };
    for (int y = 0; y < height_; ++y) {
      const std::uint8_t *row = asked.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_),
                         *end = row + width_, *first = std::find_if(row, end, is_asked);
      if (first == end) continue;
      while (!is_asked(end[-1])) --end;
      x0 = std::min(x0, static_cast<int>(first - row));
      x1 = std::max(x1, static_cast<int>(end - row));
      y0 = std::min(y0, y);
      y1 = y + 1;
    }
    if (none()) return;
    stride_ = static_cast<std::size_t>(x1 - x0) + 2;
    size_ = stride_ * (static_cast<std::size_t>(y1 - y0) + 2);
    is.resize(size_ + kVector);
    all.resize(size_);
    for (int y = y0; y < y1; ++y) {
      const std::uint8_t* from =
          asked.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + x0;
      std::transform(from, from + (x1 - x0), is.data() + place(x0, y),
                     [&](std::uint8_t v) { return static_cast<std::uint8_t>(is_asked(v)); });
    }
    const std::uint8_t* own = is.data();
    std::uint8_t* out = all.data();
    for (std::size_t i = stride_ + 1; i + stride_ + 1 < size_; ++i) {
      const std::uint8_t *up = own + i - stride_, *down = own + i + stride_;
      out[i] = up[-1] & up[0] & up[1] & own[i - 1] & own[i + 1] & down[-1] & down[0] & down[1];
    }
    // Its colours, taken apart, and those around it.
    for (std::vector<std::uint8_t>& plane : planes_) plane.resize(size_ + kVector);
    const int left = std::max(x0 - 1, 0), right = std::min(x1 + 1, width_);
    for (int y = std::max(y0 - 1, 0); y < std::min(y1 + 1, height_); ++y) {
      const std::size_t to = place(left, y);
      cloth_kernels().split(picture.at(left, y), static_cast<std::size_t>(right - left),
                            planes_[0].data() + to, planes_[1].data() + to, planes_[2].data() + to);
    }
  }
  bool none() const { return x1 <= x0; }
  /// What `is` says, without what vectors read beyond it.
  std::span<const std::uint8_t> members() const { return {is.data(), size_}; }
  std::size_t place(int x, int y) const {
    return static_cast<std::size_t>(y - y0 + 1) * stride_ + static_cast<std::size_t>(x - x0 + 1);
  }
  std::ptrdiff_t offset(const Step& s) const { return s.dy * static_cast<std::ptrdiff_t>(stride_) + s.dx; }
  int difference(std::size_t p, std::size_t q) const {
    int sum = 0;
    for (const std::vector<std::uint8_t>& plane : planes_)
      sum += (plane[p] - plane[q]) * (plane[p] - plane[q]);
    return sum;
  }
  /// Of the pixels of a row of the box and their neighbours over a step.
  void differences(int y, const Step& s, std::uint32_t most, std::uint32_t* out) const {
    const std::uint8_t *own[3], *next[3];
    at(place(x0, y), own);
    at(place(x0, y) + static_cast<std::size_t>(offset(s)), next);
    cut_kernels().differences(own, next, static_cast<std::size_t>(x1 - x0), most, out);
  }
  /// Of all pairs of neighbours of which one is asked.
  CutKernels::Contrast contrast() const {
    CutKernels::Contrast sum;
    const int left = std::max(x0 - 1, 0), right = std::min(x1 + 1, width_);
    for (int y = std::max(y0 - 1, 0); y < std::min(y1 + 1, height_); ++y)
      for (const Step& s : kSteps) {
        if (y + s.dy >= std::min(y1 + 1, height_)) continue;
        const int from = left + (s.dx < 0 ? 1 : 0), count = right - left - (s.dx != 0 ? 1 : 0);
        const std::size_t p = place(from, y), q = p + static_cast<std::size_t>(offset(s));
        const std::uint8_t *own[3], *next[3];
        at(p, own);
        at(q, next);
        cut_kernels().add(own, next, is.data() + p, is.data() + q, static_cast<std::size_t>(count), sum);
      }
    return sum;
  }

 private:
  void at(std::size_t p, const std::uint8_t* out[3]) const {
    for (std::size_t k = 0; k < 3; ++k) out[k] = planes_[k].data() + p;
  }
  static constexpr std::size_t kVector = 16;  // bytes that the kernels may read beyond
  int width_, height_;
  std::size_t stride_ = 0, size_ = 0;
  std::array<std::vector<std::uint8_t>, 3> planes_;
};

}  // namespace

Image cut_frame(const Image& picture, const CutEvidence& evidence, double smooth) {
  const int w = picture.width, h = picture.height;
  FLOATSTAGE_CHECK(picture.channels == 3 && evidence.odds.size() == evidence.asked.size() &&
                       evidence.odds.size() == static_cast<std::size_t>(w) * static_cast<std::size_t>(h),
                   "evidence of the picture's size");
  Image out(w, h, 1);
  std::transform(evidence.asked.begin(), evidence.asked.end(), out.pixels.begin(),
                 [](std::uint8_t v) { return static_cast<std::uint8_t>(v == kSubject ? 255 : 0); });
  const Asked asked(evidence.asked, picture);
  if (asked.none()) return out;
  const CutKernels::Contrast contrast = asked.contrast();
  const float beta =
      contrast.sum > 0
          ? static_cast<float>(static_cast<double>(contrast.pairs) / (2 * static_cast<double>(contrast.sum)))
          : 0;
  const bool calm_everywhere = evidence.calm.empty();
  const Prices prices(beta, static_cast<float>(smooth), contrast.most);
  const int columns = asked.x1 - asked.x0;
  GridCut graph(columns, asked.y1 - asked.y0, asked.members());
  // Prices over the four steps from the pixels of a row, and from those of the row above; none is 0.
  std::array<std::vector<int>, 4> own, above;
  for (std::size_t k = 0; k < 4; ++k) {
    own[k].assign(static_cast<std::size_t>(columns) + 2, 0);
    above[k] = own[k];
  }
  std::vector<std::uint32_t> differences(static_cast<std::size_t>(columns) + 16);

  for (int y = asked.y0; y < asked.y1; ++y) {
    const std::size_t first = asked.place(asked.x0, y);
    const auto pixel = [&](int x, int row) {
      return static_cast<std::size_t>(row) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x);
    };
    const auto price = [&](int x, const Step& s) {
      const std::size_t p = asked.place(x, y), q = p + static_cast<std::size_t>(asked.offset(s));
      const int d = asked.difference(p, q);
      return calm_everywhere
                 ? prices.of(d, s.diagonal)
                 : prices.of(d, s.diagonal,
                             std::min(evidence.calm[pixel(x, y)], evidence.calm[pixel(x + s.dx, y + s.dy)]));
    };
    const std::uint8_t *is = asked.is.data() + first, *all = asked.all.data() + first;
    const float* odds = evidence.odds.data() + pixel(asked.x0, y);
    std::swap(own, above);
    std::array<int*, 4> to, from;  // column -1 and the one behind the last are there
    for (std::size_t k = 0; k < 4; ++k) {
      const Step& s = kSteps[k];
      const std::uint8_t* next = is + asked.offset(s);
      to[k] = own[k].data() + 1;
      from[k] = above[k].data() + 1;
      if (calm_everywhere) {
        asked.differences(y, s, prices.most(), differences.data());
        const std::uint32_t* difference = differences.data();
        const int* table = prices.whole_of(s.diagonal);
        for (int x = 0; x < columns; ++x) to[k][x] = (is[x] & next[x]) * table[difference[x]];
      } else {
        for (int x = 0; x < columns; ++x)
          to[k][x] = (is[x] & next[x]) != 0 ? whole(price(asked.x0 + x, s)) : 0;
      }
    }
    for (int x = 0; x < columns; ++x) {
      if (is[x] == 0) continue;
      float sum = odds[x];
      if (all[x] == 0)
        for (const Step& s : kAround) {
          const int nx = asked.x0 + x + s.dx, ny = y + s.dy;
          if (is[x + asked.offset(s)] != 0 || nx < 0 || nx >= w || ny < 0 || ny >= h) continue;
          const float more = price(asked.x0 + x, s);
          sum += evidence.asked[pixel(nx, ny)] == kSubject ? more : -more;
        }
      graph.set(
          static_cast<int>(first) + x, whole(sum),
          {to[0][x], to[0][x - 1], to[1][x], from[1][x], to[2][x], from[2][x - 1], to[3][x], from[3][x + 1]});
    }
  }
  graph.solve();
  for (int y = asked.y0; y < asked.y1; ++y) {
    const auto first = static_cast<int>(asked.place(asked.x0, y));
    const std::uint8_t* is = asked.is.data() + first;
    std::uint8_t* to = out.at(asked.x0, y);
    for (int x = 0; x < columns; ++x)
      if (is[x] != 0 && graph.on_source_side(first + x)) to[x] = 255;
  }
  return out;
}

}  // namespace floatstage::matting
