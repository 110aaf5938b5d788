// Method:  the angle to the cloth's colour in the CbCr
//          plane, with a saturation floor
// Paper:   A. R. Smith, J. F. Blinn, "Blue screen matting", 1996, for the edges (matting/refine_edges.h)
// Differs: saturation is chroma over luma, so that cloth in shadow keeps it
// ADR:     0041, 0043

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "core/text.h"
#include "matting/foreground.h"
#include "matting/keyers/backing.h"
#include "matting/keyers/cloth_kernels.h"
#include "matting/keyers/cloth_measure.h"
#include "matting/keyers/cloth_rows.h"
#include "matting/keyers/keyers.h"
#include "matting/keyers/rim_check.h"
#include "matting/keyers/walls.h"
#include "matting/refine_edges.h"

namespace floatstage::matting {
namespace {

// Lamps, cables and folds on the cloth are islands or thin; people in the picture are not under 3 % of the
// largest.
constexpr CleanupOptions kDefaultCleanup{.thin_radius = 3, .smallest_island = 0.03, .smallest_hole = 0.0003};

class ChromaKeyer : public Keyer {
 public:
  ChromaKeyer(Rgb key_color, const CleanupOptions& cleanup)
      : key_color_(key_color),
        cleanup_(cleanup),
        measure_(key_color),
        rows_(measure_),
        backing_(backing_channel(key_color)) {}

  Result<Matte> key(const Frame& frame) const override {
    if (frame.empty()) return Matte{frame.info, 0, 0, 0, nullptr};
    if (frame.layout.format == PixelFormat::Gray8)
      return fail(ErrorCode::Unsupported, text("camera ", frame.info.camera,
                                               " delivers grey pictures, which have no chroma to key; "
                                               "use the luminance or difference keyer"));
    auto rgb = to_rgb(frame);
    if (!rgb) return forward(rgb);
    Image alpha(rgb->width, rgb->height, 1), doubt(rgb->width, rgb->height, 1);
    key_cloth(*rgb, alpha, doubt);
    const Image cloth = walls_ ? alpha : Image();
    alpha = walls_ ? walls_->key(*rgb, cloth, cleanup_) : clean_up(alpha, cleanup_);
    if (Result<void> ok = check_rim(alpha, frame.info, rows_.sought()); !ok) return forward(ok);
    // Before a wall, what is no cloth is no hair yet.
    if (walls_) doubt_no_wall(cloth, alpha, doubt);
    const Image key = walls_ ? alpha : Image();
    const auto along_the_cloth = [&](int y, int x0, int count, float* out) {
      const std::uint8_t* p = rgb->at(x0, y);
      for (int x = 0; x < count; ++x, p += 3) out[x] = measure_.along.of(p[0], p[1], p[2]);
    };
    refine_edges(along_the_cloth, ClothMeasure::kEdgeContrast, doubt, alpha);
    if (walls_) walls_->solve_edges(*rgb, cloth, key, alpha);
    return make_matte(frame.info, alpha);
  }

  /// Learns what else stands behind the subject, where the rims show enough of it.
  void learn_walls(const std::vector<Image>& samples) {
    std::vector<Image> cloth;
    for (const Image& sample : samples) {
      Image alpha(sample.width, sample.height, 1), doubt(sample.width, sample.height, 1);
      key_cloth(sample, alpha, doubt);
      cloth.push_back(std::move(alpha));
    }
    walls_ = Walls::learn(samples, cloth);
  }

  Result<void> suppress_spill(const Frame& frame, Image& rgb) const override {
    if (Result<void> ok = to_rgb(frame, rgb); !ok) return ok;
    despill(rgb, backing_);
    return {};
  }

  std::string spec() const override {
    constexpr const char* digits = "0123456789abcdef";
    std::string out = "chroma:#";
    for (const int byte : {key_color_.r, key_color_.g, key_color_.b})
      out += {digits[byte >> 4], digits[byte & 15]};
    return out;
  }
  CleanupOptions cleanup() const override { return cleanup_; }
  const RowMeasure* rows() const override { return walls_ ? nullptr : &rows_; }

 private:
  void key_cloth(const Image& rgb, Image& alpha, Image& doubt) const {
    const ClothKernels& kernels = cloth_kernels();
    const std::size_t count = static_cast<std::size_t>(rgb.width), room = padded(count);
    std::vector<std::uint8_t> rows(5 * room);
    std::uint8_t *r = rows.data(), *g = r + room, *b = g + room, *opacity = b + room,
                 *doubtful = opacity + room;
    for (int y = 0; y < rgb.height; ++y) {
      kernels.split(rgb.at(0, y), count, r, g, b);
      kernels.alphas(measure_, r, g, b, room, opacity, doubtful);
      std::copy_n(opacity, count, alpha.at(0, y));
      std::copy_n(doubtful, count, doubt.at(0, y));
    }
  }

  static void doubt_no_wall(const Image& cloth, const Image& key, Image& doubt) {
    const std::uint8_t *c = cloth.pixels.data(), *k = key.pixels.data();
    std::uint8_t* out = doubt.pixels.data();
    for (std::size_t i = 0, count = doubt.pixels.size(); i < count; ++i)
      out[i] = c[i] >= 128 && k[i] < 128 ? std::uint8_t{0} : out[i];
  }

  Rgb key_color_;
  CleanupOptions cleanup_;
  ClothMeasure measure_;
  ClothRows rows_;
  BackingChannel backing_;
  std::optional<Walls> walls_;  // what is no cloth at the rims
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
  return Rgb{static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
             static_cast<std::uint8_t>(value)};
}

}  // namespace

Result<std::unique_ptr<Keyer>> make_chroma_keyer(const KeyerRequest& request) {
  Rgb color;
  if (request.parameter) {
    const auto parsed = parse_color(*request.parameter);
    if (!parsed) return forward(parsed);
    color = *parsed;
    if (chroma_of(color).length() < 0.1f * chroma_of(color).luma + 5)
      return fail(ErrorCode::InvalidArgument,
                  text("'chroma:", *request.parameter, "' is too grey to key on; use the luminance keyer"));
  } else {
    if (request.samples.empty())
      return fail(ErrorCode::InvalidArgument,
                  "the chroma keyer has no picture to sample the cloth's colour from; give chroma:#rrggbb");
    const auto sampled = sample_backing(request.samples);
    if (!sampled)
      return fail(ErrorCode::NotFound,
                  "no green or blue cloth at the borders of the pictures; give its colour as chroma:#rrggbb");
    color = *sampled;
  }
  auto keyer = std::make_unique<ChromaKeyer>(color, request.cleanup.value_or(kDefaultCleanup));
  keyer->learn_walls(request.samples);
  return std::unique_ptr<Keyer>(std::move(keyer));
}

}  // namespace floatstage::matting
