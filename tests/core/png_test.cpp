#include "core/png.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/file.h"
#include "core/random.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

Image noise(int width, int height, int channels) {
  Image image(width, height, channels);
  Random random(3);
  for (std::uint8_t& p : image.pixels) p = static_cast<std::uint8_t>(random.next());
  return image;
}

Result<Image> decode(std::string_view bytes) {
  return decode_png(std::as_bytes(std::span(bytes)), "test.png");
}

class EveryChannelCount : public testing::TestWithParam<int> {};

TEST_P(EveryChannelCount, ComesBackBitByBit) {
  const TempFolder folder;
  const Image image = noise(17, 5, GetParam());
  ASSERT_THAT(save_png(image, folder / "a.png"), IsOk());
  EXPECT_THAT(load_png(folder / "a.png"), IsOkAnd(testing::Eq(image)));
  EXPECT_THAT(folder.names(), testing::ElementsAre("a.png"));
}

TEST_P(EveryChannelCount, CutOffAnywhereIsRefusedByName) {
  const TempFolder folder;
  ASSERT_THAT(save_png(noise(9, 7, GetParam()), folder / "a.png"), IsOk());
  const Result<std::string> whole = read_file(folder / "a.png");
  ASSERT_THAT(whole, IsOk());
  constexpr std::size_t kEndChunk = 12;  // without it, every pixel is there and libpng is content
  for (std::size_t length = 0; length + kEndChunk < whole->size(); ++length)
    EXPECT_THAT(decode(std::string_view(*whole).substr(0, length)), FailsWith(ErrorCode::BadData, "test.png"))
        << length;
}

INSTANTIATE_TEST_SUITE_P(Channels, EveryChannelCount, testing::Values(1, 3, 4));

std::filesystem::path seed(const char* name) { return source_folder() / "tests/fuzz/corpus/png" / name; }

TEST(Png, ExpandsOneBitToBlackAndWhite) {
  const Result<Image> image = load_png(seed("bit.png"));
  ASSERT_THAT(image, IsOk());
  EXPECT_EQ(image->channels, 1);
  EXPECT_THAT(image->pixels, testing::ElementsAre(255, 0, 255, 0, 255, 0, 255, 0, 255, 0, 0, 255, 0, 255, 0,
                                                  255, 0, 255, 0, 255));
}

TEST(Png, ExpandsPalettes) {
  const Result<Image> image = load_png(seed("palette.png"));
  ASSERT_THAT(image, IsOk());
  EXPECT_EQ(image->channels, 4);
  EXPECT_THAT(image->pixels, testing::ElementsAre(255, 0, 0, 128, 0, 255, 0, 255, 0, 0, 255, 255));
}

TEST(Png, ReducesSixteenBits) {
  const Result<Image> image = load_png(seed("grey16.png"));
  ASSERT_THAT(image, IsOk());
  EXPECT_THAT(image->pixels, testing::ElementsAre(0, 0, 0, 255, 255, 255));
}

TEST(Png, OfRunsIsTheSamePictureInFewerBytesWhereItIsAMatte) {
  Image matte = noise(160, 120, 1);  // what keys leave at an outline
  for (int y = 0; y < matte.height; ++y)
    for (int x = 0; x < matte.width; ++x)
      if (const double beyond = std::hypot(x - 80, y - 60) - 40; std::abs(beyond) > 2)
        matte.at(x, y)[0] = beyond < 0 ? 255 : 0;
  const Result<std::string> runs = encode_png_of_runs(matte);
  ASSERT_THAT(runs, IsOk());
  const Result<Image> back = decode_png(std::as_bytes(std::span(*runs)), "runs");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->pixels, matte.pixels);
  TempFolder folder;
  ASSERT_THAT(save_png(matte, folder / "usual.png"), IsOk());
  EXPECT_LT(runs->size(), std::filesystem::file_size(folder / "usual.png"));
  EXPECT_THROW((void)encode_png_of_runs(Image{}), CheckFailure);
}

TEST(Png, ReadsItsOwnSixteenBitsBackAsTheyWere) {
  TempFolder folder;
  for (const int channels : {1, 3, 4}) {
    Image ramp(64, 16, channels);
    for (std::size_t i = 0; i < ramp.pixels.size(); ++i) ramp.pixels[i] = static_cast<std::uint8_t>(i * 7);
    ASSERT_THAT(save_png16(ramp, folder / "ramp.png"), IsOk());
    EXPECT_THAT(load_png(folder / "ramp.png"), IsOkAnd(ramp))
        << channels << ": not taken for linear light, nor multiplied by opacity";
  }
}

TEST(Png, WithADamagedByteIsRefused) {
  const Result<std::string> whole = read_file(seed("rgb.png"));
  ASSERT_THAT(whole, IsOk());
  std::string damaged = *whole;
  damaged[damaged.find("IDAT") + 6] ^= 1;
  EXPECT_THAT(decode(damaged), FailsWith(ErrorCode::BadData, "test.png"));
}

TEST(Png, OfAbsurdSizeCostsNoMemory) {
  std::string huge = *read_file(seed("rgb.png"));
  huge.replace(16, 8, std::string("\x7f\xff\xff\xff\x7f\xff\xff\xff"));
  EXPECT_THAT(decode(huge), FailsWith(ErrorCode::BadData, "test.png"));
}

TEST(Png, ThatClaimsFarMoreThanItsBytesCanHoldIsRefusedBeforeMemoryIsTaken) {
  // A whole header, its checksum too, of 32768x32768 pixels with 40 bytes to follow.
  EXPECT_THAT(load_png(seed("huge.png")), FailsWith(ErrorCode::BadData, "far shorter than its picture"));
}

TEST(Png, ThatIsNoPngIsRefused) {
  EXPECT_THAT(decode("GIF89a, or so it says"), FailsWith(ErrorCode::BadData, "not a whole PNG"));
}

TEST(Png, ThatIsNotThereIsNotFound) {
  EXPECT_THAT(load_png("/nowhere/a.png"), FailsWith(ErrorCode::NotFound, "/nowhere/a.png"));
}

TEST(Png, IsNotMadeOfNothing) { EXPECT_THROW((void)save_png(Image{}, "a.png"), CheckFailure); }

TEST(Png, OfMorePixelsThanAnySensorIsRefusedBeforeItCostsMemory) {
  // 16384x8192 in one bit a pixel: small enough for a file of ours, and 400 MB as RGB.
  EXPECT_THAT(load_png(seed("wide.png")), FailsWith(ErrorCode::BadData, "more than 112 Mpx"));
}

}  // namespace
}  // namespace floatstage
