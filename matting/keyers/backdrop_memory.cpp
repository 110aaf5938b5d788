#include "matting/keyers/backdrop_memory.h"

#include <algorithm>
#include <cmath>

#include "matting/keyers/plate.h"

namespace floatstage::matting {
namespace {

constexpr float kSame = 14;     // 8-bit steps a channel within which a place shows what it showed
constexpr float kNoise = 3.5f;  // 8-bit steps: what codecs leave of a still place
constexpr float kMostNoise = 10;
constexpr float kLight = 22;  // 8-bit steps by which a place may become darker or brighter, as a whole
constexpr float kDarkest = 0.6f, kBrightest = 1.2f;
constexpr float kEqual = 3;      // log-odds of a place that looks as it always has …
constexpr float kDifferent = 6;  // … and at most of one that does not
constexpr float kHalfTrust = 2;  // observations
constexpr float kEdge = 8;       // 8-bit steps of the backdrop's own edges
constexpr float kShows = 10;     // 8-bit steps within which a pixel shows the backdrop, edges included

float trust_of(float seen) { return seen / (seen + kHalfTrust); }

}  // namespace

BackdropMemory::BackdropMemory(int width, int height)
    : width_(width),
      height_(height),
      color_(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)),
      noise_(color_.size() / 3, kNoise),
      trust_(noise_.size()),
      seen_(noise_.size()) {}

void BackdropMemory::observe(const Image& picture, const Image& near) {
  for (std::size_t p = 0; p < seen_.size(); ++p) {
    if (near.pixels[p]) continue;
    const std::uint8_t* rgb = picture.pixels.data() + 3 * p;
    float* mean = color_.data() + 3 * p;
    bool same = seen_[p] > 0;
    for (int c = 0; c < 3; ++c) same = same && std::abs(rgb[c] - mean[c]) <= kSame;
    if (same) {
      if (seen_[p] < 30) ++seen_[p];
      for (int c = 0; c < 3; ++c) mean[c] += (rgb[c] - mean[c]) / seen_[p];
    } else if (seen_[p] <= 1) {
      seen_[p] = 1;
      for (int c = 0; c < 3; ++c) mean[c] = rgb[c];
    } else {
      --seen_[p];
    }
    trust_[p] = trust_of(seen_[p]);
  }
}

Result<void> BackdropMemory::learn(const std::vector<Image>& pictures, const std::vector<Image>& near) {
  Result<Plate> plate = learn_plate(pictures, {}, near);
  if (!plate) return forward(plate);
  for (std::size_t p = 0; p < trust_.size(); ++p) {
    float seen = 0;
    for (const Image& n : near) seen += n.pixels[p] == 0;
    for (std::size_t c = 3 * p; c < 3 * p + 3; ++c) color_[c] = plate->color.pixels[c];
    noise_[p] = std::clamp(1.5f * plate->noise.pixels[p] / 16, kNoise, kMostNoise);
    trust_[p] = trust_of(seen) * plate->confidence.pixels[p] / 255;
    seen_[p] = static_cast<std::uint8_t>(std::min(seen, 30.0f));
  }
  return {};
}

float BackdropMemory::odds(std::size_t pixel, const std::uint8_t* rgb) const {
  if (trust_[pixel] <= 0) return 0;
  const float* b = color_.data() + 3 * pixel;
  const float square = b[0] * b[0] + b[1] * b[1] + b[2] * b[2] + 1;
  const float bright =
      std::clamp((rgb[0] * b[0] + rgb[1] * b[1] + rgb[2] * b[2]) / square, kDarkest, kBrightest);
  float d = 0;
  for (int c = 0; c < 3; ++c) d += (rgb[c] - bright * b[c]) * (rgb[c] - bright * b[c]);
  const float light = (1 - bright) * (1 - bright) * square / (kLight * kLight);
  const float r = d / (noise_[pixel] * noise_[pixel]) / 2 + light;
  return trust_[pixel] * std::clamp(r / 2 - kEqual, -kEqual, kDifferent);
}

std::vector<float> BackdropMemory::calm(const Image& picture) const {
  std::vector<float> out(trust_.size(), 1);
  for (int y = 0; y < height_; ++y)
    for (int x = 0; x < width_; ++x) {
      const std::size_t p =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
      if (trust_[p] <= 0) continue;
      float edge = 0, away = 0;
      for (const std::size_t q : {x + 1 < width_ ? p + 1 : p, x > 0 ? p - 1 : p,
                                  y + 1 < height_ ? p + static_cast<std::size_t>(width_) : p,
                                  y > 0 ? p - static_cast<std::size_t>(width_) : p}) {
        float step = 0;
        for (std::size_t c = 0; c < 3; ++c) step += std::abs(color_[3 * p + c] - color_[3 * q + c]) / 3;
        if (trust_[q] > 0) edge = std::max(edge, step);
      }
      for (std::size_t c = 0; c < 3; ++c) away += std::abs(color_[3 * p + c] - picture.pixels[3 * p + c]) / 3;
      out[p] = 1 / (1 + trust_[p] * edge * edge / (kEdge * kEdge) *
                            std::exp(-away * away / (2 * kShows * kShows)));
    }
  return out;
}

}  // namespace floatstage::matting
