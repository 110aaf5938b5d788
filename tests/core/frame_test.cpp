#include "core/frame.h"

#include <array>
#include <cstring>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace floatstage {
namespace {

using Rgb = std::array<int, 3>;

Frame frame_of(ImageLayout layout, const std::vector<int>& bytes) {
  auto pixels = std::make_shared<std::byte[]>(bytes.size());
  for (std::size_t i = 0; i < bytes.size(); ++i) pixels[i] = static_cast<std::byte>(bytes[i]);
  FrameInfo info;
  info.camera = 4;
  return {info, layout, std::move(pixels)};
}

Frame packed(PixelFormat format, int width, int height, const std::vector<int>& bytes) {
  const ImageLayout layout = packed_layout(format, width, height);
  EXPECT_EQ(layout.size_bytes, bytes.size());
  return frame_of(layout, bytes);
}

Rgb at(const Result<Image>& image, int x, int y) {
  const std::uint8_t* p = image->at(x, y);
  return {p[0], p[1], p[2]};
}

// Y, U, V of saturated colours in BT.601 limited range (Rec. ITU-R BT.601, rounded to 8 bits).
struct Yuv {
  int y, u, v;
  Rgb rgb;
};
constexpr Yuv kColours[] = {{16, 128, 128, {0, 0, 0}},   {235, 128, 128, {255, 255, 255}},
                            {81, 90, 240, {255, 0, 0}},  {145, 54, 34, {0, 255, 0}},
                            {41, 240, 110, {0, 0, 255}}, {126, 128, 128, {128, 128, 128}}};

void expect_colour(const Rgb& actual, const Rgb& expected) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(actual[c], expected[c], 2) << "channel " << c;
}

TEST(ToRgb, ReadsYuyvAsLimitedRangeBt601) {
  for (const Yuv& c : kColours) {
    const Result<Image> rgb = to_rgb(packed(PixelFormat::Yuyv, 2, 1, {c.y, c.u, 16, c.v}));
    ASSERT_THAT(rgb, IsOk());
    expect_colour(at(rgb, 0, 0), c.rgb);
  }
}

TEST(ToRgb, ReadsNv12AsLimitedRangeBt601) {
  for (const Yuv& c : kColours) {
    const Result<Image> rgb = to_rgb(packed(PixelFormat::Nv12, 2, 2, {16, 16, 16, c.y, c.u, c.v}));
    ASSERT_THAT(rgb, IsOk());
    expect_colour(at(rgb, 1, 1), c.rgb);
  }
}

TEST(ToRgb, GivesOddYuyvAndNv12TheirLastColumnAndRow) {
  const Result<Image> yuyv = to_rgb(packed(PixelFormat::Yuyv, 3, 1, {16, 128, 16, 128, 81, 90, 0, 240}));
  ASSERT_THAT(yuyv, IsOk());
  expect_colour(at(yuyv, 2, 0), {255, 0, 0});
  // 3x3: rows of four bytes, three of luma and two of chroma; the last chroma pair is red.
  const Result<Image> nv12 =
      to_rgb(packed(PixelFormat::Nv12, 3, 3,
                    {16, 16, 16, 0, 16, 16, 16, 0, 16, 16, 81, 0, 128, 128, 128, 128, 128, 128, 90, 240}));
  ASSERT_THAT(nv12, IsOk());
  expect_colour(at(nv12, 2, 2), {255, 0, 0});
  expect_colour(at(nv12, 0, 0), {0, 0, 0});
}

// An RGGB mosaic of one flat colour must come back as that colour, at borders too.
TEST(ToRgb, DemosaicsAFlatColourToItself) {
  constexpr int kWidth = 6, kHeight = 4;
  std::vector<int> raw;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) raw.push_back((y + x) % 2 ? 120 : y % 2 ? 30 : 200);
  const Result<Image> rgb = to_rgb(packed(PixelFormat::BayerRggb8, kWidth, kHeight, raw));
  ASSERT_THAT(rgb, IsOk());
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) EXPECT_EQ(at(rgb, x, y), (Rgb{200, 120, 30})) << x << ", " << y;
}

TEST(ToRgb, DemosaicsBilinearly) {
  // A red ramp: 0, 100 at x = 0, 2 on even rows; half-way between them at x = 1.
  const Result<Image> rgb = to_rgb(packed(PixelFormat::BayerRggb8, 4, 2, {0, 0, 100, 0, 0, 0, 0, 0}));
  ASSERT_THAT(rgb, IsOk());
  EXPECT_EQ(at(rgb, 1, 0)[0], 50);
  EXPECT_EQ(at(rgb, 2, 0)[0], 100);
}

