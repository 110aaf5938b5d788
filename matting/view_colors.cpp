#include "matting/view_colors.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/parallel.h"
#include "matting/tone.h"

namespace floatstage::matting {
namespace {

constexpr int kSide = 64, kBins = kSide * kSide * kSide;
constexpr float kUnseen = 0.01f;  // share of the backdrop's colours that have not been seen of it
constexpr float kOwn = 0.5f;      // of a camera's model of the subject that is its own
constexpr float kAlike = 0.3f;    // of what is seen of a backdrop stands for neighbouring colours, too

using Histogram = std::vector<float>;

std::size_t bin(const std::uint8_t* rgb) {
  const std::array<std::uint8_t, 256>& t = tone();
  constexpr int kWidth = 256 / kSide;
  return (static_cast<std::size_t>(t[rgb[0]] / kWidth) * kSide + t[rgb[1]] / kWidth) * kSide +
         t[rgb[2]] / kWidth;
}

// A 1-2-1 filter along each axis.
void smooth(Histogram& bins) {
  std::vector<float> line(kSide);
  for (const int step : {1, kSide, kSide * kSide})
    for (int start = 0; start < kBins; ++start) {
      if (start / step % kSide != 0) continue;
      bool any = false;
      for (int i = 0; i < kSide; ++i) {
        line[static_cast<std::size_t>(i)] = bins[static_cast<std::size_t>(start + i * step)];
        any = any || line[static_cast<std::size_t>(i)] > 0;
      }
      if (!any) continue;
      for (int i = 0; i < kSide; ++i)
        bins[static_cast<std::size_t>(start + i * step)] =
            (line[static_cast<std::size_t>(std::max(i - 1, 0))] + 2 * line[static_cast<std::size_t>(i)] +
             line[static_cast<std::size_t>(std::min(i + 1, kSide - 1))]) /
            4;
    }
}

double total(const Histogram& h) {
  double sum = 0;
  for (const float v : h) sum += v;
  return sum;
}

}  // namespace

ViewColors::ViewColors(std::span<const Image> pictures, std::span<const std::vector<float>> shares,
                       double novelty, int threads)
    : cameras_(pictures.size()) {
  FLOATSTAGE_CHECK(pictures.size() == shares.size(), "shares of every camera");
  std::vector<Histogram> subject(pictures.size()), backdrop(pictures.size());
  parallel_for(pictures.size(), threads, [&](std::size_t i) {
    subject[i].assign(kBins, 0);
    backdrop[i].assign(kBins, 0);
    for (std::size_t p = 0; p < shares[i].size(); ++p) {
      if (shares[i][p] < 0) continue;
      const std::size_t b = bin(pictures[i].pixels.data() + 3 * p);
      subject[i][b] += shares[i][p];
      backdrop[i][b] += 1 - shares[i][p];
    }
    // A backdrop fills most of its picture: what it does not show is hardly one of its colours, however near
    // they are, as skin is to white. Of the subject there is little, so that its colours stand for others.
    smooth(subject[i]);
    Histogram alike = backdrop[i];
    smooth(alike);
    for (std::size_t b = 0; b < alike.size(); ++b) backdrop[i][b] += kAlike * (alike[b] - backdrop[i][b]);
  });
  Histogram all(kBins);
  for (const Histogram& h : subject)
    for (std::size_t b = 0; b < all.size(); ++b) all[b] += h[b];
  const double of_all = total(all);
  parallel_for(pictures.size(), threads, [&](std::size_t i) {
    const double own = total(subject[i]), of_backdrop = total(backdrop[i]);
    cameras_[i].odds.resize(kBins);
    for (std::size_t b = 0; b < all.size(); ++b) {
      double f = of_all > 0 ? all[b] / of_all : 1.0 / kBins;
      if (own > 0) f = (1 - kOwn) * f + kOwn * subject[i][b] / own;
      f = (1 - novelty) * f * kBins + novelty;
      const double g = of_backdrop > 0 ? (1 - kUnseen) * backdrop[i][b] / of_backdrop * kBins + kUnseen : 1;
      cameras_[i].odds[b] = static_cast<float>(std::log(f / g));
    }
  });
}

std::vector<float> ViewColors::odds(int camera, const Image& picture) const {
  const std::vector<float>& model = cameras_[static_cast<std::size_t>(camera)].odds;
  std::vector<float> odds(static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height));
  for (std::size_t p = 0; p < odds.size(); ++p) odds[p] = model[bin(picture.pixels.data() + 3 * p)];
  return odds;
}

}  // namespace floatstage::matting
