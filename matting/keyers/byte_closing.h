#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

// Private to the stage.
namespace floatstage::matting {

/// A closing of a one-channel picture by a disc, as OpenCV's of its ellipse: every pixel becomes the
/// smallest, around it, of the largest values around. Nothing is added beyond the picture's border. Memory is
/// kept from call to call.
class ByteClosing {
 public:
  /// Makes room for a picture; row(y) is to be filled, `width` bytes each.
  void resize(int width, int height);
  std::uint8_t* row(int y) { return picture_.data() + stride_ * static_cast<std::size_t>(y); }
  const std::uint8_t* row(int y) const { return picture_.data() + stride_ * static_cast<std::size_t>(y); }
  int width() const { return width_; }
  int height() const { return height_; }

  /// Closes it. `radius` px; 0 changes nothing.
  void close(int radius);

 private:
  template <bool kLargest>
  void around(int radius, const std::vector<std::uint8_t>& in, std::vector<std::uint8_t>& out);

  int width_ = 0, height_ = 0;
  std::size_t stride_ = 0;  ///< whole words of 64 pixels
  std::vector<std::uint8_t> picture_, grown_;
  std::vector<std::uint8_t> row_, wide_;
};

}  // namespace floatstage::matting
