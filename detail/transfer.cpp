// Detail transfer: M. Eisemann, "Error-Concealed Image-Based Rendering", section 4.3; colours by P. Perez, M.
// Gangnet, A. Blake, "Poisson Image Editing", SIGGRAPH 2003, as the harmonic fill of what both differ by
// along the seam (Z. Farbman et al. 2009 call it a membrane). Differs: ADR 0217.

#include "detail/transfer.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/statistics.h"
#include "detail/blend_mask.h"
#include "detail/harmonic_fill.h"

namespace floatstage::detail {
namespace {

// A pixel of the parent, seen through the homography, is a blur of half its width.
constexpr double kBlurOfAPixel = 0.5;
constexpr int kNearDifference = 6;  // px that the blur and the window of matching_pixels() reach
constexpr double kMeanAround = 4;   // px
constexpr float kSlope = 0.01F;     // light over two pixels: a few steps of 255
constexpr int kRounds = 3;
constexpr double kMostOfThem = 0.9;

LightPicture as_sharp_as_parent(const LightPicture& child, double zoom) {
  return blurred(child, zoom > 1.2 ? kBlurOfAPixel * zoom : 0);
}

LightPicture with_tones(const LightPicture& child, const ToneCurves& curves) {
  LightPicture out = child;
  for (Light& light : out.pixels) light = curves.apply(light);
  return out;
}

// Where the parent's colours are to be met: outside the seam where both show the same. Not in holes inside
// it, and not near what differs: what a leaf in front lacks is no correction for the bark behind it.
std::vector<std::uint8_t> rim_of(const std::vector<std::uint8_t>& child,
                                 const std::vector<std::uint8_t>& same, int width, int height) {
  const auto at = [&](int x, int y) {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
  };
  std::vector<std::uint8_t> rim(child.size(), 0);
  std::vector<std::pair<int, int>> open = {{0, 0}};  // the outermost pixels are the parent's
  rim[0] = 1;
  while (!open.empty()) {
    const auto [x, y] = open.back();
    open.pop_back();
    for (const auto& [u, v] : {std::pair(x - 1, y), {x + 1, y}, {x, y - 1}, {x, y + 1}})
      if (u >= 0 && v >= 0 && u < width && v < height && child[at(u, v)] == 0 && rim[at(u, v)] == 0) {
        rim[at(u, v)] = 1;
        open.emplace_back(u, v);
      }
  }
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      if (same[at(x, y)] != 0) continue;
      for (int v = std::max(0, y - kNearDifference); v <= std::min(height - 1, y + kNearDifference); ++v)
        std::fill_n(rim.begin() + static_cast<std::ptrdiff_t>(at(std::max(0, x - kNearDifference), v)),
                    std::min(width - 1, x + kNearDifference) - std::max(0, x - kNearDifference) + 1, 0);
    }
  return rim;
}

// How much the difference at a pixel says of colour: the less, the more a shift would change it.
float trust(const LightPicture& parent, const LightPicture& soft, std::size_t i) {
  const auto w = static_cast<std::size_t>(parent.width);
  if (i < w || i + w >= parent.pixels.size()) return 1;
  float slope = 0;
  for (const LightPicture* p : {&parent, &soft})
    for (std::size_t k = 0; k < 3; ++k)
      slope = std::max({slope, std::abs(p->pixels[i + 1][k] - p->pixels[i - 1][k]),
                        std::abs(p->pixels[i + w][k] - p->pixels[i - w][k])});
  return 1 / (1 + (slope / kSlope) * (slope / kSlope));
}

// What the child lacks along the seam, spread harmonically inside; the mean of its size.
double meet_colors(const LightPicture& soft, const LightPicture& parent,
                   const std::vector<std::uint8_t>& child, const std::vector<std::uint8_t>& same,
                   LightPicture& picture) {
  const std::vector<std::uint8_t> rim = rim_of(child, same, parent.width, parent.height);
  LightPicture membrane(parent.width, parent.height);
  for (std::size_t i = 0; i < child.size(); ++i)
    if (rim[i] != 0) {
      const float weight = trust(parent, soft, i);
      for (std::size_t k = 0; k < 3; ++k)
        membrane.pixels[i][k] = weight * (parent.pixels[i][k] - soft.pixels[i][k]);
      membrane.pixels[i][3] = weight;
    }
  // The mean over what is around, edges least: half a pixel of parallax there is no colour.
  membrane = blurred(membrane, kMeanAround);
  for (std::size_t i = 0; i < child.size(); ++i)
    for (std::size_t k = 0; k < 3 && rim[i] != 0; ++k) membrane.pixels[i][k] /= membrane.pixels[i][3];
  fill_harmonically(membrane, rim);
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < child.size(); ++i) {
    if (child[i] == 0) continue;
    ++count;
    for (std::size_t k = 0; k < 3; ++k) {
      sum += std::abs(static_cast<double>(membrane.pixels[i][k])) / 3;
      picture.pixels[i][k] = std::clamp(picture.pixels[i][k] + membrane.pixels[i][k], 0.0F, 1.0F);
    }
  }
  return count > 0 ? sum / count : 0;
}

