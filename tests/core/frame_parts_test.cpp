#include <cstring>

#include <gtest/gtest.h>

#include "core/frame.h"
#include "core/random.h"
#include "tests/support/matchers.h"

namespace floatstage {
namespace {

constexpr PixelFormat kFormats[] = {PixelFormat::Gray8, PixelFormat::Rgb8, PixelFormat::Yuyv,
                                    PixelFormat::Nv12, PixelFormat::BayerRggb8};

/// Random bytes in rows with some padding, as drivers deliver them.
Frame noise(PixelFormat format, int width, int height, std::uint64_t seed = 7) {
  const ImageLayout tight = packed_layout(format, width, height);
  ImageLayout layout = tight;
  layout.stride += 6;
  layout.size_bytes = tight.size_bytes / tight.stride * layout.stride;
  auto bytes = std::make_shared<std::byte[]>(layout.size_bytes);
  Random random(seed);
  for (std::size_t i = 0; i < layout.size_bytes; ++i)
    bytes[i] = static_cast<std::byte>(static_cast<int>(random.uniform(16, 235)));
  FrameInfo info;
  info.camera = 3;
  return {info, layout, std::move(bytes)};
}

/// The mean of the whole picture's pixels below (x, y), as the contract says.
int block_mean(const Image& whole, int x, int y, int factor, int channel) {
  int sum = 0, count = 0;
  for (int v = y * factor; v < std::min((y + 1) * factor, whole.height); ++v)
    for (int u = x * factor; u < std::min((x + 1) * factor, whole.width); ++u, ++count)
      sum += whole.at(u, v)[channel];
  return (sum + count / 2) / count;
}

TEST(Shrink, IsTheMeanOfEveryBlockOfAnRgbPictureItsBordersToo) {
  const Frame frame = noise(PixelFormat::Rgb8, 23, 14);
  const Image whole = *to_rgb(frame);
  for (int factor : {1, 2, 3, 4}) {
    const Result<Image> small = shrink(frame, factor);
    ASSERT_THAT(small, IsOk());
    ASSERT_EQ(small->width, (23 + factor - 1) / factor);
    ASSERT_EQ(small->height, (14 + factor - 1) / factor);
    for (int y = 0; y < small->height; ++y)
      for (int x = 0; x < small->width; ++x)
        for (int c = 0; c < 3; ++c)
          EXPECT_EQ(small->at(x, y)[c], block_mean(whole, x, y, factor, c)) << x << "," << y;
  }
}

TEST(Shrink, LeavesGrayGray) {
  const Result<Image> small = shrink(noise(PixelFormat::Gray8, 10, 6), 2);
  ASSERT_THAT(small, IsOk());
  EXPECT_EQ(small->channels, 1);
  EXPECT_EQ(small->width, 5);
}

// Averaging samples and averaging colours differ by rounding and clamping only where the picture is even.
TEST(Shrink, AgreesWithTheMeanOfTheColoursInEveryFormat) {
  for (const PixelFormat format : {PixelFormat::Yuyv, PixelFormat::Nv12, PixelFormat::BayerRggb8}) {
    Frame frame = noise(format, 16, 8);
    auto flat = std::make_shared<std::byte[]>(frame.layout.size_bytes);
    for (std::size_t i = 0; i < frame.layout.size_bytes; ++i)
      flat[i] = static_cast<std::byte>(i % 2 ? 140 : 120);
    frame.pixels = flat;
    const Image whole = *to_rgb(frame);
    const Result<Image> small = shrink(frame, 4);
    ASSERT_THAT(small, IsOk());
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(small->at(1, 1)[c], block_mean(whole, 1, 1, 4, c), 3) << name_of(format);
  }
}

TEST(Shrink, TakesEachBayerColourWhereItWasMeasured) {
  Frame frame = noise(PixelFormat::BayerRggb8, 4, 2);
  auto bytes = std::make_shared<std::byte[]>(frame.layout.size_bytes);
  const auto set = [&](int x, int y, int v) {
    bytes[static_cast<std::size_t>(y) * frame.layout.stride + static_cast<std::size_t>(x)] =
        static_cast<std::byte>(v);
  };
  set(0, 0, 200), set(1, 0, 90), set(0, 1, 110), set(1, 1, 30);
  frame.pixels = bytes;
  const Result<Image> small = shrink(frame, 2);
  ASSERT_THAT(small, IsOk());
  EXPECT_EQ(small->at(0, 0)[0], 200);
  EXPECT_EQ(small->at(0, 0)[1], 100);
  EXPECT_EQ(small->at(0, 0)[2], 30);
}

TEST(Shrink, UsesMemoryAgainWithoutATraceOfWhatWasThere) {
  std::vector<std::uint32_t> sums;
  Image small;
  ASSERT_THAT(shrink(noise(PixelFormat::Rgb8, 40, 30), 2, sums, small), IsOk());
  const std::uint8_t* memory = small.pixels.data();
  for (const PixelFormat format : {PixelFormat::Rgb8, PixelFormat::Gray8, PixelFormat::BayerRggb8}) {
    const Frame frame = noise(format, 13, 7);
    ASSERT_THAT(shrink(frame, 3, sums, small), IsOk());
    EXPECT_EQ(small, *shrink(frame, 3));
    EXPECT_EQ(small.pixels.data(), memory);
  }
}

TEST(Shrink, RefusesWhatItCannotRead) {
  EXPECT_THAT(shrink(Frame{}, 2), FailsWith(ErrorCode::NotFound, ""));
  EXPECT_THAT(shrink(noise(PixelFormat::Rgb8, 4, 4), 0), FailsWith(ErrorCode::InvalidArgument, ""));
  Frame cut = noise(PixelFormat::Rgb8, 4, 4);
  cut.layout.size_bytes = 20;
  EXPECT_THAT(shrink(cut, 2), FailsWith(ErrorCode::BadData, ""));
}

TEST(Crop, HoldsThePixelsOfThePictureInEveryFormat) {
  for (const PixelFormat format : kFormats) {
    const Frame frame = noise(format, 20, 12);
    PixelBox box{5, 3, 7, 5};
    const Result<Frame> part = crop(frame, box);
    ASSERT_THAT(part, IsOk()) << name_of(format);
    EXPECT_LE(box.x, 5);
    EXPECT_LE(box.y, 3);
    EXPECT_GE(box.x + box.width, 12);
    EXPECT_GE(box.y + box.height, 8);
    const Image whole = *to_rgb(frame);
    const Result<Image> got = to_rgb(*part);
    ASSERT_THAT(got, IsOk()) << name_of(format);
    ASSERT_EQ(got->width, box.width);
    ASSERT_EQ(got->height, box.height);
    const int rim = format == PixelFormat::BayerRggb8 ? 1 : 0;  // demosaicing mirrors at the part's border
    for (int y = rim; y < box.height - rim; ++y)
      for (int x = rim; x < box.width - rim; ++x)
        EXPECT_EQ(0, std::memcmp(got->at(x, y), whole.at(box.x + x, box.y + y), 3))
            << name_of(format) << " " << x << "," << y;
  }
}

TEST(Crop, SharesTheBufferWhereTheFormatAllowsIt) {
  const Frame frame = noise(PixelFormat::Rgb8, 20, 12);
  PixelBox box{4, 2, 8, 6};
  const Result<Frame> part = crop(frame, box);
  ASSERT_THAT(part, IsOk());
  EXPECT_EQ(part->pixels.get(), frame.pixels.get() + 2 * frame.layout.stride + 12);
  EXPECT_EQ(frame.pixels.use_count(), 2) << "the part keeps the buffer alive";
}

TEST(Crop, ReachesToThePicturesCornersAndNoFarther) {
  for (const PixelFormat format : kFormats) {
    const Frame frame = noise(format, 9, 7);
    PixelBox box{-3, -3, 100, 100};
    const Result<Frame> part = crop(frame, box);
    ASSERT_THAT(part, IsOk()) << name_of(format);
    EXPECT_EQ(box, (PixelBox{0, 0, 9, 7}));
    EXPECT_EQ(to_rgb(*part)->pixels, to_rgb(frame)->pixels) << name_of(format);
    PixelBox last{8, 6, 1, 1}, outside{9, 0, 2, 2};
    EXPECT_THAT(crop(frame, last), IsOk()) << name_of(format);
    EXPECT_THAT(crop(frame, outside), FailsWith(ErrorCode::InvalidArgument, ""));
  }
}

}  // namespace
}  // namespace floatstage
