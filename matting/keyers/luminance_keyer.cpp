// Method:  what differs from the black and the lit cloth that the rim shows (matting/keyers/backing_field.h)
// ADR:     0170

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/text.h"
#include "matting/keyers/alpha_bits.h"
#include "matting/keyers/backing_field.h"
#include "matting/keyers/cloth_measure.h"
#include "matting/keyers/keyers.h"
#include "matting/keyers/rim_check.h"

namespace floatstage::matting {
namespace {

// A black stage leaves dark crevices in the subject and specks on the cloth.
constexpr CleanupOptions kDefaultCleanup{.close_radius = 2, .smallest_island = 0.02, .smallest_hole = 0.003};
constexpr double kBrighter = 2;        // times the backing, in the mean
constexpr double kOtherBacking = 0.1;  // of the rim or of the subject: there is cloth, as walls.cpp has it
constexpr FieldOptions kBlackStage{.darker_too = true};

int grey_of(const std::uint8_t* p) { return (77 * p[0] + 150 * p[1] + 29 * p[2] + 128) >> 8; }  // BT.601

// Against a stage, the subject is the light: on any other backing as much is darker as is brighter.
bool is_black(const BackingField& stage, const Image& rgb, const Image& alpha) {
  const BitBox box = bounding_box(alpha);
  BitRows subject;
  bits_of(alpha, box, 128, subject);
  long sum = 0, count = 0;
  for (int y = 0; y < subject.height(); ++y)
    for_each_bit(subject, y, [&](int x) {
      sum += grey_of(rgb.at(box.x0 + x, box.y0 + y));
      ++count;
    });
  return count == 0 || stage.grey() * kBrighter <= static_cast<double>(sum) / static_cast<double>(count);
}

// What of a picture has the colour of the cloth beyond doubt, as shares of the subject and of the rim.
struct ClothShares {
  double subject = 0, rim = 0;
};

ClothShares cloth_shares(const ClothMeasure& cloth, const Image& rgb, const Image& alpha) {
  const int rim = rim_width(rgb.width, rgb.height);
  long subject = 0, subject_cloth = 0, seen = 0, seen_cloth = 0;
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x) {
      const std::uint8_t* p = rgb.at(x, y);
      const bool is = cloth.value(p[0], p[1], p[2]) <= cloth.doubtful;
      const bool at_rim = y < rim || y >= rgb.height - rim || x < rim || x >= rgb.width - rim;
      seen += at_rim, seen_cloth += at_rim && is;
      const bool inside = *alpha.at(x, y) >= 128;
      subject += inside, subject_cloth += inside && is;
    }
  const auto share = [](long part, long of) {
    return of ? static_cast<double>(part) / static_cast<double>(of) : 0.0;
  };
  return {share(subject_cloth, subject), share(seen_cloth, seen)};
}

class LuminanceKeyer : public Keyer {
 public:
  /// `stage`: absent, every frame's own. `cloth`: green or blue cloth at the pictures' borders, if any.
  LuminanceKeyer(std::optional<int> threshold, std::optional<BackingField> stage,
                 const std::optional<Rgb>& cloth, const CleanupOptions& cleanup)
      : threshold_(threshold), stage_(std::move(stage)), cleanup_(cleanup) {
    if (cloth) cloth_.emplace(*cloth);
  }

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty()) return Matte{frame.info, 0, 0, 0, nullptr};
    auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    const std::optional<BackingField> own =
        stage_ || threshold_ ? std::nullopt : learn_field({*rgb}, {}, kBlackStage);
    const BackingField* stage = stage_ ? &*stage_ : own ? &*own : nullptr;
    Image alpha = stage ? stage->key(*rgb) : Image(rgb->width, rgb->height, 1, 255);
    if (threshold_) {
      // A ramp from half the threshold to one and a half: 128 and above exactly where grey > threshold.
      for (std::size_t i = 0; i < alpha.pixels.size(); ++i) {
        const int ramp = std::clamp(
            (2 * grey_of(rgb->pixels.data() + 3 * i) - *threshold_) * 255 / (2 * *threshold_), 0, 255);
        alpha.pixels[i] = std::min(alpha.pixels[i], static_cast<std::uint8_t>(ramp));
      }
    }
    alpha = clean_up(alpha, cleanup_);
    if (Result<void> ok = check_rim(alpha, frame.info, "black stage"); !ok) return forward(ok);
    if (stage && !is_black(*stage, *rgb, alpha))
      return fail(ErrorCode::Unsupported,
                  text("camera ", frame.info.camera, " shows no black stage: what is around the subject is ",
                       std::lround(stage->grey()),
                       " bright in the mean, more than half of what stands out from it; "
                       "try the methods 'chroma' or 'consistent', or a plate"));
    if (Result<void> ok = check_cloth(*rgb, alpha, frame.info); !ok) return forward(ok);
    if (stage && !threshold_) stage->solve_edges(*rgb, alpha);
    return make_matte(frame.info, alpha);
  }

  Result<void> suppress_spill(const Frame& frame, Image& rgb) const override { return to_rgb(frame, rgb); }
  std::string spec() const override {
    return threshold_ ? text("luminance:", *threshold_) : std::string("luminance");
  }
  CleanupOptions cleanup() const override { return cleanup_; }

 private:
  // Before cloth, brightness tells no subject: it takes the cloth for one, or, where the cloth is a part of
  // what is around, the subject for cloth.
  Result<void> check_cloth(const Image& rgb, const Image& alpha, const FrameInfo& info) const {
    if (!cloth_) return {};
    const ClothShares share = cloth_shares(*cloth_, rgb, alpha);
    const bool mixed = std::min(share.rim, 1 - share.rim) > kOtherBacking;
    if (!mixed && share.subject <= kOtherBacking) return {};
    return fail(ErrorCode::Unsupported,
                text("camera ", info.camera, " shows no black stage: ",
                     mixed ? text("green or blue cloth covers ", std::lround(100 * share.rim),
                                  " % of its picture's rim")
                           : text(std::lround(100 * share.subject),
                                  " % of what stands out has the colour of the cloth at its picture's rim"),
                     "; try the method 'chroma', or a plate"));
  }

  std::optional<int> threshold_;
  std::optional<BackingField> stage_;
  std::optional<ClothMeasure> cloth_;
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
  std::optional<Rgb> cloth;
  if (!request.samples.empty()) {
    stage = learn_field(request.samples, {}, kBlackStage);
    if (!threshold) cloth = sample_backing(request.samples);
  }
  return std::unique_ptr<Keyer>(
      new LuminanceKeyer(threshold, std::move(stage), cloth, request.cleanup.value_or(kDefaultCleanup)));
}

}  // namespace floatstage::matting
