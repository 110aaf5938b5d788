#include <algorithm>
#include <cmath>
#include <vector>

#include "core/check.h"
#include "core/text.h"
#include "matting/keyers/keyers.h"
#include "matting/keyers/plate.h"
#include "matting/keyers/plate_kernels.h"
#include "matting/refine_edges.h"

namespace floatstage::matting {
namespace {

constexpr double kHole = 0.02, kMiddle = 0.4;  // of the largest part
constexpr float kNoiseUnit = 16;               // see Plate::noise

// A pixel against the plate's colour there.
struct Difference {
  float length = 0;  // 8-bit steps, to the nearest colour that light alone makes of the plate
  float bright = 1;  // brightness of that colour over the plate's
};

// The line through black and the plate's colour, from its darkest shadow to its brightest reflex (Horprasert
// et al. 1999, eq. 5-6, as one distance): a change of light alone costs nothing, a change of colour its full
// length.
Difference difference(const std::uint8_t* p, const std::uint8_t* b, const PlateKeyOptions& o) {
  const float pr = p[0], pg = p[1], pb = p[2], br = b[0], bg = b[1], bb = b[2];
  const float bright =
      std::clamp((pr * br + pg * bg + pb * bb) / (br * br + bg * bg + bb * bb + 1e-3f),
                 static_cast<float>(o.darkest_shadow), static_cast<float>(o.brightest_reflex));
  const float dr = pr - bright * br, dg = pg - bright * bg, db = pb - bright * bb;
  return {std::sqrt(dr * dr + dg * dg + db * db), bright};
}

float threshold(std::uint8_t noise, const PlateKeyOptions& o) {
  return std::clamp(static_cast<float>(o.sigmas) * noise / kNoiseUnit, static_cast<float>(o.least),
                    static_cast<float>(o.most));
}

class PlateKeyer : public Keyer {
 public:
  PlateKeyer(Plate plate, const PlateKeyOptions& options, const CleanupOptions& cleanup)
      : plate_(std::move(plate)), options_(options), cleanup_(cleanup) {
    for (std::size_t i = 0; i < plate_.noise.pixels.size(); ++i)
      thresholds_.push_back(unknown(i) ? 0 : threshold(plate_.noise.pixels[i], options_));
  }

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty()) return Matte{frame.info, 0, 0, 0, nullptr};
    auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    if (rgb->width != plate_.color.width || rgb->height != plate_.color.height)
      return fail(ErrorCode::InvalidArgument,
                  text("camera ", frame.info.camera, ": its frame is ", rgb->width, "x", rgb->height,
                       " but its plate is ", plate_.color.width, "x", plate_.color.height,
                       "; learn the plate from this take's pictures"));
    const auto darkest = static_cast<float>(options_.darkest_shadow),
               brightest = static_cast<float>(options_.brightest_reflex);
    Image alpha(rgb->width, rgb->height, 1);
    plate_kernels().alphas(rgb->pixels.data(), plate_.color.pixels.data(), thresholds_.data(),
                           alpha.pixels.size(), darkest, brightest, alpha.pixels.data());
    alpha = clean_up(alpha, cleanup_);
    const auto distance = [&](int y, int x0, int count, float* out) {
      plate_kernels().lengths(rgb->at(x0, y), plate_.color.at(x0, y), static_cast<std::size_t>(count),
                              darkest, brightest, out);
      const float* t = thresholds_.data() + (alpha.at(x0, y) - alpha.pixels.data());
      for (int x = 0; x < count; ++x)
        if (t[x] == 0) out[x] = static_cast<float>(options_.most);
    };
    refine_edges(distance, static_cast<float>(options_.least), Image(alpha.width, alpha.height, 1), alpha);
    return make_matte(frame.info, alpha);
  }

  Result<void> suppress_spill(const Frame& frame, Image& rgb) const override { return to_rgb(frame, rgb); }
  std::string spec() const override { return text("plate:", options_.sigmas); }
  CleanupOptions cleanup() const override { return cleanup_; }

