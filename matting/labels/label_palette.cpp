#include "matting/labels/label_palette.h"

#include <algorithm>
#include <cmath>

namespace floatstage::matting {
namespace {

constexpr int kOpaque = 192;
constexpr float kBlind =
    0.1F;  // share of colours drawn blindly: one that a label never had is not impossible

}  // namespace

LabelPalette::LabelPalette(int labels)
    : bins_(static_cast<std::size_t>(labels), std::vector<float>(kBins, 0.F)),
      total_(static_cast<std::size_t>(labels), 0) {}

std::size_t LabelPalette::bin(const std::uint8_t* rgb) {
  const auto step = [](int v) { return static_cast<std::size_t>(v * kSide / 256); };
  return (step(rgb[0]) * kSide + step(rgb[1])) * kSide + step(rgb[2]);
}

void LabelPalette::fade(double keep) {
  for (std::size_t l = 0; l < bins_.size(); ++l) {
    for (float& b : bins_[l]) b *= static_cast<float>(keep);
    total_[l] *= keep;
  }
}

void LabelPalette::learn(const Image& picture, const Image& matte, const Image& labels) {
  for (std::size_t p = 0; p < labels.pixels.size(); ++p) {
    const std::size_t l = labels.pixels[p];
    if (l == 0 || l > bins_.size() || matte.pixels[p] < kOpaque) continue;
    bins_[l - 1][bin(picture.pixels.data() + 3 * p)] += 1;
    total_[l - 1] += 1;
  }
}

void LabelPalette::take_unknown(const LabelPalette& other) {
  for (std::size_t l = 0; l < bins_.size(); ++l)
    if (total_[l] == 0) bins_[l] = other.bins_[l], total_[l] = other.total_[l];
}

float LabelPalette::share(std::size_t label, std::size_t bin) const {
  const double seen = total_[label] > 0 ? bins_[label][bin] / total_[label] : 0;
  return static_cast<float>((1 - kBlind) * seen + kBlind / kBins);
}

void LabelPalette::odds(const std::uint8_t* rgb, std::span<float> out) const {
  std::fill(out.begin(), out.end(), 0.F);
  if (std::any_of(total_.begin(), total_.end(), [](double t) { return t == 0; })) return;
  const std::size_t b = bin(rgb);
  float mean = 0;
  for (std::size_t l = 0; l < out.size(); ++l) mean += out[l] = share(l, b);
  mean /= static_cast<float>(out.size());
  for (float& o : out) o = std::clamp(std::log(o / mean), -kMost, kMost);
}

double LabelPalette::alike(int label, int other) const {
  const auto a = static_cast<std::size_t>(label - 1), b = static_cast<std::size_t>(other - 1);
  if (total_[a] == 0 || total_[b] == 0) return 0;
  double sum = 0;
  for (std::size_t i = 0; i < kBins; ++i)
    sum += std::sqrt(bins_[a][i] / total_[a] * (bins_[b][i] / total_[b]));
  return sum;
}

}  // namespace floatstage::matting
