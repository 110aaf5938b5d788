// Method:  labels within a matte from a coarse hint: distance to its edges, colours and contrast in one
// energy Paper:   X. Bai, J. Wang, D. Simons, G. Sapiro, "Video SnapCut: Robust Video Object Cutout Using
// Localized
//          Classifiers", SIGGRAPH 2009, sections 3 and 4
// Differs: there is no background, and the hint comes from space
// ADR:     0298

#include "matting/labels/label_split.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "matting/labels/label_colors.h"
#include "matting/labels/label_cut.h"
#include "matting/labels/label_distance.h"

namespace floatstage::matting {
namespace {

constexpr float kMostAway = 15;     // nats: what is further off is no unlikelier
constexpr float kMostOdds = 2;      // nats by which a place's colours speak
constexpr int kSmallestWindow = 8;  // px to each side of windows of colours …
constexpr float kWindow = 0.15F;    // … and of the picture's smaller side
constexpr float kNever = 1000;      // nats: what a label costs where it may not be

struct Box {
  int x = 0, y = 0, width = 0, height = 0;
};

Box box_of(const Image& matte) {
  int x0 = matte.width, x1 = -1, y0 = matte.height, y1 = -1;
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x)
      if (*matte.at(x, y)) {
        x0 = std::min(x0, x), x1 = std::max(x1, x);
        y0 = std::min(y0, y), y1 = y;
      }
  return {x0, y0, std::max(0, x1 - x0 + 1), std::max(0, y1 - y0 + 1)};
}

Image crop(const Image& whole, const Box& box) {
  Image part(box.width, box.height, whole.channels);
  for (int y = 0; y < box.height; ++y)
    std::copy_n(whole.at(box.x, box.y + y), box.width * whole.channels, part.at(0, y));
  return part;
}

class Split {
 public:
  Split(const LabelSplit& split, const LabelSplitOptions& options, const Box& box)
      : split_(split),
        options_(options),
        box_(box),
        picture_(crop(split.picture, box)),
        matte_(crop(split.matte, box)),
        hint_(crop(split.hint, box)) {
    evidence_.count = split.labels;
    evidence_.labels = Image(box.width, box.height, 1);
    evidence_.asked.assign(matte_.pixels.size(), 0);
    node_.assign(matte_.pixels.size(), 0);
    std::size_t nodes = 0;
    for (std::size_t p = 0; p < matte_.pixels.size(); ++p)
      if (matte_.pixels[p]) evidence_.asked[p] = 1, node_[p] = nodes++;
    evidence_.costs.assign(nodes * static_cast<std::size_t>(split.labels), 0.F);
  }

  // Labels 1 … in the box.
  Image solve() {
    add_hint();
    add_colors();
    add_given();
    begin();
    Image labels = cut_labels(picture_, evidence_, options_.smooth);
    for (std::size_t p = 0; p < labels.pixels.size(); ++p)
      labels.pixels[p] = evidence_.asked[p] ? static_cast<std::uint8_t>(labels.pixels[p] + 1) : 0;
    return labels;
  }

 private:
  float* costs(std::size_t p) {
    return evidence_.costs.data() + node_[p] * static_cast<std::size_t>(evidence_.count);
  }

  // Where a label is not, by how far off it is; where it is hidden, by how far inside what hides it.
  void add_hint() {
    std::vector<std::vector<float>> away, within;
    for (int l = 1; l <= split_.labels; ++l) {
      const Image where = crop(split_.where[static_cast<std::size_t>(l - 1)], box_);
      away.push_back(
          distance_to(box_.width, box_.height, [&](int x, int y) { return *where.at(x, y) != 0; }));
      within.push_back(
          distance_to(box_.width, box_.height, [&](int x, int y) { return *where.at(x, y) == 0; }));
    }
    const auto slack = static_cast<float>(split_.slack);
    for (std::size_t p = 0; p < matte_.pixels.size(); ++p) {
      if (!evidence_.asked[p]) continue;
      const std::size_t front = hint_.pixels[p];
      for (std::size_t l = 0; l < away.size(); ++l) {
        const float off = 2 * away[l][p] / slack,
                    hidden = front > 0 && front != l + 1 ? within[front - 1][p] / slack : 0;
        costs(p)[l] += std::min(off + hidden * hidden / 4, kMostAway);
      }
    }
  }

