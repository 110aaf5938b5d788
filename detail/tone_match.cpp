// Mismatch removal: M. Eisemann, "Error-Concealed Image-Based Rendering", section 4.3.1. Differs: tones are
// matched before, because an exposure of half a stop alone is more than the threshold (ADR 0217).

#include "detail/tone_match.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "core/check.h"

namespace floatstage::detail {
namespace {

constexpr float kMostDifference = 0.35F;
constexpr double kBlur = 2;
constexpr int kWindow = 5, kLongest = 512;
constexpr std::size_t kBins = 4096, kFewest = 1000;

cv::Mat matrix_of(const LightPicture& p) {
  return {p.height, p.width, CV_32FC4, const_cast<Light*>(p.pixels.data())};
}

LightPicture encoded_picture(LightPicture p) {
  for (Light& light : p.pixels)
    for (std::size_t k = 0; k < 3; ++k) light[k] = encoded(std::clamp(light[k], 0.0F, 1.0F));
  return p;
}

// Shares of pixels up to each value.
std::vector<double> distribution(const LightPicture& p, const std::vector<std::uint8_t>& use,
                                 std::size_t channel) {
  std::vector<double> sums(kBins, 0);
  double count = 0;
  for (std::size_t i = 0; i < use.size(); ++i)
    if (use[i] != 0) {
      ++count;
      ++sums[std::min(kBins - 1, static_cast<std::size_t>(p.pixels[i][channel] * kBins))];
    }
  double sum = 0;
  for (double& s : sums) s = (sum += s) / count;
  return sums;
}

// The value that a share of the pixels lies below.
double value_at(const std::vector<double>& shares, double share) {
  const auto at = std::lower_bound(shares.begin(), shares.end(), share);
  const auto bin =
      static_cast<std::size_t>(std::min(at - shares.begin(), static_cast<std::ptrdiff_t>(kBins) - 1));
  const double below = bin > 0 ? shares[bin - 1] : 0, here = shares[bin];
  const double part = here > below ? (share - below) / (here - below) : 0.5;
  return (static_cast<double>(bin) + std::clamp(part, 0.0, 1.0)) / kBins;
}

// Of two blurred pictures, the first shifted.
std::vector<std::uint8_t> alike(const LightPicture& a, const LightPicture& b, int dx, int dy) {
  LightPicture squares(a.width, a.height), sums(a.width, a.height);
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      const Light& from = a.at(std::clamp(x + dx, 0, a.width - 1), std::clamp(y + dy, 0, a.height - 1));
      const Light& to = b.at(x, y);
      for (std::size_t k = 0; k < 3; ++k) squares.at(x, y)[k] = (from[k] - to[k]) * (from[k] - to[k]);
    }
  cv::Mat to = matrix_of(sums);
  cv::boxFilter(matrix_of(squares), to, -1, {kWindow, kWindow}, {-1, -1}, false, cv::BORDER_REPLICATE);
  std::vector<std::uint8_t> same(sums.pixels.size());
  for (std::size_t i = 0; i < same.size(); ++i) {
    const Light& s = sums.pixels[i];
    same[i] = std::max({s[0], s[1], s[2]}) < kMostDifference ? 1 : 0;
  }
  return same;
}

}  // namespace

Light ToneCurves::apply(const Light& light) const {
  Light out = light;
  for (std::size_t k = 0; k < 3; ++k) {
    const float at = encoded(std::clamp(light[k], 0.0F, 1.0F)) * (kKnots - 1);
    const auto i = std::min(static_cast<std::size_t>(at), kKnots - 2);
    const float v = to[k][i] + (at - static_cast<float>(i)) * (to[k][i + 1] - to[k][i]);
    out[k] = v <= 0.04045F ? v / 12.92F : std::pow((v + 0.055F) / 1.055F, 2.4F);
  }
  return out;
}

