#include <algorithm>
#include <cmath>
#include <vector>

#include "core/text.h"
#include "matting/keyers/keyers.h"
#include "matting/refine_edges.h"

namespace floatstage::matting {
namespace {

constexpr CleanupOptions kDefaultCleanup{.close_radius = 1, .smallest_island = 0.02, .smallest_hole = 0.001};
constexpr float kDarkestShadow = 0.55f;    // the plate in the subject's shadow is at most this much darker
constexpr float kBrightestReflex = 1.15f;  // and this much brighter in its reflected light

// The median of each byte; of an even number of pictures the mean of the middle two.
Image median_of(const std::vector<Image>& pictures) {
  if (pictures.size() == 1) return pictures.front();
  Image median = pictures.front();
  std::vector<std::uint8_t> values(pictures.size());
  const std::size_t half = values.size() / 2;
  for (std::size_t i = 0; i < median.pixels.size(); ++i) {
    for (std::size_t k = 0; k < pictures.size(); ++k) values[k] = pictures[k].pixels[i];
    std::sort(values.begin(), values.end());
    median.pixels[i] = values.size() % 2
                           ? values[half]
                           : static_cast<std::uint8_t>((values[half - 1] + values[half] + 1) / 2);
  }
  return median;
}

class DifferenceKeyer : public Keyer {
 public:
  DifferenceKeyer(Image plate, int threshold, const CleanupOptions& cleanup)
      : plate_(std::move(plate)), threshold_(threshold), cleanup_(cleanup) {}

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty()) return Matte{frame.info, 0, 0, 0, nullptr};
    auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    if (rgb->width != plate_.width || rgb->height != plate_.height)
      return fail(ErrorCode::InvalidArgument,
                  text("camera ", frame.info.camera, ": its frame is ", rgb->width, "x", rgb->height,
                       " but its clean plate is ", plate_.width, "x", plate_.height,
                       "; record the plate with the take's settings"));
    Image alpha(rgb->width, rgb->height, 1);
    const float low = 0.5f * static_cast<float>(threshold_), slope = 255 / static_cast<float>(threshold_);
    for (std::size_t i = 0; i < alpha.pixels.size(); ++i) {
      const float d = difference(rgb->pixels.data() + 3 * i, plate_.pixels.data() + 3 * i);
      alpha.pixels[i] = static_cast<std::uint8_t>(std::clamp((d - low) * slope + 0.5f, 0.0f, 255.0f));
    }
    alpha = clean_up(alpha, cleanup_);
    // Of a mixed pixel C = a F + (1 - a) B the distance to B is a |F - B|: linear in a, as refine_edges()
    // wants it.
    const auto distance = [&](int y, int x0, int count, float* out) {
      for (int x = x0; x < x0 + count; ++x) *out++ = difference(rgb->at(x, y), plate_.at(x, y));
    };
    refine_edges(distance, static_cast<float>(threshold_), Image(alpha.width, alpha.height, 1), alpha);
    return make_matte(frame.info, alpha);
  }

  Result<void> suppress_spill(const Frame& frame, Image& rgb) const override { return to_rgb(frame, rgb); }
  std::string spec() const override { return text("difference:", threshold_); }
  CleanupOptions cleanup() const override { return cleanup_; }

 private:
  // Distance in RGB from p to the piece of the line through black and the plate's colour b on which its
  // shadows and reflexes lie: a change of brightness alone costs nothing there, a change of colour costs its
  // full length. (The brightness and chromaticity distortion of Horprasert et al. 1999, eq. 5-6, as one
  // distance.)
  static float difference(const std::uint8_t* p, const std::uint8_t* b) {
    const float pr = p[0], pg = p[1], pb = p[2], br = b[0], bg = b[1], bb = b[2];
    const float bright = std::clamp((pr * br + pg * bg + pb * bb) / (br * br + bg * bg + bb * bb + 1e-3f),
                                    kDarkestShadow, kBrightestReflex);
    const float dr = pr - bright * br, dg = pg - bright * bg, db = pb - bright * bb;
    return std::sqrt(dr * dr + dg * dg + db * db);
  }

  Image plate_;
  int threshold_;
  CleanupOptions cleanup_;
};

}  // namespace

Result<std::unique_ptr<Keyer>> make_difference_keyer(const KeyerRequest& request) {
  const auto threshold = threshold_of(request, "difference", 24);
  if (!threshold) return forward(threshold);
  if (request.samples.empty())
    return fail(ErrorCode::InvalidArgument,
                "the difference keyer needs a clean plate of each camera; record one of the empty stage");
  const Image& first = request.samples.front();
  for (const Image& sample : request.samples)
    if (sample.width != first.width || sample.height != first.height)
      return fail(ErrorCode::InvalidArgument,
                  text("the clean plates of a camera differ in size: ", first.width, "x", first.height,
                       " and ", sample.width, "x", sample.height, "; give plates of one size"));
  return std::unique_ptr<Keyer>(
      new DifferenceKeyer(median_of(request.samples), *threshold, request.cleanup.value_or(kDefaultCleanup)));
}

}  // namespace floatstage::matting