  void add_colors() {
    std::vector<float> odds(static_cast<std::size_t>(split_.labels));
    for (std::size_t p = 0; p < matte_.pixels.size(); ++p) {
      if (!evidence_.asked[p]) continue;
      split_.palette.odds(picture_.pixels.data() + 3 * p, odds);
      for (std::size_t l = 0; l < odds.size(); ++l)
        costs(p)[l] -= static_cast<float>(options_.palette) * odds[l];
    }
    if (!split_.near_picture || !split_.near_labels) return;
    const Image picture = crop(*split_.near_picture, box_);
    Image labels = crop(*split_.near_labels, box_), wanted(box_.width, box_.height, 1);
    for (std::uint8_t& l : labels.pixels) --l;  // what has none becomes 255, which is left out
    std::copy(evidence_.asked.begin(), evidence_.asked.end(), wanted.pixels.begin());
    const int side = std::min(split_.picture.width, split_.picture.height);
    LabelColors colors(box_.width, box_.height, split_.labels,
                       std::max(kSmallestWindow, static_cast<int>(kWindow * static_cast<float>(side))),
                       wanted);
    colors.learn(picture, labels);
    for (int y = 0; y < box_.height; ++y)
      for (int x = 0; x < box_.width; ++x) {
        const std::size_t p = matte_.offset(x, y);
        if (!evidence_.asked[p]) continue;
        colors.odds(x, y, picture_.at(x, y), odds);
        // A label that was not at this place has no colours there, which says little.
        const float mean = std::accumulate(odds.begin(), odds.end(), 0.F) / static_cast<float>(odds.size());
        for (std::size_t l = 0; l < odds.size(); ++l)
          costs(p)[l] -=
              static_cast<float>(options_.color) * std::clamp(odds[l] - mean, -kMostOdds, kMostOdds);
      }
  }

  void add_given() {
    if (split_.may.empty()) return;
    for (int y = 0; y < box_.height; ++y)
      for (int x = 0; x < box_.width; ++x) {
        const std::size_t p = matte_.offset(x, y);
        const std::uint32_t may = split_.may[split_.matte.offset(box_.x + x, box_.y + y)];
        if (!evidence_.asked[p] || may == 0) continue;
        for (int l = 0; l < split_.labels; ++l)
          if (!(may >> l & 1)) costs(p)[l] += kNever;
      }
  }

  // The search begins with what each pixel alone would be.
  void begin() {
    for (std::size_t p = 0; p < matte_.pixels.size(); ++p) {
      if (!evidence_.asked[p]) continue;
      const float* of = costs(p);
      evidence_.labels.pixels[p] = static_cast<std::uint8_t>(std::min_element(of, of + evidence_.count) - of);
    }
  }

  const LabelSplit& split_;
  const LabelSplitOptions& options_;
  const Box box_;
  const Image picture_, matte_, hint_;
  LabelEvidence evidence_;
  std::vector<std::size_t> node_;
};

}  // namespace

Image split_labels(const LabelSplit& split, const LabelSplitOptions& options) {
  Image labels(split.matte.width, split.matte.height, 1);
  const Box box = box_of(split.matte);
  if (box.width == 0) return labels;
  const Image found = Split(split, options, box).solve();
  for (int y = 0; y < box.height; ++y) std::copy_n(found.at(0, y), box.width, labels.at(box.x, box.y + y));
  return labels;
}

std::vector<Image> share_matte(const Image& matte, const Image& labels, int count) {
  std::vector<Image> mattes(static_cast<std::size_t>(count), Image(matte.width, matte.height, 1));
  std::vector<int> around(static_cast<std::size_t>(count));
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x) {
      const int own = *labels.at(x, y), alpha = *matte.at(x, y);
      if (own == 0 || alpha == 0) continue;
      std::fill(around.begin(), around.end(), 0);
      int all = 0;
      for (int qy = std::max(0, y - 1); qy <= std::min(matte.height - 1, y + 1); ++qy)
        for (int qx = std::max(0, x - 1); qx <= std::min(matte.width - 1, x + 1); ++qx)
          if (const int l = *labels.at(qx, qy); l > 0) ++around[static_cast<std::size_t>(l - 1)], ++all;
      int left = alpha;
      for (int l = 0; l < count; ++l) {
        if (l == own - 1) continue;
        const int part = alpha * around[static_cast<std::size_t>(l)] / all;
        *mattes[static_cast<std::size_t>(l)].at(x, y) = static_cast<std::uint8_t>(part);
        left -= part;
      }
      *mattes[static_cast<std::size_t>(own - 1)].at(x, y) = static_cast<std::uint8_t>(left);
    }
  return mattes;
}

}  // namespace floatstage::matting