// One displacement after another: the place in the child of each pixel, less the pixel.
LightPicture one_after_other(const LightPicture& first, const LightPicture& second) {
  LightPicture out = second;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      Light& d = out.at(x, y);
      const int u = std::clamp(x + static_cast<int>(std::lround(d[0])), 0, out.width - 1),
                v = std::clamp(y + static_cast<int>(std::lround(d[1])), 0, out.height - 1);
      for (std::size_t k = 0; k < 2; ++k) d[k] += first.at(u, v)[k];
    }
  return out;
}

// Moves edges onto one another along the seam, and again along the new one, while it gets cheaper; whether it
// did. What is only shifted is not removed: the seam that edges are matched on knows of no mismatch.
bool adapt(const LightPicture& parent, const LightPicture& soft, Transfer& t) {
  const std::vector<std::uint8_t> everywhere(t.same.size(), 1);
  t.first_seam = find_seam(soft, parent, everywhere);
  Seam seam = t.first_seam;
  LightPicture fitting = soft;
  for (int round = 0; round < kRounds; ++round) {
    Structure next = align_structure(fitting, parent, seam.child);
    if (round == 0) t.structure = next;
    if (next.on_seam.empty()) break;
    const LightPicture d =
        t.adapted ? one_after_other(t.structure.displacement, next.displacement) : next.displacement;
    LightPicture moved = displaced(soft, d);
    Seam cheaper = find_seam(moved, parent, everywhere);
    // Edges that were matched wrongly tear others apart: then the seam costs more than it did.
    if (cheaper.energy >= seam.energy) break;
    seam = std::move(cheaper);
    fitting = std::move(moved);
    t.structure.displacement = d;
    t.adapted = true;
  }
  t.seam_cost = seam.energy;
  // Inside, what lies beside its parent's by as much as edges did on the seam is still the same.
  std::vector<double> apart;
  for (const EdgePair& edge : t.structure.on_seam) apart.push_back((edge.child - edge.parent).norm());
  const long reach = apart.empty() ? 0 : std::lround(percentile(std::move(apart), kMostOfThem));
  t.same = reach < 1 ? matching_pixels(fitting, parent)
                     : matching_nearby(fitting, parent, static_cast<int>(reach));
  return t.adapted;
}

}  // namespace

Transfer transfer_detail(const LightPicture& child, const LightPicture& parent, double zoom,
                         const TransferOptions& options) {
  FLOATSTAGE_CHECK(child.width == parent.width && child.height == parent.height, "one size");
  Transfer t;
  const LightPicture soft = as_sharp_as_parent(child, zoom);
  // Three times: what shows something else has no say in the second, what was shifted none in the third.
  t.same.assign(child.pixels.size(), 1);
  LightPicture soft_toned;
  for (int round = 0; round < 2; ++round) {
    soft_toned = with_tones(soft, match_tones(soft, parent, t.same));
    t.same = matching_pixels(soft_toned, parent);
  }
  LightPicture fitting = child, soft_fitting = soft;
  if (options.adapt && adapt(parent, soft_toned, t)) {
    fitting = displaced(child, t.structure.displacement);
    soft_fitting = displaced(soft, t.structure.displacement);
  }
  const ToneCurves curves = match_tones(soft_fitting, parent, t.same);
  t.toned = with_tones(fitting, curves);
  soft_toned = with_tones(soft_fitting, curves);
  t.adjusted = t.toned;
  t.seam = find_seam(soft_toned, parent, t.same);
  t.correction = meet_colors(soft_toned, parent, t.seam.child, t.same, t.adjusted);
  t.alpha = blending_mask(t.adjusted, t.seam.child);
  return t;
}

}  // namespace floatstage::detail
