// Photographs as cameras, scanners and accidents leave them.

#include "detail/photo_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tiffio.h>
#include <turbojpeg.h>

#include "core/file.h"
#include "core/jpeg.h"
#include "core/png.h"
#include "detail/exif_orientation.h"
#include "tests/detail/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::detail {
namespace {

// 60 x 40: red at the left, more green further down.
Image sample_picture() {
  Image image(60, 40, 3);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x) {
      image.at(x, y)[0] = static_cast<std::uint8_t>(250 - 4 * x);
      image.at(x, y)[1] = static_cast<std::uint8_t>(6 * y);
      image.at(x, y)[2] = 30;
    }
  return image;
}

std::string exif(int orientation, bool little) {
  std::string tiff = little ? std::string("II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0", 18)
                            : std::string("MM\0*\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01", 18);
  tiff += little ? std::string{static_cast<char>(orientation), 0, 0, 0}
                 : std::string{0, static_cast<char>(orientation), 0, 0};
  return tiff + std::string(4, '\0');
}

std::string with_exif(const std::string& jpeg, const std::string& tiff) {
  const std::size_t length = tiff.size() + 8;
  return jpeg.substr(0, 2) + "\xFF\xE1" + static_cast<char>(length >> 8) + static_cast<char>(length & 255) +
         std::string("Exif\0\0", 6) + tiff + jpeg.substr(2);
}

TEST(Photographs, AreTurnedAsTheirExifSays) {
  const Image upright_one = sample_picture();
  // What a camera held otherwise stores, so that the viewer turns it back.
  const int inverse[] = {0, 1, 2, 3, 4, 5, 8, 7, 6};
  for (int orientation = 1; orientation <= 8; ++orientation)
    for (const bool little : {true, false}) {
      const Image stored = upright(upright_one, inverse[orientation]);
      const Result<Image> read =
          decode_photo(with_exif(encode_jpeg(stored, 98), exif(orientation, little)), "turned.jpg");
      EXPECT_THAT(read, IsOkAnd(ImageNear(upright_one, 40))) << orientation;
    }
}

TEST(Photographs, WithARemarkThatMakesNoSenseAreReadAsTheyAre) {
  const Image picture = sample_picture();
  const std::string jpeg = encode_jpeg(picture, 98), good = exif(6, true);
  EXPECT_EQ(exif_orientation(with_exif(jpeg, exif(9, true))), 1);
  for (std::size_t cut = 0; cut < good.size() - 4; ++cut)
    EXPECT_THAT(decode_photo(with_exif(jpeg, good.substr(0, cut)), "cut.jpg"), IsOk()) << cut;
  std::string far = good;
  far[4] = far[5] = far[6] = far[7] = '\xFF';
  EXPECT_EQ(exif_orientation(with_exif(jpeg, far)), 1);
}

std::string cmyk_jpeg(const Image& rgb) {
  std::vector<std::uint8_t> inks;  // 255 is none, black unused
  for (std::size_t i = 0; i < rgb.pixels.size(); i += 3)
    inks.insert(inks.end(), {rgb.pixels[i], rgb.pixels[i + 1], rgb.pixels[i + 2], 255});
  const tjhandle handle = tjInitCompress();
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  EXPECT_EQ(
      tjCompress2(handle, inks.data(), rgb.width, 0, rgb.height, TJPF_CMYK, &bytes, &size, TJSAMP_444, 98, 0),
      0);
  std::string out(reinterpret_cast<char*>(bytes), size);
  tjFree(bytes);
  tjDestroy(handle);
  return out;
}

TEST(Photographs, OfAPrintShopAreRead) {
  EXPECT_THAT(decode_photo(cmyk_jpeg(sample_picture()), "cmyk.jpg"),
              IsOkAnd(ImageNear(sample_picture(), 38)));
}

TEST(Photographs, InGreyWithOpacityOrSixteenBitsAreRead) {
  const TempFolder folder;
  const Image picture = sample_picture();
  ASSERT_THAT(save_png16(picture, folder / "deep.png"), IsOk());
  EXPECT_THAT(load_photo(folder / "deep.png"), IsOkAnd(picture));
  Image grey(8, 4, 1, 90), clear(8, 4, 4, 90);
  ASSERT_THAT(save_png(grey, folder / "grey.png"), IsOk());
  ASSERT_THAT(save_png(clear, folder / "clear.png"), IsOk());
  EXPECT_THAT(load_photo(folder / "grey.png"), IsOkAnd(Image(8, 4, 3, 90)));
  EXPECT_THAT(load_photo(folder / "clear.png"), IsOkAnd(Image(8, 4, 3, 90)));
}

