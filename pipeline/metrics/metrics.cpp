#include "pipeline/metrics/metrics.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <opencv2/imgproc.hpp>

#include "core/check.h"
#include "pipeline/metrics/picture_pair.h"

namespace floatstage::pipeline {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kBlock = 16, kReach = 3;  // px, of psnr_shift()

bool inside(const Image& mask, int x, int y) { return *mask.at(x, y) >= 128; }

// Squared error summed over the channels of one pixel pair.
std::int64_t squared_error(const std::uint8_t* a, const std::uint8_t* b, int channels) {
  std::int64_t sum = 0;
  for (int c = 0; c < channels; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

double decibels(double mean_squared_error) {
  if (mean_squared_error <= 0) return std::numeric_limits<double>::infinity();
  return 10 * std::log10(255.0 * 255.0 / mean_squared_error);
}

struct BlockError {
  std::int64_t squares = 0, pairs = 0;
};

// The block of the truth at (x0, y0) against the rendered picture (dx, dy) away, over pairs that are both in
// the mask.
BlockError block_error(const Image& rendered, const Image& truth, const Image& mask, int x0, int y0, int dx,
                       int dy) {
  BlockError error;
  for (int y = std::max(y0, -dy); y < std::min({y0 + kBlock, truth.height, truth.height - dy}); ++y) {
    for (int x = std::max(x0, -dx); x < std::min({x0 + kBlock, truth.width, truth.width - dx}); ++x) {
      if (!inside(mask, x, y) || !inside(mask, x + dx, y + dy)) continue;
      error.squares += squared_error(rendered.at(x + dx, y + dy), truth.at(x, y), truth.channels);
      ++error.pairs;
    }
  }
  return error;
}

cv::Mat disc(int px) {
  cv::Mat d(2 * px + 1, 2 * px + 1, CV_8U);
  for (int y = -px; y <= px; ++y)
    for (int x = -px; x <= px; ++x) d.at<std::uint8_t>(y + px, x + px) = x * x + y * y <= px * px;
  return d;
}

}  // namespace

double psnr(const Image& rendered, const Image& truth, const Image& mask) {
  check_pair(rendered, truth, mask);
  std::int64_t squares = 0, pixels = 0;
  for (int y = 0; y < truth.height; ++y) {
    for (int x = 0; x < truth.width; ++x) {
      if (!inside(mask, x, y)) continue;
      squares += squared_error(rendered.at(x, y), truth.at(x, y), truth.channels);
      ++pixels;
    }
  }
  if (pixels == 0) return kNaN;
  return decibels(static_cast<double>(squares) / static_cast<double>(pixels * truth.channels));
}

double psnr_shift(const Image& rendered, const Image& truth, const Image& mask) {
  check_pair(rendered, truth, mask);
  const cv::Rect box = box_of(mask);
  if (box.empty()) return kNaN;
  double squares = 0, pixels = 0;
  for (int y0 = box.y; y0 < box.y + box.height; y0 += kBlock) {
    for (int x0 = box.x; x0 < box.x + box.width; x0 += kBlock) {
      const BlockError still = block_error(rendered, truth, mask, x0, y0, 0, 0);
      if (still.pairs == 0) continue;
      double best = static_cast<double>(still.squares) / static_cast<double>(still.pairs);
      for (int dy = -kReach; dy <= kReach; ++dy) {
        for (int dx = -kReach; dx <= kReach; ++dx) {
          const BlockError shifted = block_error(rendered, truth, mask, x0, y0, dx, dy);
          if (2 * shifted.pairs < still.pairs || shifted.pairs == 0) continue;
          best = std::min(best, static_cast<double>(shifted.squares) / static_cast<double>(shifted.pairs));
        }
      }
      squares += best * static_cast<double>(still.pairs);
      pixels += static_cast<double>(still.pairs);
    }
  }
  return decibels(squares / (pixels * truth.channels));
}

double sharpness(const Image& rendered, const Image& truth, const Image& mask) {
  check_pair(rendered, truth, mask);
  const cv::Rect box = box_of(mask);
  if (box.empty()) return kNaN;
  const cv::Mat a = luma_of(rendered, box), b = luma_of(truth, box), w = weights_of(mask, box);
  auto energy = [](const cv::Mat& m, int x, int y) {
    const double dx = m.at<double>(y, x + 1) - m.at<double>(y, x - 1),
                 dy = m.at<double>(y + 1, x) - m.at<double>(y - 1, x);
    return dx * dx + dy * dy;
  };
  double of_a = 0, of_b = 0;
  for (int y = 1; y + 1 < box.height; ++y) {
    for (int x = 1; x + 1 < box.width; ++x) {
      const bool all = w.at<double>(y, x) * w.at<double>(y, x - 1) * w.at<double>(y, x + 1) *
                           w.at<double>(y - 1, x) * w.at<double>(y + 1, x) >
                       0;
      if (!all) continue;
      of_a += energy(a, x, y);
      of_b += energy(b, x, y);
    }
  }
  return of_b > 0 ? of_a / of_b : kNaN;
}

double psnr_color(const Image& rendered, const Image& truth, const Image& mask) {
  check_pair(rendered, truth, mask);
  double squares = 0, pixels = 0;
  for (int c = 0; c < truth.channels; ++c) {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
    for (std::size_t i = 0; i < mask.pixels.size(); ++i) {
      if (mask.pixels[i] < 128) continue;
      const std::size_t at = i * static_cast<std::size_t>(truth.channels) + static_cast<std::size_t>(c);
      const double a = rendered.pixels[at], b = truth.pixels[at];
      n += 1, x += a, y += b, xx += a * a, xy += a * b, yy += b * b;
    }
    if (n == 0) return kNaN;
    // Centred moments; what a line through the colours leaves of the truth's.
    const double of_a = xx - x * x / n, of_b = yy - y * y / n, shared = xy - x * y / n;
    squares += std::max(0.0, of_a > 0 ? of_b - shared * shared / of_a : of_b);
    pixels += n;
  }
  return decibels(squares / pixels);
}

Scores score(const Image& rendered, const Image& truth, const Image& mask, const Image& silhouette) {
  return {.psnr = psnr(rendered, truth, mask),
          .ssim = ssim(rendered, truth, mask),
          .cw_ssim = cw_ssim(rendered, truth, mask),
          .psnr_shift = psnr_shift(rendered, truth, mask),
          .sharpness = sharpness(rendered, truth, mask),
          .psnr_full = psnr(rendered, truth, silhouette),
          .psnr_edge = kNaN,
          .psnr_color = kNaN,
          .ghosting = kNaN};
}

Image outline_band(const Image& silhouette, int width) {
  Image outside = silhouette;
  for (std::uint8_t& value : outside.pixels) value = value >= 128 ? 0 : 255;
  const Image inner = erode_mask(silhouette, width / 2), outer = erode_mask(outside, width / 2);
  Image band(silhouette.width, silhouette.height, 1);
  for (std::size_t i = 0; i < band.pixels.size(); ++i)
    band.pixels[i] = inner.pixels[i] == 0 && outer.pixels[i] == 0 ? 255 : 0;
  return band;
}

Image erode_mask(const Image& mask, int px) {
  FLOATSTAGE_CHECK(mask.channels == 1 && px >= 0, "erode_mask() takes one channel and a radius");
  Image out = mask;
  for (std::uint8_t& value : out.pixels) value = value >= 128 ? 255 : 0;
  if (px == 0 || out.empty()) return out;
  const cv::Mat view(out.height, out.width, CV_8U, out.pixels.data());
  cv::Mat eroded;
  cv::erode(view, eroded, disc(px));
  std::copy(eroded.data, eroded.data + out.pixels.size(), out.pixels.begin());
  return out;
}

}  // namespace floatstage::pipeline
