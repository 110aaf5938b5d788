// Method:  what differs from the black and the lit cloth that the rim shows (matting/keyers/backing_field.h)
// ADR:     0170

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/text.h"
#include "matting/keyers/backing_field.h"
#include "matting/keyers/keyers.h"
#include "matting/keyers/rim_check.h"

namespace floatstage::matting {
namespace {

// A black stage leaves dark crevices in the subject and specks on the cloth.
constexpr CleanupOptions kDefaultCleanup{.close_radius = 2, .smallest_island = 0.02, .smallest_hole = 0.003};
constexpr double kBrighter = 2;  // times the backing, in the mean
constexpr FieldOptions kBlackStage{.darker_too = true};

Image grey_of(const Image& rgb) {
  Image grey(rgb.width, rgb.height, 1);
  for (std::size_t i = 0; i < grey.pixels.size(); ++i) {
    const std::uint8_t* p = rgb.pixels.data() + 3 * i;
    grey.pixels[i] = static_cast<std::uint8_t>((77 * p[0] + 150 * p[1] + 29 * p[2] + 128) >> 8);  // BT.601
  }
  return grey;
}

// Against a stage, the subject is the light: on any other backing as much is darker as is brighter.
bool is_black(const BackingField& stage, const Image& grey, const Image& alpha) {
  double sum = 0;
  long count = 0;
  for (std::size_t i = 0; i < alpha.pixels.size(); ++i)
    if (alpha.pixels[i] >= 128) {
      sum += grey.pixels[i];
      ++count;
    }
  return count == 0 || stage.grey() * kBrighter <= sum / static_cast<double>(count);
}

class LuminanceKeyer : public Keyer {
 public:
  LuminanceKeyer(std::optional<int> threshold, std::optional<BackingField> stage,
                 const CleanupOptions& cleanup)
      : threshold_(threshold), stage_(std::move(stage)), cleanup_(cleanup) {}

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty()) return Matte{frame.info, 0, 0, 0, nullptr};
    auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    const std::optional<BackingField> own =
        stage_ || threshold_ ? std::nullopt : learn_field({*rgb}, {}, kBlackStage);
    const BackingField* stage = stage_ ? &*stage_ : own ? &*own : nullptr;
    Image alpha = stage ? stage->key(*rgb) : Image(rgb->width, rgb->height, 1, 255);
    const Image grey = grey_of(*rgb);
    if (threshold_) {
      // A ramp from half the threshold to one and a half: 128 and above exactly where grey > threshold.
      for (std::size_t i = 0; i < alpha.pixels.size(); ++i) {
        const int ramp = std::clamp((2 * grey.pixels[i] - *threshold_) * 255 / (2 * *threshold_), 0, 255);
        alpha.pixels[i] = std::min(alpha.pixels[i], static_cast<std::uint8_t>(ramp));
      }
    }
    alpha = clean_up(alpha, cleanup_);
    if (Result<void> ok = check_rim(alpha, frame.info, "black stage"); !ok) return forward(ok);
    if (stage && !is_black(*stage, grey, alpha))
      return fail(ErrorCode::Unsupported,
                  text("camera ", frame.info.camera, " shows no black stage: what is around the subject is ",
                       std::lround(stage->grey()),
                       " bright in the mean, more than half of what stands out from it; "
                       "try the methods 'chroma' or 'consistent', or a plate"));
    if (stage && !threshold_) stage->solve_edges(*rgb, alpha);
    return make_matte(frame.info, alpha);
  }

  Result<Image> suppress_spill(const Frame& frame) const override { return to_rgb(frame); }
  std::string spec() const override {
    return threshold_ ? text("luminance:", *threshold_) : std::string("luminance");
  }
  CleanupOptions cleanup() const override { return cleanup_; }

 private:
  std::optional<int> threshold_;
  std::optional<BackingField> stage_;  // absent: every frame's own
  CleanupOptions cleanup_;
};

}  // namespace

Result<std::unique_ptr<Keyer>> make_luminance_keyer(const KeyerRequest& request) {
  std::optional<int> threshold;
  if (request.parameter) {
    const auto given = threshold_of(request, "luminance", 12);
    if (!given) return forward(given);
    threshold = *given;
  }
  std::optional<BackingField> stage;
  if (!request.samples.empty()) stage = learn_field(request.samples, {}, kBlackStage);
  return std::unique_ptr<Keyer>(
      new LuminanceKeyer(threshold, std::move(stage), request.cleanup.value_or(kDefaultCleanup)));
}

}  // namespace floatstage::matting
