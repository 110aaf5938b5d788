#include <algorithm>
#include <cmath>
#include <vector>

#include "core/check.h"
#include "core/text.h"
#include "matting/keyers/keyers.h"
#include "matting/keyers/plate.h"
#include "matting/keyers/plate_measure.h"

namespace floatstage::matting {
namespace {

constexpr double kHole = 0.02, kMiddle = 0.4;  // of the largest part
constexpr float kNoiseUnit = 16;               // see Plate::noise

float threshold(std::uint8_t noise, const PlateKeyOptions& o) {
  return std::clamp(static_cast<float>(o.sigmas) * noise / kNoiseUnit, static_cast<float>(o.least),
                    static_cast<float>(o.most));
}

// Nobody ever saw what is behind the subject there.
bool unknown(const Plate& plate, std::size_t pixel) { return plate.confidence.pixels[pixel] == 0; }

class PlateKeyer : public Keyer {
 public:
  PlateKeyer(const Plate& plate, const PlateKeyOptions& options, const CleanupOptions& cleanup)
      : measure_(measure_of(plate, options)), sigmas_(options.sigmas), cleanup_(cleanup) {}

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty()) return Matte{frame.info, 0, 0, 0, nullptr};
    auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    if (!measure_.fits(rgb->width, rgb->height))
      return fail(ErrorCode::InvalidArgument,
                  text("camera ", frame.info.camera, ": its frame is ", rgb->width, "x", rgb->height,
                       " but its plate is ", measure_.width(), "x", measure_.height(),
                       "; learn the plate from this take's pictures"));
    return make_matte(frame.info, measure_.key(*rgb, cleanup_));
  }

  Result<void> suppress_spill(const Frame& frame, Image& rgb) const override { return to_rgb(frame, rgb); }
  std::string spec() const override { return text("plate:", sigmas_); }
  CleanupOptions cleanup() const override { return cleanup_; }
  const RowMeasure* rows() const override { return &measure_; }

 private:
  PlateMeasure measure_;
  double sigmas_;
  CleanupOptions cleanup_;
};

}  // namespace

PlateLight light_of(const PlateKeyOptions& o) {
  return {static_cast<float>(o.darkest_shadow), static_cast<float>(o.brightest_reflex)};
}

PlateMeasure measure_of(const Plate& plate, const PlateKeyOptions& options) {
  std::vector<float> thresholds;
  for (std::size_t i = 0; i < plate.noise.pixels.size(); ++i)
    thresholds.push_back(unknown(plate, i) ? 0 : threshold(plate.noise.pixels[i], options));
  return PlateMeasure(plate.color, std::move(thresholds), light_of(options),
                      static_cast<float>(options.least), static_cast<float>(options.most));
}

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
  const PlateLight light = light_of(options);
  Image out(picture.width, picture.height, 1);
  for (std::size_t i = 0; i < out.pixels.size(); ++i) {
    const float t = threshold(plate.noise.pixels[i], options);
    const std::uint8_t *p = picture.pixels.data() + 3 * i, *b = plate.color.pixels.data() + 3 * i;
    const PlateDistance d = plate_distance(p, b, light);
    const float change =
        std::abs(1 - d.bright) * std::sqrt(static_cast<float>(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]));
    const PlateClass what = unknown(plate, i) || d.length >= t ? PlateClass::Subject
                            : change < t                       ? PlateClass::Plate
                            : d.bright < 1                     ? PlateClass::Shadow
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
  return std::unique_ptr<Keyer>(new PlateKeyer(plate, options, cleanup.value_or(usual)));
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
