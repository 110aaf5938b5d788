#include "core/jpeg.h"

#include <gtest/gtest.h>

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

std::span<const std::byte> bytes_of(const std::string& jpeg) { return std::as_bytes(std::span(jpeg)); }

TEST(DecodeJpeg, ReadsAPictureInItsColours) {
  const Image image = gradient(40, 24);
  EXPECT_THAT(decode_jpeg(bytes_of(encode_jpeg(image, 95)), 40, 24), IsOkAnd(ImageNear(image, 35.0)));
}

TEST(DecodeJpeg, RefusesAnotherSizeThanAnnounced) {
  const std::string jpeg = encode_jpeg(gradient(40, 24), 95);
  EXPECT_THAT(decode_jpeg(bytes_of(jpeg), 64, 48),
              FailsWith(ErrorCode::BadData, "a JPEG of 40x24 where 64x48 was announced"));
}

TEST(DecodeJpeg, TakesNoTruncationForAPicture) {
  const std::string whole = encode_jpeg(gradient(40, 24), 95);
  for (std::size_t cut = 0; cut + 2 < whole.size(); cut += 3)
    EXPECT_THAT(decode_jpeg(bytes_of(whole).first(cut), 40, 24), FailsWith(ErrorCode::BadData, "JPEG"))
        << cut;
  EXPECT_THAT(decode_jpeg(bytes_of(whole), 40, 24), IsOk()) << "and goes on afterwards";
}

TEST(EncodeJpeg, SpendsFewerBytesForLessQuality) {
  const Image image = gradient(40, 24);
  EXPECT_LT(encode_jpeg(image, 50).size(), encode_jpeg(image, 95).size());
}

TEST(EncodeJpeg, KeepsTheColourOfASinglePixel) {
  Image image(17, 9, 3, 30);
  image.at(8, 4)[0] = 250;
  const std::string jpeg = encode_jpeg(image, 95);
  const Result<Image> again = decode_jpeg(bytes_of(jpeg), 17, 9);
  ASSERT_THAT(again, IsOk());
  EXPECT_NEAR(again->at(8, 4)[0], 250, 25);
  EXPECT_NEAR(again->at(8, 4)[1], 30, 25);
}

}  // namespace
}  // namespace floatstage