TEST(ToRgb, KeepsRgbAndRepeatsGreyWithinPaddedRows) {
  const ImageLayout padded_rgb{PixelFormat::Rgb8, 1, 2, 5, 8};
  const Result<Image> rgb = to_rgb(frame_of(padded_rgb, {1, 2, 3, 99, 99, 4, 5, 6}));
  ASSERT_THAT(rgb, IsOk());
  EXPECT_EQ(rgb->pixels, (std::vector<std::uint8_t>{1, 2, 3, 4, 5, 6}));
  const ImageLayout padded_grey{PixelFormat::Gray8, 2, 2, 3, 5};
  const Result<Image> grey = to_rgb(frame_of(padded_grey, {7, 8, 99, 9, 10}));
  ASSERT_THAT(grey, IsOk());
  EXPECT_EQ(grey->pixels, (std::vector<std::uint8_t>{7, 7, 7, 8, 8, 8, 9, 9, 9, 10, 10, 10}));
}

class EveryRawFormat : public testing::TestWithParam<PixelFormat> {};

TEST_P(EveryRawFormat, RefusesABufferShorterThanItsLayout) {
  for (int width : {1, 4, 5}) {
    ImageLayout layout = packed_layout(GetParam(), width, 3);
    const std::vector<int> bytes(layout.size_bytes, 100);
    EXPECT_THAT(to_rgb(frame_of(layout, bytes)), IsOk());
    layout.size_bytes -= 1;
    EXPECT_THAT(to_rgb(frame_of(layout, bytes)), FailsWith(ErrorCode::BadData, "camera 4"));
    layout.size_bytes += 1;
    layout.stride -= 1;
    EXPECT_THAT(to_rgb(frame_of(layout, bytes)), FailsWith(ErrorCode::BadData, "camera 4"))
        << "rows that overlap";
  }
}

TEST_P(EveryRawFormat, IsFoundByItsName) { EXPECT_EQ(pixel_format_named(name_of(GetParam())), GetParam()); }

INSTANTIATE_TEST_SUITE_P(Formats, EveryRawFormat,
                         testing::Values(PixelFormat::Gray8, PixelFormat::Rgb8, PixelFormat::Yuyv,
                                         PixelFormat::Nv12, PixelFormat::BayerRggb8),
                         [](const auto& p) {
                           std::string name = name_of(p.param);
                           std::erase(name, '-');
                           return name;
                         });

TEST(ToRgb, LeavesMjpegToTheCaptureSource) {
  const ImageLayout layout{PixelFormat::Mjpeg, 2, 2, 0, 3};
  EXPECT_THAT(to_rgb(frame_of(layout, {1, 2, 3})), FailsWith(ErrorCode::Unsupported, "MJPEG"));
}

TEST(ToRgb, OfAMissedInstantIsNotFound) {
  EXPECT_THAT(to_rgb(Frame{}), FailsWith(ErrorCode::NotFound, "no picture"));
}

TEST(ToRgb, RefusesAPictureOfNoSize) {
  const ImageLayout layout{PixelFormat::Gray8, 0, 3, 0, 4};
  EXPECT_THAT(to_rgb(frame_of(layout, {1, 2, 3, 4})), FailsWith(ErrorCode::BadData, "0x3"));
}

TEST(Frame, OwnsACopyOfTheImageItWasMadeFrom) {
  Image image(2, 1, 3, 50);
  const Frame frame = make_frame({}, image);
  image.pixels.assign(image.pixels.size(), 0);
  const Result<Image> back = to_rgb(frame);
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(at(back, 1, 0), (Rgb{50, 50, 50}));
}

TEST(ToRgb, UsesThePicturesMemoryAgain) {
  const Frame gray = make_frame({}, Image(3, 2, 1, 90)), color = make_frame({}, Image(4, 5, 3, 70));
  Image rgb;
  ASSERT_THAT(to_rgb(color, rgb), IsOk());
  const std::uint8_t* memory = rgb.pixels.data();
  ASSERT_THAT(to_rgb(gray, rgb), IsOk());
  EXPECT_EQ(rgb, Image(3, 2, 3, 90)) << "nothing is left of the larger one";
  EXPECT_EQ(rgb.pixels.data(), memory);
  EXPECT_THAT(to_rgb(Frame{}, rgb), FailsWith(ErrorCode::NotFound, ""));
  EXPECT_EQ(rgb, Image(3, 2, 3, 90)) << "errors leave it as it was";
}

TEST(Frame, ThatIsBorrowedShowsTheImageItself) {
  Image image(2, 2, 3, 7);
  const Frame frame = borrowed_frame({}, image);
  *image.at(1, 1) = 9;
  EXPECT_EQ(*to_rgb(frame), image);
}

TEST(Frame, MadeFromGreyIsGrey) {
  EXPECT_EQ(make_frame({}, Image(2, 2, 1)).layout.format, PixelFormat::Gray8);
}

TEST(Frame, IsNotMadeFromTransparency) { EXPECT_THROW(make_frame({}, Image(2, 2, 4)), CheckFailure); }

TEST(FrameStatus, IsFoundByItsName) {
  for (FrameStatus s : {FrameStatus::Ok, FrameStatus::Corrupt, FrameStatus::Lost})
    EXPECT_EQ(frame_status_named(name_of(s)), s);
  EXPECT_FALSE(frame_status_named("OK"));
  EXPECT_FALSE(pixel_format_named(""));
}

}  // namespace
}  // namespace floatstage