ToneCurves match_tones(const LightPicture& from, const LightPicture& to,
                       const std::vector<std::uint8_t>& use) {
  FLOATSTAGE_CHECK(from.pixels.size() == to.pixels.size() && use.size() == to.pixels.size(), "one size");
  ToneCurves curves;
  const bool enough = static_cast<std::size_t>(
                          std::count_if(use.begin(), use.end(), [](auto u) { return u != 0; })) >= kFewest;
  const LightPicture a = encoded_picture(from), b = encoded_picture(to);
  for (std::size_t k = 0; k < 3; ++k) {
    std::vector<std::pair<double, double>> knots = {{0, 0}};
    if (enough) {
      const std::vector<double> of_a = distribution(a, use, k), of_b = distribution(b, use, k);
      for (double share = 0.005; share < 1; share += 0.01) {
        const double x = value_at(of_a, share), y = value_at(of_b, share);
        if (x > knots.back().first + 1e-3) knots.emplace_back(x, std::max(y, knots.back().second));
      }
    }
    // Beyond what was seen, as the outermost was: darker in proportion, brighter towards white.
    if (knots.back().first < 1) knots.emplace_back(1, std::max(1.0, knots.back().second));
    std::size_t at = 0;
    for (std::size_t i = 0; i < ToneCurves::kKnots; ++i) {
      const double x = static_cast<double>(i) / (ToneCurves::kKnots - 1);
      while (at + 2 < knots.size() && knots[at + 1].first < x) ++at;
      const auto [x0, y0] = knots[at];
      const auto [x1, y1] = knots[at + 1];
      curves.to[k][i] = static_cast<float>(y0 + (y1 - y0) * std::clamp((x - x0) / (x1 - x0), 0.0, 1.0));
    }
  }
  return curves;
}

LightPicture blurred(const LightPicture& picture, double sigma) {
  if (sigma <= 0) return picture;
  LightPicture out(picture.width, picture.height);
  cv::Mat to = matrix_of(out);
  cv::GaussianBlur(matrix_of(picture), to, {}, sigma, sigma, cv::BORDER_REPLICATE);
  return out;
}

std::vector<std::uint8_t> matching_pixels(const LightPicture& child, const LightPicture& parent) {
  FLOATSTAGE_CHECK(child.pixels.size() == parent.pixels.size(), "one size");
  return alike(blurred(encoded_picture(child), kBlur), blurred(encoded_picture(parent), kBlur), 0, 0);
}

std::vector<std::uint8_t> matching_nearby(const LightPicture& child, const LightPicture& parent, int reach) {
  FLOATSTAGE_CHECK(child.pixels.size() == parent.pixels.size(), "one size");
  const int factor = (std::max(child.width, child.height) + kLongest - 1) / kLongest;
  const auto prepared = [&](const LightPicture& p) {
    cv::Mat small;
    const LightPicture soft = blurred(encoded_picture(p), kBlur);
    cv::resize(matrix_of(soft), small, {std::max(1, p.width / factor), std::max(1, p.height / factor)}, 0, 0,
               cv::INTER_AREA);
    LightPicture out(small.cols, small.rows);
    small.copyTo(cv::Mat(matrix_of(out)));
    return out;
  };
  const LightPicture a = prepared(child), b = prepared(parent);
  std::vector<std::uint8_t> any(a.pixels.size(), 0);
  const int half = std::max(1, (reach / factor + 1) / 2);
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      const std::vector<std::uint8_t> same = alike(a, b, dx * half, dy * half);
      for (std::size_t i = 0; i < any.size(); ++i) any[i] |= same[i];
    }
  std::vector<std::uint8_t> out(child.pixels.size());
  for (int y = 0; y < child.height; ++y)
    for (int x = 0; x < child.width; ++x)
      out[child.index(x, y)] =
          any[a.index(std::min(x / factor, a.width - 1), std::min(y / factor, a.height - 1))];
  return out;
}

}  // namespace floatstage::detail
