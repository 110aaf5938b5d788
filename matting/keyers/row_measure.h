#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

// Private to the stage.
namespace floatstage::matting {

/// RGB pixels, wherever they are.
struct PixelRows {
  const std::uint8_t* first = nullptr;
  std::size_t stride = 0;
  const std::uint8_t* at(int x, int y) const {
    return first + stride * static_cast<std::size_t>(y) + 3 * static_cast<std::size_t>(x);
  }
};

/// Opacities from which clean_up() takes a pixel for subject, and for what may hang together with it.
constexpr std::uint8_t kSubjectAlpha = 128, kFaintAlpha = 24;

/// What a keyer says of single pixels, by rows: the arithmetic of its key() before anything looks at a
/// pixel's neighbours, from which LiveKey (live_key.h) makes the same matte on bits. Pictures are RGB;
/// `rgb` points at the pixel that is spoken of, or at the first of some in a row. Bits are pixel x % 64 of
/// word x / 64; what lies beyond a row's width says nothing. `scratch` is memory of the caller's, used again.
/// Immutable; thread safe.
class RowMeasure {
 public:
  static constexpr float kQuantum = 64;  ///< of quantize(), steps a unit of the linear measure

  virtual ~RowMeasure() = default;
  /// Whether it can speak of pictures of this size.
  virtual bool fits(int width, int height) const = 0;
  /// Of the whole of row y: where the raw key is at least 128 (subject) and at least 24 (faint), and where
  /// refine_edges() is to look for hair (doubt).
  virtual void classify(const std::uint8_t* rgb, int y, int width, std::vector<std::uint8_t>& scratch,
                        std::uint64_t* subject, std::uint64_t* faint, std::uint64_t* doubt) const = 0;
  /// The raw key of pixels x … x + count - 1 of row y.
  virtual void opacities(const std::uint8_t* rgb, int x, int y, int count, std::uint8_t* out) const = 0;
  /// The measure that is linear in the subject's share (matting/refine_edges.h) of one pixel.
  virtual float at(const std::uint8_t* rgb, int x, int y) const = 0;
  /// The same of pixels x … x + count - 1 in steps of 1 / kQuantum, rounded to the nearest. `out` has room
  /// for padded(count).
  virtual void quantize(const std::uint8_t* rgb, int x, int y, int count, std::vector<std::uint8_t>& scratch,
                        std::int32_t* out) const = 0;
  /// Edges keep their key where the measure tells subject from backing by less than this.
  virtual float contrast() const = 0;
  /// What check_rim() (rim_check.h) is to ask of the picture's rim; empty: nothing.
  virtual std::string_view sought() const { return {}; }
};

/// Pixels of a row for which kernels want room.
constexpr std::size_t padded(std::size_t count) { return (count + 63) / 64 * 64; }

}  // namespace floatstage::matting
