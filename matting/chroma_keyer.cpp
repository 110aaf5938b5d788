#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/text.h"
#include "matting/backing.h"
#include "matting/keyers.h"

namespace floatstage {
namespace {

// Lamps, cables and folds on the cloth are islands or thin; people in the picture are not under 3 % of the largest.
constexpr CleanupOptions kDefaultCleanup{.close_radius = 1, .thin_radius = 3, .smallest_island = 0.03, .smallest_hole = 0.0005};

// Thresholds of the cloth's saturation along its own direction in the CbCr plane, as shares of the key colour's.
constexpr float kSubjectBelow = 0.15f;  // all subject
constexpr float kClothAbove = 0.5f;     // all cloth
constexpr float kAngleSlope = 0.2f;     // what a step across the direction costs of a step along it
constexpr float kDarkFloor = 2.0f;      // 8-bit steps of luma that keep black from having any saturation

struct Chroma {
  float y, cb, cr;
};

// BT.601, full range, CbCr around 0.
Chroma to_chroma(float r, float g, float b) {
  const float y = 0.299f * r + 0.587f * g + 0.114f * b;
  return {y, 0.564f * (b - y), 0.713f * (r - y)};
}

class ChromaKeyer : public Keyer {
 public:
  ChromaKeyer(Rgb key_color, const CleanupOptions& cleanup) : key_color_(key_color), cleanup_(cleanup) {
    const Chroma c = to_chroma(key_color.r, key_color.g, key_color.b);
    const float length = std::hypot(c.cb, c.cr);
    u_ = c.cb / length;
    v_ = c.cr / length;
    saturation_ = length / (c.y + kDarkFloor);
    const std::array<std::uint8_t, 3> rgb = {key_color.r, key_color.g, key_color.b};
    backing_channel_ = static_cast<int>(std::max_element(rgb.begin(), rgb.end()) - rgb.begin());
  }

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty()) return Matte{frame.info, 0, 0, 0, nullptr};
    if (frame.layout.format == PixelFormat::Gray8)
      return fail(ErrorCode::Unsupported, text("camera ", frame.info.camera, " delivers grey pictures, which have no chroma to key; "
                                               "use the luminance or difference keyer"));
    auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    Image alpha(rgb->width, rgb->height, 1);
    for (std::size_t i = 0; i < alpha.pixels.size(); ++i) alpha.pixels[i] = opacity(rgb->pixels.data() + 3 * i);
    return make_matte(frame.info, clean_up(alpha, cleanup_));
  }

  Result<Image> suppress_spill(const Frame& frame) const override {
    auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    // Light from the cloth only adds to the backing's channel. Limiting it to the larger of the other two leaves
    // every colour alone in which it does not lead.
    const int k = backing_channel_, i = (k + 1) % 3, j = (k + 2) % 3;
    for (std::uint8_t* p = rgb->pixels.data(); p != rgb->pixels.data() + rgb->pixels.size(); p += 3)
      p[k] = std::min(p[k], std::max(p[i], p[j]));
    return rgb;
  }

  std::string spec() const override {
    constexpr const char* digits = "0123456789abcdef";
    std::string out = "chroma:#";
    for (const int byte : {key_color_.r, key_color_.g, key_color_.b}) out += {digits[byte >> 4], digits[byte & 15]};
    return out;
  }

 private:
  // Saturation is chroma over luma: cloth in shadow keeps it. The angle to the cloth enters as the ratio of the
  // components across and along its direction, so that no pixel needs trigonometry.
  std::uint8_t opacity(const std::uint8_t* p) const {
    const Chroma c = to_chroma(p[0], p[1], p[2]);
    const float along = c.cb * u_ + c.cr * v_;
    const float across = std::abs(c.cr * u_ - c.cb * v_);
    const float cloth = (along - kAngleSlope * across) / ((c.y + kDarkFloor) * saturation_);
    const float alpha = (kClothAbove - cloth) * (255 / (kClothAbove - kSubjectBelow));
    return static_cast<std::uint8_t>(std::clamp(alpha + 0.5f, 0.0f, 255.0f));
  }

  Rgb key_color_;
  CleanupOptions cleanup_;
  float u_ = 0, v_ = 0;       // the cloth's direction in the CbCr plane
  float saturation_ = 0;      // the cloth's chroma over luma
  int backing_channel_ = 1;  // of RGB
};

Result<Rgb> parse_color(std::string_view text_color) {
  unsigned value = 0;
  bool good = text_color.size() == 7 && text_color[0] == '#';
  if (good) {
    const char* last = text_color.data() + text_color.size();
    const auto [end, error] = std::from_chars(text_color.data() + 1, last, value, 16);
    good = error == std::errc() && end == last;
  }
  if (!good)
    return fail(ErrorCode::InvalidArgument,
                text("'chroma:", text_color, "': the cloth's colour must look like chroma:#1f7a3c"));
  return Rgb{static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value)};
}

}  // namespace

Result<std::unique_ptr<Keyer>> make_chroma_keyer(const KeyerRequest& request) {
  Rgb color;
  if (request.parameter) {
    const auto parsed = parse_color(*request.parameter);
    if (!parsed) return forward(parsed);
    color = *parsed;
    const Chroma c = to_chroma(color.r, color.g, color.b);
    if (std::hypot(c.cb, c.cr) < 0.1f * c.y + 5)
      return fail(ErrorCode::InvalidArgument, text("'chroma:", *request.parameter, "' is too grey to key on; use the luminance keyer"));
  } else {
    if (request.samples.empty())
      return fail(ErrorCode::InvalidArgument, "the chroma keyer has no picture to sample the cloth's colour from; give chroma:#rrggbb");
    const auto sampled = sample_backing(request.samples);
    if (!sampled)
      return fail(ErrorCode::NotFound, "no green or blue cloth at the borders of the pictures; give its colour as chroma:#rrggbb");
    color = *sampled;
  }
  return std::unique_ptr<Keyer>(new ChromaKeyer(color, request.cleanup.value_or(kDefaultCleanup)));
}

}  // namespace floatstage
