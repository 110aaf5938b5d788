#include "capture/v4l2/jpeg.h"

#include <vector>

#include <gtest/gtest.h>
#include <turbojpeg.h>

#include "tests/support/matchers.h"

namespace floatstage {
namespace {

Image gradient(int width, int height) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = static_cast<std::uint8_t>(x * 3 + y * 2 + c * 40);
  return image;
}

std::vector<std::byte> encoded(const Image& image) {
  void* handle = tjInitCompress();
  unsigned char* jpeg = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(tjCompress2(handle, image.pixels.data(), image.width, 0, image.height, TJPF_RGB, &jpeg, &size,
                        TJSAMP_444, 95, 0),
            0);
  const auto* bytes = reinterpret_cast<const std::byte*>(jpeg);
  std::vector<std::byte> result(bytes, bytes + size);
  tjFree(jpeg);
  tjDestroy(handle);
  return result;
}

TEST(DecodeJpeg, ReadsAPictureInItsColours) {
  const Image image = gradient(40, 24);
  EXPECT_THAT(decode_jpeg(encoded(image), 40, 24), IsOkAnd(ImageNear(image, 35.0)));
}

TEST(DecodeJpeg, RefusesAnotherSizeThanAnnounced) {
  EXPECT_THAT(decode_jpeg(encoded(gradient(40, 24)), 64, 48),
              FailsWith(ErrorCode::BadData, "a JPEG of 40x24 where 64x48 was announced"));
}

TEST(DecodeJpeg, TakesNoTruncationForAPicture) {
  const std::vector<std::byte> whole = encoded(gradient(40, 24));
  for (std::size_t cut = 0; cut + 2 < whole.size(); cut += 3)
    EXPECT_THAT(decode_jpeg(std::span(whole).first(cut), 40, 24), FailsWith(ErrorCode::BadData, "JPEG"))
        << cut;
  EXPECT_THAT(decode_jpeg(whole, 40, 24), IsOk()) << "and goes on afterwards";
}

}  // namespace
}  // namespace floatstage
