// Method:  how far a pixel is from what light alone makes of a plate's
// Paper:   T. Horprasert, D. Harwood, L. Davis, "A statistical approach for real-time robust background
// subtraction and
//          shadow detection", 1999, eq. 5-6
// Differs: both distortions as one distance

#include "matting/keyers/plate_measure.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/check.h"
#include "matting/keyers/alpha_bits.h"
#include "matting/keyers/plate_kernels.h"
#include "matting/keyers/row_kernels.h"
#include "matting/refine_edges.h"

namespace floatstage::matting {
namespace {

constexpr float kDarkerThanSeen = 0.95F;  // of what a shade's means leave: noise, and light that is scattered

using Share = std::array<float, 3>;

// Whether shade falls in a row or in one beside it.
bool is_any_near(const CastShade& shade, int row) {
  const auto width = static_cast<std::size_t>(shade.width);
  for (int v = std::max(0, row - 1); v <= std::min(shade.height - 1, row + 1); ++v)
    if (std::memchr(shade.mask.data() + static_cast<std::size_t>(v) * width, 255, width) != nullptr)
      return true;
  return false;
}

// What shade leaves of the plate around its pixel (x, y), the least; absent where none falls. At the rim of a
// shadow its pixels show less of it than there is inside.
std::optional<Share> left_around(const CastShade& shade, int x, int y) {
  std::optional<Share> least;
  for (int v = std::max(0, y - 1); v <= std::min(shade.height - 1, y + 1); ++v)
    for (int u = std::max(0, x - 1); u <= std::min(shade.width - 1, x + 1); ++u) {
      const std::size_t p =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(shade.width) + static_cast<std::size_t>(u);
      if (shade.mask[p] == 0) continue;
      if (!least) least = shade.left[p];
      for (std::size_t c = 0; c < 3; ++c) (*least)[c] = std::min((*least)[c], shade.left[p][c]);
    }
  return least;
}

// The square of how far a pixel is from the colours between the plate's and the plate's in that light.
float off_shade(const std::uint8_t* p, const std::uint8_t* plate, const Share& left) {
  float taken[3], along = 0, square = 1e-3F, apart = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    taken[c] = static_cast<float>(plate[c]) * (1 - kDarkerThanSeen * left[c]);
    along += taken[c] * static_cast<float>(plate[c] - p[c]);
    square += taken[c] * taken[c];
  }
  const float share = std::clamp(along / square, 0.0F, 1.0F);
  for (std::size_t c = 0; c < 3; ++c) {
    const float off = static_cast<float>(plate[c]) - share * taken[c] - static_cast<float>(p[c]);
    apart += off * off;
  }
  return apart;
}

}  // namespace

PlateDistance plate_distance(const std::uint8_t* p, const std::uint8_t* b, const PlateLight& light) {
  const float pr = p[0], pg = p[1], pb = p[2], br = b[0], bg = b[1], bb = b[2];
  const float bright = std::clamp((pr * br + pg * bg + pb * bb) / (br * br + bg * bg + bb * bb + 1e-3f),
                                  light.darkest, light.brightest);
  const float dr = pr - bright * br, dg = pg - bright * bg, db = pb - bright * bb;
  return {std::sqrt(dr * dr + dg * dg + db * db), bright};
}

void PlateMeasure::light(const PixelRows& rgb, const CastShade& shade) {
  for (const Lit& l : lit_) std::copy_n(l.learnt.data(), 3, color_.pixels.data() + 3 * l.pixel);
  lit_.clear();
  if (!shade.any()) return;
  for (int v = 0; v < shade.height; ++v) {
    if (!is_any_near(shade, v)) continue;
    for (int u = 0; u < shade.width; ++u)
      if (const std::optional<Share> left = left_around(shade, u, v))
        light(rgb, *left, {u * color_.width / shade.width, v * color_.height / shade.height},
              {(u + 1) * color_.width / shade.width, (v + 1) * color_.height / shade.height});
  }
}

void PlateMeasure::light(const PixelRows& rgb, const std::array<float, 3>& left,
                         const std::array<int, 2>& from, const std::array<int, 2>& to) {
  for (int y = from[1]; y < to[1]; ++y)
    for (int x = from[0]; x < to[0]; ++x) {
      std::uint8_t* plate = color_.at(x, y);
      const std::uint8_t* p = rgb.at(x, y);
      const float threshold = *thresholds_at(x, y);
      if (off_shade(p, plate, left) >= threshold * threshold) continue;
      const auto pixel = static_cast<std::size_t>(plate - color_.pixels.data()) / 3;
      lit_.push_back({pixel, {plate[0], plate[1], plate[2]}});
      std::copy_n(p, 3, plate);
    }
}

Image PlateMeasure::key(const Image& rgb, const CleanupOptions& cleanup) const {
  FLOATSTAGE_CHECK(fits(rgb.width, rgb.height), "a picture of another size than its plate");
  Image alpha(rgb.width, rgb.height, 1);
  for (int y = 0; y < rgb.height; ++y) opacities(rgb.at(0, y), 0, y, rgb.width, alpha.at(0, y));
  alpha = clean_up(alpha, cleanup);
  // Of a mixed pixel C = a F + (1 - a) B the distance to B is a |F - B|: linear in a, as refine_edges() wants
  // it.
  const auto distance = [&](int y, int x0, int count, float* out) {
    distances(rgb.at(x0, y), x0, y, count, out);
  };
  refine_edges(distance, contrast_, Image(alpha.width, alpha.height, 1), alpha);
  return alpha;
}

void PlateMeasure::classify(const std::uint8_t* rgb, int y, int width, std::vector<std::uint8_t>& scratch,
                            std::uint64_t* subject, std::uint64_t* faint, std::uint64_t* doubt) const {
  const std::size_t count = static_cast<std::size_t>(width);
  if (scratch.size() < padded(count)) scratch.resize(padded(count));
  opacities(rgb, 0, y, width, scratch.data());
  bits_of_row(scratch.data(), width, kSubjectAlpha, subject);
  bits_of_row(scratch.data(), width, kFaintAlpha, faint);
  std::fill_n(doubt, padded(count) / 64, 0);
}

void PlateMeasure::opacities(const std::uint8_t* rgb, int x, int y, int count, std::uint8_t* out) const {
  plate_kernels().alphas(rgb, color_.at(x, y), thresholds_at(x, y), static_cast<std::size_t>(count),
                         light_.darkest, light_.brightest, out);
}

float PlateMeasure::at(const std::uint8_t* rgb, int x, int y) const {
  return *thresholds_at(x, y) == 0 ? unknown_ : plate_distance(rgb, color_.at(x, y), light_).length;
}

void PlateMeasure::distances(const std::uint8_t* rgb, int x, int y, int count, float* out) const {
  plate_kernels().lengths(rgb, color_.at(x, y), static_cast<std::size_t>(count), light_.darkest,
                          light_.brightest, out);
  const float* thresholds = thresholds_at(x, y);
  for (int i = 0; i < count; ++i)
    if (thresholds[i] == 0) out[i] = unknown_;
}

void PlateMeasure::quantize(const std::uint8_t* rgb, int x, int y, int count,
                            std::vector<std::uint8_t>& scratch, std::int32_t* out) const {
  const std::size_t room = padded(static_cast<std::size_t>(count)), bytes = room * sizeof(float);
  if (scratch.size() < bytes) scratch.resize(bytes);
  auto* row = reinterpret_cast<float*>(scratch.data());
  distances(rgb, x, y, count, row);
  row_kernels().quantize(row, room, kQuantum, out);
}

}  // namespace floatstage::matting
