#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/frame.h"
#include "core/image.h"
#include "core/matte.h"
#include "core/result.h"
#include "matting/cast_shadows.h"
#include "matting/keyers/keyer.h"
#include "matting/keyers/plate.h"
#include "matting/keyers/row_measure.h"

// Private to the stage.
namespace floatstage::matting {

/// Which brightness of the plate its shadows and reflexes have.
struct PlateLight {
  float darkest = 1, brightest = 1;
};

/// How far an RGB pixel `p` is from the plate's `b`.
struct PlateDistance {
  float length, bright;
};

/// To the piece of the line through black and b on which its shadows and reflexes lie (the brightness and
/// chromaticity distortion of Horprasert et al. 1999, eq. 5-6, as one distance): a change of light alone
/// costs nothing, a change of colour its full length, in 8-bit steps.
PlateDistance plate_distance(const std::uint8_t* p, const std::uint8_t* b, const PlateLight& light);

/// What a plate's shadows and reflexes may be.
PlateLight light_of(const PlateKeyOptions& options);

/// A picture against one that was taken before, pixel by pixel: what the keyers "difference" and "plate"
/// have in common.
class PlateMeasure : public RowMeasure {
 public:
  /// `thresholds`: a pixel's distance that is half opaque, in 8-bit steps; 0 where nobody knows the plate,
  /// whose distance is `unknown` there. `contrast`: as in refine_edges().
  PlateMeasure(Image color, std::vector<float> thresholds, const PlateLight& light, float contrast,
               float unknown)
      : color_(std::move(color)),
        thresholds_(std::move(thresholds)),
        light_(light),
        contrast_(contrast),
        unknown_(unknown) {}

  /// Until the next call the plate is as the picture shows it where `shade` (of any size) falls and around
  /// it, of pixels that are of the plate's colour between that light and all of it; as it was learnt
  /// elsewhere.
  void light(const PixelRows& rgb, const CastShade& shade);

  /// The keyer's matte, whole pictures at a time: the reference of LiveKey. Nothing for a picture of another
  /// size than the plate, which fits() tells.
  Image key(const Image& rgb, const CleanupOptions& cleanup) const;
  int width() const { return color_.width; }
  int height() const { return color_.height; }

  bool fits(int width, int height) const override { return width == color_.width && height == color_.height; }
  void classify(const std::uint8_t* rgb, int y, int width, std::vector<std::uint8_t>& scratch,
                std::uint64_t* subject, std::uint64_t* faint, std::uint64_t* doubt) const override;
  void opacities(const std::uint8_t* rgb, int x, int y, int count, std::uint8_t* out) const override;
  float at(const std::uint8_t* rgb, int x, int y) const override;
  void quantize(const std::uint8_t* rgb, int x, int y, int count, std::vector<std::uint8_t>& scratch,
                std::int32_t* out) const override;
  float contrast() const override { return contrast_; }

 private:
  const float* thresholds_at(int x, int y) const {
    return thresholds_.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(color_.width) +
           static_cast<std::size_t>(x);
  }
  void distances(const std::uint8_t* rgb, int x, int y, int count, float* out) const;

  /// The same of the pixels from (x, y) to before another, where `left` of the plate's colours is left.
  void light(const PixelRows& rgb, const std::array<float, 3>& left, const std::array<int, 2>& from,
             const std::array<int, 2>& to);

  Image color_;
  std::vector<float> thresholds_;
  PlateLight light_;
  float contrast_, unknown_;
  struct Lit {
    std::size_t pixel = 0;
    std::array<std::uint8_t, 3> learnt{};
  };
  std::vector<Lit> lit_;
};

/// Against a plate: distances are half opaque at as many deviations of a pixel's noise as `options` say.
PlateMeasure measure_of(const Plate& plate, const PlateKeyOptions& options);

}  // namespace floatstage::matting
