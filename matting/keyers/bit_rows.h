#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

// Private to the stage: binary pictures of one bit a pixel, 64 to a word, and what mathematical morphology
// does to them (J. Serra, "Image analysis and mathematical morphology", 1982). Beyond its border a picture
// neither grows what is dilated nor eats at what is eroded, as in OpenCV. Memory is kept from call to call.
namespace floatstage::matting {

/// Pixel x of a row is bit x % 64 of word x / 64; bits beyond the width are 0.
class BitRows {
 public:
  void resize(int width, int height);
  int width() const { return width_; }
  int height() const { return height_; }
  std::size_t words() const { return words_; }  ///< of a row
  std::uint64_t* row(int y) { return bits_.data() + words_ * static_cast<std::size_t>(y); }
  const std::uint64_t* row(int y) const { return bits_.data() + words_ * static_cast<std::size_t>(y); }
  bool at(int x, int y) const { return row(y)[x / 64] >> (x % 64) & 1U; }
  void clear();
  /// Sets bits x0 … x1 - 1 of row y.
  void set(int y, int x0, int x1);
  /// Clears what lies beyond the width of row y.
  void trim(int y);
  std::span<std::uint64_t> all() { return bits_; }
  std::span<const std::uint64_t> all() const { return bits_; }

 private:
  int width_ = 0, height_ = 0;
  std::size_t words_ = 0;
  std::vector<std::uint64_t> bits_;
};

/// Whether any of bits x0 … x1 - 1 of a row is set.
bool any_between(const std::uint64_t* row, int x0, int x1);

/// Rows [y0, y1) and columns [x0, x1).
struct BitBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};
/// What holds all set bits.
BitBox bounding_box(const BitRows& picture);
BitBox grown(const BitBox& box, int by, const BitRows& limits);
/// What holds both.
BitBox joined(const BitBox& a, const BitBox& b);

/// Dilation and erosion. Squares of 2 * radius + 1 pixels, radius at most kMostRadius; discs as OpenCV's
/// ellipse.
class BitMorphology {
 public:
  static constexpr int kMostRadius = 63;
  void dilate(const BitRows& in, int radius, BitRows& out);
  void erode(const BitRows& in, int radius, BitRows& out);
  void erode_disc(const BitRows& in, int radius, BitRows& out);

 private:
  BitRows inverse_, rows_;
  std::vector<std::uint64_t> padded_;
};

/// A run of set bits and the component it belongs to.
struct BitRun {
  int y = 0, x0 = 0, x1 = 0;
  int component = 0;
};
struct BitComponent {
  long area = 0;
  BitBox box;
};

/// The connected components of a picture, found by runs (over sides and, with `corners`, corners).
class BitComponents {
 public:
  /// Of what `picture` has within `box`.
  void find(const BitRows& picture, const BitBox& box, bool corners);
  /// Writes those that share a pixel with `core`, of the picture's size, to `out`, which may be the picture.
  void touching(const BitRows& core, BitRows& out);
  const std::vector<BitRun>& runs() const { return runs_; }
  const std::vector<BitComponent>& components() const { return components_; }

 private:
  int root(int run);
  void connect(int y, int first_above, int first, int end, bool corners);
  std::vector<BitRun> runs_;
  std::vector<int> parents_;
  std::vector<BitComponent> components_;
  std::vector<std::uint8_t> touched_;
};

}  // namespace floatstage::matting
