// Method:  the cheapest split of a frame into subject and background: a minimum cut
// Paper:   Y. Boykov, M.-P. Jolly, "Interactive graph cuts", 2001; J. Sun and others, "Background cut",
//          2006
// Differs: edges that the backdrop has itself cost nothing extra
// ADR:     0102, 0347

#include "matting/frame_cut.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/check.h"
#include "core/grid_cut.h"

namespace floatstage::matting {
namespace {

constexpr float kUnit = 1000;  // whole steps of the cut, which keep it exact and repeatable
constexpr std::uint8_t kSubject = 2;
constexpr float kFloor = 0.05f;  // of the smoothness: edges are never for nothing

// The neighbours that come later, row by row; opposite ones are next to each other in kAround.
struct Step {
  GridCut::Step step;
  int dx, dy;
  bool diagonal;
};
constexpr Step kSteps[] = {{GridCut::Right, 1, 0, false},
                           {GridCut::Down, 0, 1, false},
                           {GridCut::DownRight, 1, 1, true},
                           {GridCut::DownLeft, -1, 1, true}};
// All of them, in the order in which pairs are met row by row.
constexpr Step kAround[] = {{GridCut::DownRight, -1, -1, true}, {GridCut::Down, 0, -1, false},
                            {GridCut::DownLeft, 1, -1, true},   {GridCut::Right, -1, 0, false},
                            {GridCut::Right, 1, 0, false},      {GridCut::Down, 0, 1, false},
                            {GridCut::DownRight, 1, 1, true},   {GridCut::DownLeft, -1, 1, true}};

int difference(const std::uint8_t* a, const std::uint8_t* b) {
  const int r = a[0] - b[0], g = a[1] - b[1], u = a[2] - b[2];
  return r * r + g * g + u * u;
}

int whole(float v) { return v < 0 ? -whole(-v) : static_cast<int>(static_cast<double>(kUnit * v) + 0.5); }

// What parting two pixels costs, by how they differ.
class Prices {
 public:
  Prices(float beta, float smooth, int most) : beta_(beta), smooth_(smooth) {
    for (int d = 0; d <= most; ++d) {
      const float alike = std::exp(-beta * static_cast<float>(d));
      of_.push_back({price(alike, false), price(alike, true)});
      if (alike < 0.9f * kFloor) break;  // and so are all that differ more
    }
    for (const std::array<float, 2>& p : of_) whole_.push_back({whole(p[0]), whole(p[1])});
  }
  float of(int difference, bool diagonal) const { return of_[place(difference)][diagonal ? 1 : 0]; }
  int whole_of(int difference, bool diagonal) const { return whole_[place(difference)][diagonal ? 1 : 0]; }
  float of(int difference, bool diagonal, float calm) const {
    return price(std::exp(-beta_ * calm * static_cast<float>(difference)), diagonal);
  }

 private:
  std::size_t place(int difference) const {
    return std::min(static_cast<std::size_t>(difference), of_.size() - 1);
  }
  float price(float alike, bool diagonal) const {
    return smooth_ * std::max(alike, kFloor) / (diagonal ? 1.41421356f : 1);
  }
  float beta_, smooth_;
  std::vector<std::array<float, 2>> of_;
  std::vector<std::array<int, 2>> whole_;
};

// The pixels that are asked, in a box of their own.
struct Asked {
  int x0, y0, x1, y1;
  std::size_t stride;
  std::vector<std::uint8_t> is;   // 1 where asked; with a border around the box
  std::vector<std::uint8_t> all;  // 1 where all neighbours are as well