 private:
  // Nobody ever saw what is behind the subject there.
  bool unknown(std::size_t pixel) const { return plate_.confidence.pixels[pixel] == 0; }

  Plate plate_;
  PlateKeyOptions options_;
  CleanupOptions cleanup_;
  std::vector<float> thresholds_;  // by pixel; 0 where the plate is unknown
};

}  // namespace

Result<void> PlateKeyOptions::check() const {
  if (!(sigmas >= 1 && sigmas <= 100))
    return fail(ErrorCode::InvalidArgument,
                text("'plate:", sigmas, "': the threshold must be 1 to 100 sigmas, as in plate:6"));
  if (!(least >= 1 && least <= most && most <= 254))
    return fail(ErrorCode::InvalidArgument,
                text("the plate's thresholds ", least, " and ", most, " must be 1 to 254, in this order"));
  if (!(darkest_shadow > 0 && darkest_shadow <= 1 && brightest_reflex >= 1 && brightest_reflex <= 4))
    return fail(ErrorCode::InvalidArgument,
                "the darkest shadow must be up to 1, the brightest reflex 1 to 4 of the plate");
  return {};
}

Image classify(const Plate& plate, const Image& picture, const PlateKeyOptions& options) {
  FLOATSTAGE_CHECK(
      picture.channels == 3 && picture.width == plate.color.width && picture.height == plate.color.height,
      "a picture of another size than its plate");
  Image out(picture.width, picture.height, 1);
  for (std::size_t i = 0; i < out.pixels.size(); ++i) {
    const float t = threshold(plate.noise.pixels[i], options);
    const std::uint8_t *p = picture.pixels.data() + 3 * i, *b = plate.color.pixels.data() + 3 * i;
    const Difference d = difference(p, b, options);
    const float light =
        std::abs(1 - d.bright) * std::sqrt(static_cast<float>(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]));
    const bool unknown = plate.confidence.pixels[i] == 0;
    const PlateClass what = unknown || d.length >= t ? PlateClass::Subject
                            : light < t              ? PlateClass::Plate
                            : d.bright < 1           ? PlateClass::Shadow
                                                     : PlateClass::Reflex;
    out.pixels[i] = static_cast<std::uint8_t>(what);
  }
  return out;
}

Image where_is(const Image& classes, PlateClass what) {
  Image mask(classes.width, classes.height, 1);
  for (std::size_t p = 0; p < mask.pixels.size(); ++p)
    mask.pixels[p] = classes.pixels[p] == static_cast<std::uint8_t>(what) ? 255 : 0;
  return mask;
}

PlateKeyOptions before_clutter() { return {.darkest_shadow = 0.72, .brightest_reflex = 1.12}; }

CleanupOptions plate_clean_up(int width, int height, bool found) {
  return {.close_radius = std::max(1, std::max(width, height) / 320),
          .smallest_island = 0.02,
          .smallest_hole = found ? kMiddle : kHole};
}

Result<std::unique_ptr<Keyer>> make_plate_keyer(Plate plate, const PlateKeyOptions& options,
                                                const std::optional<CleanupOptions>& cleanup) {
  if (Result<void> ok = options.check(); !ok) return forward(ok);
  const CleanupOptions usual = plate_clean_up(plate.color.width, plate.color.height, false);
  return std::unique_ptr<Keyer>(new PlateKeyer(std::move(plate), options, cleanup.value_or(usual)));
}

Result<std::unique_ptr<Keyer>> make_plate_keyer(const KeyerRequest& request) {
  const auto sigmas = threshold_of(request, "plate", 6);
  if (!sigmas) return forward(sigmas);
  if (request.samples.empty())
    return fail(ErrorCode::InvalidArgument,
                "the plate keyer needs photographs of the empty stage, or of the take to find it in");
  Result<Plate> plate = learn_plate(request.samples);
  if (!plate) return forward(plate);
  PlateKeyOptions options = before_clutter();
  options.sigmas = *sigmas;
  return make_plate_keyer(std::move(*plate), options, request.cleanup);
}

}  // namespace floatstage::matting