void save_tiff(const Image& rgb, const std::filesystem::path& file, int bits, int orientation) {
  TIFF* tiff = TIFFOpen(file.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, rgb.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, rgb.height);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 8);
  TIFFSetField(tiff, TIFFTAG_ORIENTATION, orientation);
  for (int y = 0; y < rgb.height; ++y) {
    std::vector<std::uint16_t> deep;
    for (int i = 0; i < 3 * rgb.width; ++i) deep.push_back(static_cast<std::uint16_t>(rgb.at(0, y)[i] * 257));
    std::vector<std::uint8_t> row(rgb.at(0, y), rgb.at(0, y) + 3 * static_cast<std::ptrdiff_t>(rgb.width));
    void* data = bits == 16 ? static_cast<void*>(deep.data()) : row.data();
    TIFFWriteScanline(tiff, data, static_cast<std::uint32_t>(y), 0);
  }
  TIFFClose(tiff);
}

TEST(Photographs, AsTiffAreReadAtAnyDepthAndTurn) {
  const TempFolder folder;
  const Image picture = sample_picture();
  save_tiff(picture, folder / "flat.tif", 8, 1);
  save_tiff(picture, folder / "deep.tif", 16, 1);
  save_tiff(upright(picture, 8), folder / "turned.tif", 8, 6);
  save_tiff(upright(picture, 3), folder / "head-down.tif", 8, 3);
  for (const char* name : {"flat.tif", "deep.tif", "turned.tif", "head-down.tif"})
    EXPECT_THAT(load_photo(folder / name), IsOkAnd(ImageNear(picture, 47))) << name;
}

TEST(Photographs, ThatAreCutOffAreAnErrorThatNamesThem) {
  const TempFolder folder;
  const Image picture = test::photograph(200, 150, test::view_of_world(0, 0, 1));
  ASSERT_THAT(save_png(picture, folder / "whole.png"), IsOk());
  save_tiff(picture, folder / "whole.tif", 8, 1);
  const std::string jpeg = encode_jpeg(picture, 90), png = *read_file(folder / "whole.png"),
                    tiff = *read_file(folder / "whole.tif");
  for (const std::string& whole : {jpeg, png, tiff})
    for (const double share : {0.001, 0.1, 0.5, 0.9})
      EXPECT_FALSE(decode_photo(
          whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))), "cut"))
          << share;
  EXPECT_THAT(decode_photo(jpeg.substr(0, jpeg.size() / 2), "cut.jpg"),
              FailsWith(ErrorCode::BadData, "cut.jpg"));
  EXPECT_THAT(decode_photo("", "none.jpg"), FailsWith(ErrorCode::BadData, "none.jpg is empty"));
  EXPECT_THAT(decode_photo("GIF89a", "a.jpg"), FailsWith(ErrorCode::Unsupported, "neither"));
}

TEST(Photographs, OfAHundredMillionPixelsAreReadAndLargerOnesRefused) {
  EXPECT_THAT(decode_photo(encode_jpeg(Image(10'000, 10'000, 3, 77), 50), "large.jpg"),
              IsOkAnd(testing::Field(&Image::width, 10'000)));
  std::string png("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x80\0\0\0\x80\0\x08\2\0\0\0", 29);
  EXPECT_THAT(decode_photo(png, "huge.png"), FailsWith(ErrorCode::Unsupported, "32768x32768"));
  png.replace(16, 8, std::string(8, '\xFF'));  // whose product has 64 bits
  EXPECT_THAT(decode_photo(png, "huge.png"), FailsWith(ErrorCode::Unsupported, "4294967295x4294967295"));
}

TEST(Photographs, AreKnownByTheirNamesInAFolder) {
  for (const char* name : {"a.jpg", "a.JPEG", "a.png", "a.TIF", "a.tiff"})
    EXPECT_TRUE(has_name_of_photo(name));
  for (const char* name : {"a", "a.txt", "jpg", "a.jpg.part"}) EXPECT_FALSE(has_name_of_photo(name));
}

}  // namespace
}  // namespace floatstage::detail
