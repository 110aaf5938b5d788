// Pictures that are one colour all over: lost, of a camera that usually shows something.
#include "capture/blank_picture.h"

#include <array>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/take.h"
#include "tests/capture/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

constexpr int kWidth = 96, kHeight = 64;

Image one_colour(int r, int g, int b) {
  Image picture(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      std::uint8_t* p = picture.at(x, y);
      p[0] = static_cast<std::uint8_t>(r), p[1] = static_cast<std::uint8_t>(g),
      p[2] = static_cast<std::uint8_t>(b);
    }
  return picture;
}

/// A room that is brighter on one side, with somebody in it.
Image room() {
  Image picture = one_colour(40, 80, 40);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) picture.at(x, y)[1] = static_cast<std::uint8_t>(60 + x);
  for (int y = 20; y < 50; ++y)
    for (int x = 40; x < 55; ++x) picture.at(x, y)[0] = 200;
  return picture;
}

/// Somebody before black cloth, lit from the front.
Image before_black(bool somebody) {
  Image picture = one_colour(0, 0, 0);
  for (int y = 20; somebody && y < 50; ++y)
    for (int x = 40; x < 55; ++x) picture.at(x, y)[0] = 200;
  return picture;
}

std::unique_ptr<TakeReader> recorded(const std::filesystem::path& folder, const std::vector<Image>& pictures,
                                     TakeCodec codec = TakeCodec::Ffv1) {
  TakeWriterOptions options;
  options.codec = codec;
  const auto writer = TakeWriter::create(folder, small_rig(1, kWidth, kHeight), options);
  EXPECT_THAT(writer, IsOk());
  for (std::size_t k = 0; k < pictures.size(); ++k) {
    FrameInfo info;
    info.camera = 0, info.sequence = k, info.exposure_start = {static_cast<std::int64_t>(k) * 40'000'000};
    EXPECT_THAT((*writer)->write(make_frame(info, pictures[k])), IsOk());
  }
  EXPECT_THAT((*writer)->finish(), IsOk());
  auto reader = TakeReader::open(folder);
  EXPECT_THAT(reader, IsOk());
  return std::move(*reader);
}

Image with_noise(Image picture, int steps) {
  for (std::size_t i = 0; i < picture.pixels.size(); ++i)
    picture.pixels[i] =
        static_cast<std::uint8_t>(picture.pixels[i] + (i * 7919) % static_cast<std::size_t>(steps + 1));
  return picture;
}

TEST(BlankPictures, AreOneColourButForSomeNoise) {
  const auto blank = [](const Image& picture) {
    const Frame frame = make_frame({}, picture);
    return is_one_colour(frame.layout, frame.pixels.get());
  };
  EXPECT_TRUE(blank(one_colour(0, 0, 0)));
  EXPECT_TRUE(blank(one_colour(20, 40, 220))) << "what converters show without a signal";
  EXPECT_TRUE(blank(with_noise(one_colour(3, 3, 3), 5)));
  EXPECT_FALSE(blank(with_noise(one_colour(3, 3, 3), 9)));
  EXPECT_FALSE(blank(room()));
  Image speck = one_colour(0, 0, 0);
  speck.at(3, 5)[1] = 90;
  EXPECT_FALSE(blank(speck)) << "between those that are looked at first";
}

TEST(BlankPictures, OfEveryFormat) {
  for (const PixelFormat format :
       {PixelFormat::Gray8, PixelFormat::Yuyv, PixelFormat::Nv12, PixelFormat::BayerRggb8}) {
    const ImageLayout layout = packed_layout(format, kWidth, kHeight);
    std::vector<std::byte> bytes(layout.size_bytes, std::byte{17});
    EXPECT_TRUE(is_one_colour(layout, bytes.data())) << name_of(format);
    EXPECT_EQ(border_spread(layout, bytes.data()), 0) << name_of(format);
    bytes[layout.stride * (kHeight / 2) + 16] = std::byte{90};
    EXPECT_FALSE(is_one_colour(layout, bytes.data())) << name_of(format);
  }
  const ImageLayout layout = packed_layout(PixelFormat::BayerRggb8, kWidth, kHeight);
  std::vector<std::byte> blue(layout.size_bytes);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      blue[static_cast<std::size_t>(y) * layout.stride + static_cast<std::size_t>(x)] =
          std::byte{static_cast<unsigned char>(x % 2 == 1 && y % 2 == 1 ? 200 : 10)};
  EXPECT_TRUE(is_one_colour(layout, blue.data())) << "a mosaic of one colour";
}

TEST(BlankPictures, AreLeftOutOfATakeAndSaidOnce) {
  for (const TakeCodec codec : {TakeCodec::Ffv1, TakeCodec::Raw}) {
    const TempFolder folder;
    std::vector<Image> pictures(9, room());
    pictures[0] = pictures[1] = one_colour(0, 0, 0);
    pictures[6] = one_colour(20, 40, 220);
    const auto take = recorded(folder / "take", pictures, codec);
    testing::internal::CaptureStderr();
    for (int frame = 0; frame < 9; ++frame) {
      const bool blank = frame < 2 || frame == 6;
      const Result<Frame> whole = take->frame(0, frame);
      ASSERT_THAT(whole, IsOk());
      EXPECT_EQ(whole->empty(), blank) << frame;
      EXPECT_EQ(whole->info.status, blank ? FrameStatus::Corrupt : FrameStatus::Ok) << frame;
      PixelBox box{10, 10, 70, 60}, taken;
      const Result<Frame> part = take->part(0, frame, std::array{box}, taken);
      ASSERT_THAT(part, IsOk());
      EXPECT_EQ(part->empty(), blank) << frame;
    }
    const std::string said = testing::internal::GetCapturedStderr();
    EXPECT_THAT(said, testing::HasSubstr("one colour all over in frame 0"));
    EXPECT_EQ(said.find("one colour"), said.rfind("one colour")) << "once: " << said;
  }
}

// Of a part alone nothing can be said.
TEST(BlankPictures, APartOfOneColourIsNone) {
  const TempFolder folder;
  const auto take = recorded(folder / "take", std::vector<Image>(3, room()));
  PixelBox box{40, 20, 41, 50}, taken;
  const Result<Frame> part = take->part(0, 1, std::array{box}, taken);
  ASSERT_THAT(part, IsOk());
  EXPECT_FALSE(part->empty());
}

TEST(BlankPictures, ShowNobodyBeforeBlackCloth) {
  const TempFolder folder;
  std::vector<Image> pictures(8, before_black(true));
  pictures[2] = pictures[3] = before_black(false);
  const auto take = recorded(folder / "take", pictures);
  for (int frame = 0; frame < 8; ++frame) EXPECT_FALSE(take->frame(0, frame)->empty()) << frame;
}

TEST(BlankPictures, StayWhereThereIsNothingElse) {
  const TempFolder folder;
  const auto take = recorded(folder / "take", std::vector<Image>(3, one_colour(9, 9, 9)));
  for (int frame = 0; frame < 3; ++frame) EXPECT_FALSE(take->frame(0, frame)->empty()) << frame;
}

}  // namespace
}  // namespace floatstage::capture
