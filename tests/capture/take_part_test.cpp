// A part of a take's picture costs less than the whole, and is the same.

#include <algorithm>
#include <array>
#include <random>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/take.h"
#include "core/file.h"
#include "core/log.h"
#include "core/text.h"
#include "tests/capture/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using PartCase = std::tuple<TakeCodec, PixelFormat, int>;

std::unique_ptr<TakeReader> recorded(const std::filesystem::path& take, TakeCodec codec, PixelFormat format,
                                     int width, int height) {
  TakeWriterOptions options;
  options.codec = codec;
  auto writer = TakeWriter::create(take, small_rig(1, width, height), options);
  EXPECT_THAT(writer, IsOk());
  for (std::uint64_t k = 0; k < 3; ++k)
    EXPECT_THAT((*writer)->write(patterned_frame(format, width, height, 0, k)), IsOk());
  EXPECT_THAT((*writer)->finish(), IsOk());
  auto reader = TakeReader::open(take);
  EXPECT_THAT(reader, IsOk());
  return std::move(*reader);
}

class PartsOfPictures : public testing::TestWithParam<PartCase> {};

TEST_P(PartsOfPictures, AreThoseOfTheWhole) {
  const auto [codec, format, width] = GetParam();
  const int height = width * 3 / 4;
  const TempFolder folder;
  const auto take = recorded(folder / "take", codec, format, width, height);
  const auto whole = TakeReader::open(folder / "take");
  std::minstd_rand random(5);
  for (int k = 0; k < 24; ++k) {
    const int index = k % 3;
    const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    PixelBox box{below(width + 20) - 20, below(height + 20) - 20, 21 + below(width), 21 + below(height)};
    if (k % 4 == 3) static_cast<void>(take->frame(0, index));  // between parts, too
    const Frame all = (*whole)->frame(0, index).value();
    PixelBox expected_box = box;
    const Frame expected = crop(all, expected_box).value();
    PixelBox taken;
    const Result<Frame> part = take->part(0, index, std::array{box}, taken);
    ASSERT_THAT(part, IsOk());
    EXPECT_EQ(taken, expected_box);
    EXPECT_EQ(part->info, all.info);
    EXPECT_EQ(to_rgb(*part)->pixels, to_rgb(expected)->pixels) << k;
    EXPECT_TRUE(same_pixels(take->frame(0, index).value(), all)) << k;
  }
}

std::string name_of_part(const testing::TestParamInfo<PartCase>& info) {
  const auto [codec, format, width] = info.param;
  const char* coded = codec == TakeCodec::Ffv1 ? "ffv1_" : codec == TakeCodec::Raw ? "raw_" : "h264_";
  std::string name = text(coded, name_of(format), "_", width);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(AllFormats, PartsOfPictures,
                         testing::Combine(testing::Values(TakeCodec::Ffv1, TakeCodec::Raw, TakeCodec::H264),
                                          testing::Values(PixelFormat::Gray8, PixelFormat::Rgb8,
                                                          PixelFormat::Yuyv, PixelFormat::Nv12,
                                                          PixelFormat::BayerRggb8),
                                          testing::Values(64, 256, 520)),
                         name_of_part);

TEST(PartsOfTakes, DoNotNoticeDamageElsewhere) {
  const TempFolder folder;
  static_cast<void>(recorded(folder / "take", TakeCodec::Ffv1, PixelFormat::Rgb8, 256, 192));
  std::string media = read_file(folder / "take" / "cam0.mkv").value();
  media[media.size() / 2] = static_cast<char>(media[media.size() / 2] ^ 0x10);  // mid in the second picture
  ASSERT_THAT(write_file(folder / "take" / "cam0.mkv", media), IsOk());
  log::set_level(log::Level::Error);
  const auto take = TakeReader::open(folder / "take");
  ASSERT_THAT(take, IsOk());
  const Frame intact = patterned_frame(PixelFormat::Rgb8, 256, 192, 0, 1);
  PixelBox corner{0, 0, 30, 30}, taken;
  const PixelBox middle{0, 70, 256, 60};
  const Result<Frame> part = (*take)->part(0, 1, std::array{corner}, taken);
  ASSERT_THAT(part, IsOk());
  ASSERT_FALSE(part->empty());
  EXPECT_EQ(to_rgb(*part)->pixels, to_rgb(crop(intact, corner).value())->pixels);
  for (const Result<Frame>& damaged :
       {(*take)->part(0, 1, std::array{middle}, taken), (*take)->frame(0, 1)}) {
    ASSERT_THAT(damaged, IsOk());
    EXPECT_TRUE(damaged->empty());
    EXPECT_EQ(damaged->info.status, FrameStatus::Corrupt);
  }
  log::set_level(log::Level::Info);
}

TEST(PartsOfTakes, AreRefusedWhereThereIsNothing) {
  const TempFolder folder;
  const auto take = recorded(folder / "take", TakeCodec::Ffv1, PixelFormat::Rgb8, 256, 192);
  const std::array beside{PixelBox{256, 0, 10, 10}}, some{PixelBox{0, 0, 10, 10}};
  PixelBox taken;
  EXPECT_THAT(take->part(0, 0, beside, taken), FailsWith(ErrorCode::InvalidArgument, "lies outside"));
  EXPECT_THAT(take->part(0, 3, some, taken), FailsWith(ErrorCode::InvalidArgument, "no frame 3"));
  EXPECT_THAT(take->part(1, 0, some, taken), FailsWith(ErrorCode::InvalidArgument, "of camera 1"));
}

// Whose boxes lie apart: what is between them costs nothing.
TEST(PartsOfTakes, HoldAllBoxes) {
  for (const PixelFormat format : {PixelFormat::Rgb8, PixelFormat::Nv12, PixelFormat::Yuyv}) {
    const TempFolder folder;
    const auto take = recorded(folder / "take", TakeCodec::Ffv1, format, 520, 390);
    const std::array boxes{PixelBox{10, 10, 60, 20}, PixelBox{300, 250, 90, 70}, PixelBox{-9, 200, 19, 30}};
    PixelBox taken;
    const Result<Frame> part = take->part(0, 1, boxes, taken);
    ASSERT_THAT(part, IsOk());
    EXPECT_EQ(taken, (PixelBox{0, 10, 390, 310}));
    const Image got = to_rgb(*part).value(), whole = to_rgb(take->frame(0, 1).value()).value();
    for (const PixelBox& box : boxes)
      for (int y = box.y; y < box.y + box.height; ++y)
        for (int x = std::max(box.x, 0); x < box.x + box.width; ++x)
          for (int c = 0; c < 3; ++c) ASSERT_EQ(got.at(x - taken.x, y - taken.y)[c], whole.at(x, y)[c]);
    if (format == PixelFormat::Rgb8) {
      EXPECT_EQ(*got.at(200, 100), 0);
    }
  }
}

TEST(PartsOfTakes, OfAGapHaveNoPixels) {
  const TempFolder folder;
  record_small_take(folder / "take", 1, 4, TakeCodec::Ffv1, /*gap=*/2);
  const auto take = TakeReader::open(folder / "take");
  PixelBox taken;
  const Result<Frame> gap = (*take)->part(0, 2, std::array{PixelBox{0, 0, 10, 10}}, taken);
  ASSERT_THAT(gap, IsOk());
  EXPECT_TRUE(gap->empty());
  EXPECT_EQ(gap->info.status, FrameStatus::Lost);
}

}  // namespace
}  // namespace floatstage::capture