  Asked(const std::vector<std::uint8_t>& asked, int width, int height) : x0(width), y0(height), x1(0), y1(0) {
    const auto here = [&](int x, int y) {
      const std::uint8_t v =
          asked[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
      return v != 0 && v != kSubject;
    };
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        if (here(x, y)) x0 = std::min(x0, x), x1 = std::max(x1, x + 1), y0 = std::min(y0, y), y1 = y + 1;
    if (none()) return;
    stride = static_cast<std::size_t>(x1 - x0) + 2;
    is.resize(stride * (static_cast<std::size_t>(y1 - y0) + 2));
    all.resize(is.size());
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) is[place(x, y)] = here(x, y) ? 1 : 0;
    for (std::size_t i = stride + 1; i + stride + 1 < is.size(); ++i) {
      const std::uint8_t *up = &is[i - stride], *own = &is[i], *down = &is[i + stride];
      all[i] = up[-1] & up[0] & up[1] & own[-1] & own[1] & down[-1] & down[0] & down[1];
    }
  }
  bool none() const { return x1 <= x0; }
  std::size_t place(int x, int y) const {
    return static_cast<std::size_t>(y - y0 + 1) * stride + static_cast<std::size_t>(x - x0 + 1);
  }
  bool at(int x, int y) const { return x >= x0 && x < x1 && y >= y0 && y < y1 && is[place(x, y)] != 0; }
};

}  // namespace

Image cut_frame(const Image& picture, const CutEvidence& evidence, double smooth) {
  const int w = picture.width, h = picture.height;
  FLOATSTAGE_CHECK(picture.channels == 3 && evidence.odds.size() == evidence.asked.size() &&
                       evidence.odds.size() == static_cast<std::size_t>(w) * static_cast<std::size_t>(h),
                   "evidence of the picture's size");
  Image out(w, h, 1);
  for (std::size_t p = 0; p < out.pixels.size(); ++p)
    if (evidence.asked[p] == kSubject) out.pixels[p] = 255;
  const Asked asked(evidence.asked, w, h);
  if (asked.none()) return out;
  const auto pixel = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(w) + static_cast<std::size_t>(x);
  };
  const auto each_asked = [&](const auto& what) {
    for (int y = asked.y0; y < asked.y1; ++y)
      for (int x = asked.x0; x < asked.x1; ++x)
        if (asked.is[asked.place(x, y)]) what(x, y, asked.all[asked.place(x, y)] != 0);
  };
  const auto each_settled_neighbour = [&](int x, int y, const auto& what) {
    for (const Step& s : kAround)
      if (x + s.dx >= 0 && x + s.dx < w && y + s.dy >= 0 && y + s.dy < h && !asked.at(x + s.dx, y + s.dy))
        what(x + s.dx, y + s.dy, s.diagonal);
  };

  GridCut graph(asked.x1 - asked.x0, asked.y1 - asked.y0);
  const auto node = [&](int x, int y) { return graph.node(x - asked.x0, y - asked.y0); };
  std::int64_t contrast = 0, pairs = 0;
  int most = 0;
  const auto add = [&](int d) {
    contrast += d;
    most = std::max(most, d);
    ++pairs;
  };
  each_asked([&](int x, int y, bool all) {
    const std::uint8_t* own = picture.at(x, y);
    for (const Step& s : kSteps) {
      if (!all && !asked.at(x + s.dx, y + s.dy)) continue;
      const int d = difference(own, own + 3 * (s.dy * w + s.dx));
      graph.kept(node(x, y), s.step) = d;
      add(d);
    }
    if (!all)
      each_settled_neighbour(x, y, [&](int nx, int ny, bool) { add(difference(own, picture.at(nx, ny))); });
  });
  const float beta =
      contrast > 0 ? static_cast<float>(static_cast<double>(pairs) / (2 * static_cast<double>(contrast))) : 0;

  const Prices prices(beta, static_cast<float>(smooth), most);
  const auto calm = [&](std::size_t p, std::size_t q) {
    return std::min(evidence.calm[p], evidence.calm[q]);
  };
  const bool calm_everywhere = evidence.calm.empty();
  each_asked([&](int x, int y, bool all) {
    const int own = node(x, y);
    const std::size_t p = pixel(x, y);
    for (const Step& s : kSteps) {
      if (!all && !asked.at(x + s.dx, y + s.dy)) continue;
      const int d = graph.kept(own, s.step);
      graph.set_edge(own, s.step,
                     calm_everywhere ? prices.whole_of(d, s.diagonal)
                                     : whole(prices.of(d, s.diagonal, calm(p, pixel(x + s.dx, y + s.dy)))));
    }
    float odds = evidence.odds[p];
    if (!all)
      each_settled_neighbour(x, y, [&](int nx, int ny, bool diagonal) {
        const int d = difference(picture.at(x, y), picture.at(nx, ny));
        const std::size_t q = pixel(nx, ny);
        const float price = calm_everywhere ? prices.of(d, diagonal) : prices.of(d, diagonal, calm(p, q));
        odds += evidence.asked[q] == kSubject ? price : -price;
      });
    graph.set_terminal(own, whole(odds));
  });
  graph.solve();
  each_asked([&](int x, int y, bool) {
    if (graph.on_source_side(node(x, y))) *out.at(x, y) = 255;
  });
  return out;
}

}  // namespace floatstage::matting
