// Method:  labels of a frame from its neighbours': colours in local windows, distance to carried edges and
//          contrast in one energy
// Paper:   X. Bai, J. Wang, D. Simons, G. Sapiro, "Video SnapCut: Robust Video Object Cutout Using Localized
//          Classifiers", SIGGRAPH 2009, sections 3 and 4
// Differs: any number of labels at once; what comes to light beside an edge is held to be surroundings
// ADR:     0274, 0333

#include "matting/labels/label_step.h"

#include <algorithm>
#include <cmath>

#include "matting/labels/label_colors.h"
#include "matting/labels/label_cut.h"
#include "matting/labels/label_distance.h"

namespace floatstage::matting {
namespace {

constexpr int kSmallestWindow = 8;   // px to each side …
constexpr float kWindowBands = 3;    // … and as a rule: things move that far between two frames
constexpr float kSteps = 30;         // distance that counts, in halves of the slack …
constexpr float kDoubtfulSteps = 3;  // … and where nothing is known from before
constexpr float kDoubtfulBands = 4;  // how much further from edges labels are asked again there

// px from each pixel's middle to the nearest edge between labels.
std::vector<float> distance_to_edges(const Image& labels) {
  const int w = labels.width, h = labels.height;
  std::vector<float> out = distance_to(w, h, [&](int x, int y) {
    const std::uint8_t here = *labels.at(x, y);
    return (x + 1 < w && *labels.at(x + 1, y) != here) || (x > 0 && *labels.at(x - 1, y) != here) ||
           (y + 1 < h && *labels.at(x, y + 1) != here) || (y > 0 && *labels.at(x, y - 1) != here);
  });
  for (float& d : out) d += 0.5f;
  return out;
}

class Step {
 public:
  Step(const Image& picture, const std::vector<LabelHint>& hints, const LabelSample& sample, int count,
       const LabelClipOptions& options)
      : picture_(picture),
        hints_(hints),
        sample_(sample),
        options_(options),
        pixels_(hints.front().labels.pixels.size()) {
    evidence_.count = count;
    evidence_.labels = hints.front().labels;
    evidence_.asked.resize(pixels_);
    node_.resize(pixels_);
  }

  Image solve() {
    ask();
    add_distances();
    add_colors();
    return cut_labels(picture_, evidence_, options_.smooth);
  }

 private:
  float band() const { return static_cast<float>(options_.band * std::min(picture_.width, picture_.height)); }
  static bool doubtful(const LabelHint& hint, std::size_t p) {
    return hint.doubtful.pixels[p] || fresh(hint, p);
  }
  static bool fresh(const LabelHint& hint, std::size_t p) {
    return !hint.fresh.empty() && hint.fresh.pixels[p];
  }
  float& cost(std::size_t p, int label) {
    return evidence_
        .costs[node_[p] * static_cast<std::size_t>(evidence_.count) + static_cast<std::size_t>(label)];
  }

  void ask() {
    for (const LabelHint& hint : hints_) {
      edges_.push_back(distance_to_edges(hint.labels));
      for (std::size_t p = 0; p < pixels_; ++p)
        if (edges_.back()[p] <= (doubtful(hint, p) ? kDoubtfulBands : 1) * band() ||
            hint.labels.pixels[p] != evidence_.labels.pixels[p])
          evidence_.asked[p] = 1;
    }
    std::size_t asked = 0;
    for (std::size_t p = 0; p < pixels_; ++p)
      if (evidence_.asked[p]) node_[p] = asked++;
    evidence_.costs.assign(asked * static_cast<std::size_t>(evidence_.count), 0);
  }

  void add_distances() {
    for (std::size_t i = 0; i < hints_.size(); ++i) {
      const LabelHint& hint = hints_[i];
      const float equal = 1.0f / static_cast<float>(hints_.size());
      for (int l = 0; l < evidence_.count; ++l) {
        const std::vector<float> away = distance_to(picture_.width, picture_.height,
                                                    [&](int x, int y) { return *hint.labels.at(x, y) == l; });
        for (std::size_t p = 0; p < pixels_; ++p) {
          if (!evidence_.asked[p]) continue;
          const float share = hint.share.empty() ? equal : hint.share[p];
          const float d = away[p] > 0 ? away[p] - 0.5f : -edges_[i][p],
                      most = fresh(hint, p)            ? 0
                             : hint.doubtful.pixels[p] ? kDoubtfulSteps
                                                       : kSteps,
                      steps = std::clamp(2 * d / static_cast<float>(options_.slack), -most, most);
          cost(p, l) += share * std::log1p(std::exp(steps));
          if (l > 0 && doubtful(hint, p)) cost(p, l) += share * static_cast<float>(options_.uncovered);
        }
      }
    }
  }

  void add_colors() {
    Image wanted(picture_.width, picture_.height, 1);
    std::copy(evidence_.asked.begin(), evidence_.asked.end(), wanted.pixels.begin());
    LabelColors colors(picture_.width, picture_.height, evidence_.count,
                       std::max(kSmallestWindow, static_cast<int>(kWindowBands * band())), wanted);
    colors.learn(sample_.picture, sample_.labels);
    std::vector<float> odds(static_cast<std::size_t>(evidence_.count));
    for (int y = 0; y < picture_.height; ++y)
      for (int x = 0; x < picture_.width; ++x) {
        const std::size_t p = picture_.offset(x, y) / 3;
        if (!evidence_.asked[p]) continue;
        colors.odds(x, y, picture_.at(x, y), odds);
        for (int l = 0; l < evidence_.count; ++l)
          cost(p, l) -= static_cast<float>(options_.color) * odds[static_cast<std::size_t>(l)];
      }
  }

  const Image& picture_;
  const std::vector<LabelHint>& hints_;
  const LabelSample& sample_;
  const LabelClipOptions& options_;
  const std::size_t pixels_;
  LabelEvidence evidence_;
  std::vector<std::size_t> node_;
  std::vector<std::vector<float>> edges_;  // a hint, a pixel
};

}  // namespace

Image label_frame(const Image& picture, const std::vector<LabelHint>& hints, const LabelSample& sample,
                  int count, const LabelClipOptions& options) {
  return Step(picture, hints, sample, count, options).solve();
}

}  // namespace floatstage::matting
