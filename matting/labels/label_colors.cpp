// Method:  colour models of labels in overlapping windows
// Paper:   X. Bai, J. Wang, D. Simons, G. Sapiro, "Video SnapCut: Robust Video Object Cutout Using Localized
//          Classifiers", SIGGRAPH 2009, section 3.1
// Differs: histograms on a regular grid instead of mixtures along the contour; any number of labels
// ADR:     0274

#include "matting/labels/label_colors.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace floatstage::matting {
namespace {

constexpr float kBlind = 0.02f;  // share of colours drawn blindly
constexpr float kFew = 40;       // pixels below which a window's histogram counts for little

// Shadows are where clothes and surroundings are alike: finer steps there.
std::array<std::uint8_t, 256> steps(int side) {
  std::array<std::uint8_t, 256> out;
  for (int v = 0; v < 256; ++v)
    out[static_cast<std::size_t>(v)] =
        static_cast<std::uint8_t>(std::min(side - 1, static_cast<int>(side * std::pow(v / 256.0, 0.7))));
  return out;
}

// One pass of a 1-2-1 filter along each axis.
void smooth(float* bins, int side) {
  for (int axis = 0, step = 1; axis < 3; ++axis, step *= side) {
    for (int start = 0; start < side * side * side; ++start) {
      if (start / step % side != 0) continue;
      float before = bins[start];
      for (int i = 0; i < side; ++i) {
        float& here = bins[start + i * step];
        const float after = bins[start + std::min(i + 1, side - 1) * step], kept = here;
        here = (before + 2 * here + after) / 4;
        before = kept;
      }
    }
  }
}

}  // namespace

std::size_t LabelColors::bin(const std::uint8_t* rgb) {
  static const std::array<std::uint8_t, 256> kSteps = steps(kSide);
  return (static_cast<std::size_t>(kSteps[rgb[0]]) * kSide + kSteps[rgb[1]]) * kSide + kSteps[rgb[2]];
}

LabelColors::LabelColors(int width, int height, int count, int reach, const Image& wanted)
    : width_(width), height_(height), count_(count), reach_(reach), step_(std::max(1, reach * 2 / 3)) {
  columns_ = width / step_ + 2;
  rows_ = height / step_ + 2;
  at_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_), -1);
  std::vector<bool> needed(at_.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (*wanted.at(x, y))
        for (const int dy : {0, 1})
          for (const int dx : {0, 1})
            needed[static_cast<std::size_t>((y / step_ + dy) * columns_ + x / step_ + dx)] = true;
  for (std::size_t i = 0; i < at_.size(); ++i) {
    if (!needed[i]) continue;
    at_[i] = static_cast<int>(windows_.size());
    windows_.push_back({static_cast<int>(i) % columns_ * step_, static_cast<int>(i) / columns_ * step_,
                        std::vector<float>(static_cast<std::size_t>(count) * kBins),
                        std::vector<float>(static_cast<std::size_t>(count))});
  }
}

void LabelColors::learn(const Image& picture, const Image& labels) {
  for (Window& w : windows_) {
    for (int y = std::max(0, w.y - reach_); y < std::min(height_, w.y + reach_); ++y) {
      const std::uint8_t* rgb = picture.at(0, y);
      const std::uint8_t* label = labels.at(0, y);
      for (int x = std::max(0, w.x - reach_); x < std::min(width_, w.x + reach_); ++x) {
        if (label[x] >= count_) continue;
        w.bins[label[x] * std::size_t{kBins} + bin(rgb + 3 * x)] += 1;
        w.total[label[x]] += 1;
      }
    }
  }
  finish();
}

void LabelColors::finish() {
  for (Window& w : windows_)
    for (int l = 0; l < count_; ++l) {
      float* bins = w.bins.data() + static_cast<std::size_t>(l) * kBins;
      const float total = w.total[static_cast<std::size_t>(l)];
      if (total > 0) smooth(bins, kSide);
      const float known = total / (total + kFew), scale = total > 0 ? known * kBins / total : 0;
      for (int i = 0; i < kBins; ++i) bins[i] = std::log(bins[i] * scale * (1 - kBlind) + kBlind);
    }
}

void LabelColors::odds(int x, int y, const std::uint8_t* rgb, std::span<float> out) const {
  std::fill(out.begin(), out.end(), 0.0f);
  const int column = x / step_, row = y / step_;
  const float fx = static_cast<float>(x - column * step_) / static_cast<float>(step_),
              fy = static_cast<float>(y - row * step_) / static_cast<float>(step_);
  const std::size_t b = bin(rgb);
  for (const int dy : {0, 1})
    for (const int dx : {0, 1}) {
      const int i = at_[static_cast<std::size_t>((row + dy) * columns_ + column + dx)];
      if (i < 0) continue;
      const Window& w = windows_[static_cast<std::size_t>(i)];
      const float share = (dx ? fx : 1 - fx) * (dy ? fy : 1 - fy);
      for (int l = 0; l < count_; ++l)
        out[static_cast<std::size_t>(l)] += share * w.bins[static_cast<std::size_t>(l) * kBins + b];
    }
}

}  // namespace floatstage::matting
