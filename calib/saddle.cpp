#include "calib/saddle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <opencv2/imgproc.hpp>

#include "calib/grey.h"

namespace floatstage::calib {
namespace {

constexpr int kRingSamples = 16;

struct Waves {
  std::array<float, kRingSamples> c1, s1, c2, s2;
  Waves() {
    for (std::size_t i = 0; i < kRingSamples; ++i) {
      const double a = 2 * std::numbers::pi * static_cast<double>(i) / kRingSamples;
      c1[i] = static_cast<float>(std::cos(a)), s1[i] = static_cast<float>(std::sin(a));
      c2[i] = static_cast<float>(std::cos(2 * a)), s2[i] = static_cast<float>(std::sin(2 * a));
    }
  }
};

const Waves kWaves;

// -det of the Hessian of a smoothed picture, where it is positive: sharp crossings of light and dark.
cv::Mat saddle_response(const cv::Mat& grey) {
  cv::Mat smooth;
  cv::GaussianBlur(grey, smooth, {5, 5}, 1.2);
  cv::Mat response(grey.size(), CV_32F, cv::Scalar(0));
  for (int y = 2; y < grey.rows - 2; ++y) {
    const std::uint8_t* a = smooth.ptr<std::uint8_t>(y - 2);
    const std::uint8_t* b = smooth.ptr<std::uint8_t>(y - 1);
    const std::uint8_t* c = smooth.ptr<std::uint8_t>(y);
    const std::uint8_t* d = smooth.ptr<std::uint8_t>(y + 1);
    const std::uint8_t* e = smooth.ptr<std::uint8_t>(y + 2);
    float* out = response.ptr<float>(y);
    for (int x = 2; x < grey.cols - 2; ++x) {
      // Second differences over two pixels; the mixed one over the diagonals of one pixel.
      const int xx = c[x - 2] - 2 * c[x] + c[x + 2], yy = a[x] - 2 * c[x] + e[x];
      const int xy = b[x - 1] - b[x + 1] - d[x - 1] + d[x + 1];
      const int det = xy * xy - xx * yy;
      out[x] = static_cast<float>(std::max(det, 0));
    }
  }
  return response;
}

}  // namespace

Ring ring_around(const cv::Mat& grey, cv::Point2f center, float radius) {
  std::array<float, kRingSamples> value;
  for (std::size_t i = 0; i < kRingSamples; ++i)
    value[i] = grey_at(grey, center.x + radius * kWaves.c1[i], center.y + radius * kWaves.s1[i]);
  Ring ring;
  for (std::size_t i = 0; i < kRingSamples; ++i) {
    ring.second[0] += value[i] * kWaves.c2[i] / (kRingSamples / 2);
    ring.second[1] += value[i] * kWaves.s2[i] / (kRingSamples / 2);
    if (i < kRingSamples / 2)
      ring.asymmetry += std::abs(value[i] - value[i + kRingSamples / 2]) / (kRingSamples / 2);
  }
  return ring;
}

std::optional<cv::Point2f> refine_saddle(const cv::Mat& grey, cv::Point2f start, float radius) {
  constexpr int kMostSteps = 30;
  constexpr float kConverged = 0.002f;  // px
  const int reach = static_cast<int>(std::ceil(radius)), across = 2 * reach + 3;
  const float rim = static_cast<float>(reach) + 2;
  auto inside = [&](cv::Point2f p) {
    return p.x >= rim && p.y >= rim && p.x <= static_cast<float>(grey.cols) - 1 - rim &&
           p.y <= static_cast<float>(grey.rows) - 1 - rim;
  };
  std::vector<float> patch(static_cast<std::size_t>(across) * across);
  cv::Point2f at = start;
  float moved = radius;
  for (int step = 0; step < kMostSteps && moved > kConverged; ++step) {
    if (!inside(at)) return std::nullopt;
    for (int y = 0; y < across; ++y)
      for (int x = 0; x < across; ++x)
        patch[static_cast<std::size_t>(y) * across + x] =
            grey_at(grey, at.x + static_cast<float>(x - reach - 1), at.y + static_cast<float>(y - reach - 1));
    double xx = 0, xy = 0, yy = 0, bx = 0, by = 0;
    for (int y = 0; y <= reach; ++y) {
      for (int x = y == 0 ? 1 : -reach; x <= reach; ++x) {
        const double fall = 1 - static_cast<double>(x * x + y * y) / (radius * radius);
        if (fall <= 0) continue;
        const float* p = &patch[static_cast<std::size_t>(reach + 1 + y) * across + (reach + 1 + x)];
        const float* q = &patch[static_cast<std::size_t>(reach + 1 - y) * across + (reach + 1 - x)];
        const double gx = 0.5 * ((p[1] - p[-1]) - (q[1] - q[-1])),
                     gy = 0.5 * ((p[across] - p[-across]) - (q[across] - q[-across]));
        const double apart = *p - *q;
        xx += fall * gx * gx, xy += fall * gx * gy, yy += fall * gy * gy;
        bx -= fall * gx * apart, by -= fall * gy * apart;
      }
    }
    const double det = xx * yy - xy * xy;
    if (!(det > 1e-3 * (xx + yy) * (xx + yy))) return std::nullopt;  // edges of one direction only
    const cv::Point2f by_how_much(static_cast<float>((yy * bx - xy * by) / det),
                                  static_cast<float>((xx * by - xy * bx) / det));
    at += by_how_much;
    moved = std::hypot(by_how_much.x, by_how_much.y);
    if (!(std::hypot(at.x - start.x, at.y - start.y) <= radius)) return std::nullopt;
  }
  if (moved > 0.05f || !inside(at) || !ring_around(grey, at, std::max(2.0f, 0.7f * radius)).is_saddle())
    return std::nullopt;
  return at;
}

std::vector<Saddle> find_saddles(const cv::Mat& grey, std::size_t most) {
  constexpr int kApart = 4;        // px between two crossings
  constexpr float kWeakest = 150;  // of the response: a contrast of about a dozen grey levels
  constexpr float kRing = 4.5f;    // px
  std::vector<Saddle> found;
  if (grey.cols < 16 || grey.rows < 16) return found;
  const cv::Mat response = saddle_response(grey);
  cv::Mat highest;
  cv::dilate(response, highest, cv::Mat::ones(2 * kApart + 1, 2 * kApart + 1, CV_8U));
  for (int y = 5; y < grey.rows - 5; ++y) {
    const float* r = response.ptr<float>(y);
    const float* h = highest.ptr<float>(y);
    for (int x = 5; x < grey.cols - 5; ++x)
      if (r[x] >= kWeakest && r[x] == h[x])
        found.push_back({{static_cast<float>(x), static_cast<float>(y)}, r[x], {}});
  }
  std::sort(found.begin(), found.end(), [](const Saddle& a, const Saddle& b) {
    return std::make_tuple(-a.strength, a.at.y, a.at.x) < std::make_tuple(-b.strength, b.at.y, b.at.x);
  });
  if (found.size() > 4 * most) found.resize(4 * most);
  std::erase_if(found, [&](Saddle& s) {
    const Ring ring = ring_around(grey, s.at, kRing);
    s.second = ring.second;
    return !ring.is_saddle();
  });
  if (found.size() > most) found.resize(most);
  return found;
}

}  // namespace floatstage::calib
