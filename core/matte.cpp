#include "core/matte.h"

#include <cstring>

#include "core/text.h"

namespace floatstage {

Matte make_matte(FrameInfo source, const Image& alpha) {
  FLOATSTAGE_CHECK(alpha.channels == 1, text("a matte of ", alpha.channels, " channels"));
  auto bytes = std::make_shared<std::uint8_t[]>(alpha.pixels.size());
  std::memcpy(bytes.get(), alpha.pixels.data(), alpha.pixels.size());
  return {source, alpha.width, alpha.height, static_cast<std::size_t>(alpha.width), std::move(bytes)};
}

Image to_image(const Matte& matte) {
  if (matte.empty()) return {};
  Image image(matte.width, matte.height, 1);
  for (int y = 0; y < matte.height; ++y)
    std::memcpy(image.at(0, y), matte.row(y), static_cast<std::size_t>(matte.width));
  return image;
}

double coverage(const Matte& matte) {
  if (matte.empty()) return 0;
  std::size_t subject = 0;
  for (int y = 0; y < matte.height; ++y) {
    const std::uint8_t* const row = matte.row(y);
    unsigned in_row = 0;
    for (int x = 0; x < matte.width; ++x) in_row += row[x] >> 7;
    subject += in_row;
  }
  return static_cast<double>(subject) / (static_cast<double>(matte.width) * matte.height);
}

double iou(const Matte& a, const Matte& b) {
  FLOATSTAGE_CHECK(a.width == b.width && a.height == b.height, "IoU of mattes of different sizes");
  std::size_t both = 0, either = 0;
  for (int y = 0; y < a.height; ++y) {
    const std::uint8_t *const row_a = a.row(y), *const row_b = b.row(y);
    unsigned both_in_row = 0, either_in_row = 0;
    for (int x = 0; x < a.width; ++x) {
      both_in_row += (row_a[x] & row_b[x]) >> 7;
      either_in_row += (row_a[x] | row_b[x]) >> 7;
    }
    both += both_in_row;
    either += either_in_row;
  }
  return either == 0 ? 1.0 : static_cast<double>(both) / static_cast<double>(either);
}

}  // namespace floatstage
