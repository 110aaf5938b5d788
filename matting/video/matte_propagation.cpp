// Method:  a frame's matte from its neighbours': carried along
//          flow as guidance, chosen anew
// Paper:   the thesis, section 7.3, eq. 7.3 to 7.5
// Differs: guidance counts less where the carried picture does not explain the frame
// ADR:     0094

#include "matting/video/matte_propagation.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>

#include "core/text.h"

namespace floatstage::matting {
namespace {

constexpr double kSmallestStroke = 9;  // px of the working size: what a click counts for at least
constexpr double kUnclaimed =
    0.02;                     // of a stroke's strength: how much a component is background that nobody marked
constexpr int kShimmer = 48;  // 8-bit steps: larger differences to the carried matte are motion

// Full weights in all of the picture are 1; a few pixels of a stroke count as much together.
double gathered(const MatteConstraint& opinion) {
  if (opinion.weight.empty()) return 1;
  const double sum = std::accumulate(opinion.weight.pixels.begin(), opinion.weight.pixels.end(), 0.0) / 255;
  return static_cast<double>(opinion.weight.pixels.size()) / std::max(sum, kSmallestStroke);
}

}  // namespace

MatteConstraint guidance_from(const Image& matte, const Image& its_picture, const Image& picture) {
  const FrameFlow flow = flow_between(its_picture, picture);
  return {carried(matte, flow), confidence_of(its_picture, picture, flow)};
}

Result<Selection> choose(const MattingComponents& components, const FrameEvidence& evidence,
                         const VideoMattingOptions& options) {
  std::vector<SelectionTerm> terms;
  if (!evidence.keyframe.empty())
    terms.push_back({evidence.keyframe, options.keyframe_strength * gathered(evidence.keyframe)});
  if (!evidence.likelihood.empty()) terms.push_back({evidence.likelihood, options.likelihood_strength});
  // Components add up to 1: with strokes alone all of them together would explain a stroke on the subject
  // best.
  if (evidence.carried.empty() && evidence.likelihood.empty() && !evidence.keyframe.weight.empty())
    terms.push_back(
        {{Image(components.width, components.height, 1, 0), {}}, kUnclaimed * options.keyframe_strength});
  const std::vector<bool>* last = nullptr;
  double largest = 0;
  for (const auto& c : evidence.carried) {
    terms.push_back({c.guidance, options.guidance_strength * c.share});
    if (c.share > largest && !c.last_choice.empty()) {
      largest = c.share;
      last = &c.last_choice;
    }
  }
  return last ? select_components(components, terms, *last, options.persistence)
              : select_components(components, terms);
}

double misfit_of(const Image& matte, const std::vector<FrameEvidence::Carried>& carried) {
  double difference = 0, whole = 0;
  for (const auto& c : carried) {
    for (std::size_t p = 0; p < matte.pixels.size(); ++p) {
      const double w = c.share * c.guidance.weight.pixels[p], g = c.guidance.opacity.pixels[p];
      difference += w * (g - matte.pixels[p]) * (g - matte.pixels[p]);
      whole += w * g * g;
    }
  }
  return whole > 0 ? difference / whole : 0;
}

Image filtered(const Image& matte, const MatteConstraint& previous, double share) {
  Image out = matte;
  for (std::size_t p = 0; p < out.pixels.size(); ++p) {
    const int difference = previous.opacity.pixels[p] - matte.pixels[p];
    if (std::abs(difference) >= kShimmer) continue;
    const double trust = previous.weight.pixels[p] / 255.0 * (1 - std::abs(difference) / double{kShimmer});
    out.pixels[p] = static_cast<std::uint8_t>(std::lround(matte.pixels[p] + share * trust * difference));
  }
  return out;
}

double flicker_between(const Image& matte, const Image& carried_previous) {
  double sum = 0;
  for (std::size_t p = 0; p < matte.pixels.size(); ++p)
    sum += std::abs(matte.pixels[p] - carried_previous.pixels[p]);
  return sum / (255.0 * static_cast<double>(matte.pixels.size()));
}

}  // namespace floatstage::matting
