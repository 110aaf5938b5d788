// A take as its users see it: what goes in comes out.

#include "capture/take.h"

#include <algorithm>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/parallel.h"
#include "core/text.h"
#include "tests/capture/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Size {
  int width, height;
};

using LosslessCase = std::tuple<TakeCodec, PixelFormat, Size>;

class LosslessTake : public testing::TestWithParam<LosslessCase> {};

TEST_P(LosslessTake, ReturnsEveryPixelAsItWasRecorded) {
  const auto [codec, format, size] = GetParam();
  const TempFolder folder;
  TakeWriterOptions options;
  options.codec = codec;
  auto writer = TakeWriter::create(folder / "take", small_rig(1, size.width, size.height), options);
  ASSERT_THAT(writer, IsOk());
  std::vector<Frame> frames;
  for (std::uint64_t k = 0; k < 4; ++k) {
    frames.push_back(patterned_frame(format, size.width, size.height, 0, k));
    ASSERT_THAT((*writer)->write(k == 2 ? with_longer_rows(frames[2], 7) : frames.back()), IsOk());
  }
  ASSERT_THAT((*writer)->finish(), IsOk());

  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  EXPECT_EQ((*reader)->manifest().cameras.at(0).format, format);
  ASSERT_EQ((*reader)->frame_count(), 4);
  for (const int k : {0, 1, 2, 3, 1, 3, 0, 0, 2}) {
    const auto frame = (*reader)->frame(0, k);
    ASSERT_THAT(frame, IsOk());
    EXPECT_EQ(frame->info, frames[static_cast<std::size_t>(k)].info);
    EXPECT_EQ(frame->layout, packed_layout(format, size.width, size.height));
    EXPECT_TRUE(same_pixels(*frame, frames[static_cast<std::size_t>(k)])) << "frame " << k;
  }
}

std::string name_of_case(const testing::TestParamInfo<LosslessCase>& info) {
  const auto [codec, format, size] = info.param;
  std::string name =
      text(codec == TakeCodec::Ffv1 ? "ffv1_" : "raw_", name_of(format), "_", size.width, "x", size.height);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(AllFormats, LosslessTake,
                         testing::Combine(testing::Values(TakeCodec::Ffv1, TakeCodec::Raw),
                                          testing::Values(PixelFormat::Gray8, PixelFormat::Rgb8,
                                                          PixelFormat::Yuyv, PixelFormat::Nv12,
                                                          PixelFormat::BayerRggb8),
                                          testing::Values(Size{64, 48}, Size{37, 23})),
                         name_of_case);

class LossyTake : public testing::TestWithParam<PixelFormat> {};

TEST_P(LossyTake, ReturnsTheRecordedFormatNearlyAsItWas) {
  const TempFolder folder;
  TakeWriterOptions options;
  options.codec = TakeCodec::H264;
  auto writer = TakeWriter::create(folder / "take", small_rig(1, 64, 48), options);
  ASSERT_THAT(writer, IsOk());
  constexpr int kFrames = 60;  // more than two groups of pictures
  for (std::uint64_t k = 0; k < kFrames; ++k)
    ASSERT_THAT((*writer)->write(patterned_frame(GetParam(), 64, 48, 0, k)), IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());

  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  ASSERT_EQ((*reader)->frame_count(), kFrames);
  std::vector<Frame> in_order;
  for (int k = 0; k < kFrames; ++k) {
    auto frame = (*reader)->frame(0, k);
    ASSERT_THAT(frame, IsOk());
    ASSERT_FALSE(frame->empty()) << k;
    const Frame recorded = patterned_frame(GetParam(), 64, 48, 0, static_cast<std::uint64_t>(k));
    EXPECT_EQ(frame->layout, recorded.layout);
    const auto was = to_rgb(recorded), is = to_rgb(*frame);
    ASSERT_THAT(was, IsOk());
    ASSERT_THAT(is, IsOk());
    EXPECT_THAT(*is, ImageNear(*was, 27.0)) << k;
    in_order.push_back(*frame);
  }
  for (const int k : {59, 0, 33, 34, 31, 25, 24, 24, 26})
    EXPECT_TRUE(same_pixels((*reader)->frame(0, k).value(), in_order[static_cast<std::size_t>(k)]))
        << "after seeking to " << k;
}

INSTANTIATE_TEST_SUITE_P(AllFormats, LossyTake,
                         testing::Values(PixelFormat::Gray8, PixelFormat::Rgb8, PixelFormat::Yuyv,
                                         PixelFormat::Nv12, PixelFormat::BayerRggb8),
                         [](const auto& tested) {
                           std::string name = name_of(tested.param);
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(Take, HasTheFilesOfTheLayoutAndNoOther) {
  const TempFolder folder;
  record_small_take(folder / "take", 2, 2);
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "take"))
    names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  EXPECT_THAT(names, ElementsAre("cam0.frames.csv", "cam0.mkv", "cam1.frames.csv", "cam1.mkv", "rig.json",
                                 "take.json"));
}

TEST(Take, TellsWhatItIs) {
  const TempFolder folder;
  record_small_take(folder / "take", 2, 3);
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  const TakeManifest& m = (*reader)->manifest();
  EXPECT_TRUE(m.complete);
  EXPECT_EQ(m.label, "small");
  EXPECT_EQ(m.created, "2026-01-02T03:04:05Z");
  EXPECT_THAT(m.writer, testing::StartsWith("floatstage "));
  EXPECT_EQ(m.cameras.at(1).serial, "cam1");
  EXPECT_EQ(m.cameras.at(1).codec, "ffv1");
  EXPECT_EQ((*reader)->rig().cameras.size(), 2u);
  EXPECT_THAT((*reader)->warnings(), IsEmpty());
}

TEST(Take, DatesItselfWhenNoDateIsGiven) {
  const TempFolder folder;
  auto writer = TakeWriter::create(folder / "take", small_rig(1, 8, 8), {});
  ASSERT_THAT(writer, IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  EXPECT_THAT((*reader)->manifest().created, testing::MatchesRegex("20[0-9-]+T[0-9:]+Z"));
  EXPECT_EQ((*reader)->frame_count(), 0);
}

TEST(Take, KeepsGapsAsRows) {
  const TempFolder folder;
  record_small_take(folder / "take", 2, 4, TakeCodec::Ffv1, /*gap=*/1);
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  ASSERT_EQ((*reader)->rows(0).size(), 4u);
  EXPECT_EQ((*reader)->rows(0)[1].info.status, FrameStatus::Lost);
  EXPECT_EQ((*reader)->rows(0)[2].media_index, 1);
  const auto gap = (*reader)->frame(0, 1);
  ASSERT_THAT(gap, IsOk());
  EXPECT_TRUE(gap->empty());
  EXPECT_EQ(gap->info.status, FrameStatus::Lost);
  EXPECT_TRUE(same_pixels((*reader)->frame(0, 2).value(), patterned_frame(PixelFormat::Rgb8, 32, 24, 0, 2)));
}

TEST(Take, MakesRowsOfTheNumbersThatASequenceSkips) {
  const TempFolder folder;
  auto writer = TakeWriter::create(folder / "take", small_rig(1, 8, 8), {});
  ASSERT_THAT(writer, IsOk());
  for (const std::uint64_t sequence : {10u, 11u, 14u})
    ASSERT_THAT((*writer)->write(patterned_frame(PixelFormat::Gray8, 8, 8, 0, sequence)), IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  const std::vector<FrameRow>& rows = (*reader)->rows(0);
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[2].info.sequence, 12u);
  EXPECT_EQ(rows[2].info.status, FrameStatus::Lost);
  EXPECT_EQ(rows[3].info.exposure_start,
            patterned_frame(PixelFormat::Gray8, 8, 8, 0, 13).info.exposure_start);
  EXPECT_EQ(rows[4].info.sequence, 14u);
}

TEST(Take, KeepsStatusAndAbsentFacts) {
  const TempFolder folder;
  auto writer = TakeWriter::create(folder / "take", small_rig(1, 8, 8), {});
  ASSERT_THAT(writer, IsOk());
  Frame frame = patterned_frame(PixelFormat::Gray8, 8, 8, 0, 0);
  frame.info.status = FrameStatus::Corrupt;
  frame.info.exposure.reset();
  frame.info.device_time.reset();
  ASSERT_THAT((*writer)->write(frame), IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  EXPECT_EQ((*reader)->frame(0, 0)->info, frame.info);
}

TEST(Take, GathersAnInstantOfAllCameras) {
  const TempFolder folder;
  record_small_take(folder / "take", 3, 3, TakeCodec::Ffv1, /*gap=*/1);
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  const auto set = (*reader)->frame_set(1);
  ASSERT_THAT(set, IsOk());
  ASSERT_EQ(set->frames.size(), 3u);
  EXPECT_TRUE(set->frames[0].empty());
  for (int c = 1; c < 3; ++c)
    EXPECT_TRUE(same_pixels(set->frames[static_cast<std::size_t>(c)],
                            patterned_frame(PixelFormat::Rgb8, 32, 24, c, 1)));
  EXPECT_EQ(set->time, set->frames[1].info.exposure_start);  // camera 0 is earlier, but it missed the instant
}

TEST(Take, LetsCamerasHaveDifferentLengths) {
  const TempFolder folder;
  auto writer = TakeWriter::create(folder / "take", small_rig(2, 8, 8), {});
  ASSERT_THAT(writer, IsOk());
  for (std::uint64_t k = 0; k < 3; ++k)
    ASSERT_THAT((*writer)->write(patterned_frame(PixelFormat::Gray8, 8, 8, 1, k)), IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  EXPECT_EQ((*reader)->frame_count(), 3);
  const auto set = (*reader)->frame_set(2);
  ASSERT_THAT(set, IsOk());
  EXPECT_EQ(set->frames[0].info.status, FrameStatus::Lost);
  EXPECT_FALSE(set->frames[1].empty());
}

TEST(Take, RefusesIndicesThatAreNotThere) {
  const TempFolder folder;
  record_small_take(folder / "take", 1, 2);
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  EXPECT_THAT((*reader)->frame(0, 2), FailsWith(ErrorCode::InvalidArgument, "no frame 2"));
  EXPECT_THAT((*reader)->frame(0, -1), FailsWith(ErrorCode::InvalidArgument, "no frame -1"));
  EXPECT_THAT((*reader)->frame(1, 0), FailsWith(ErrorCode::InvalidArgument, "camera 1"));
  EXPECT_THAT((*reader)->frame_set(2), FailsWith(ErrorCode::InvalidArgument, "no frame 2"));
}

TEST(Take, HasTheSameBytesEachTimeItIsRecorded) {
  const TempFolder folder;
  for (const TakeCodec codec : {TakeCodec::Ffv1, TakeCodec::Raw, TakeCodec::H264}) {
    const auto name = [&](int i) { return text("take", static_cast<int>(codec), "-", i); };
    for (const int i : {0, 1}) record_small_take(folder / name(i), 2, 3, codec);
    for (const char* file : {"take.json", "rig.json", "cam0.frames.csv", "cam0.mkv", "cam1.mkv"})
      EXPECT_EQ(read_file(folder / name(0) / file).value(), read_file(folder / name(1) / file).value())
          << file;
  }
}

TEST(Take, ReadsTheSameOnOneThreadAndOnSeveral) {
  const TempFolder folder;
  for (const TakeCodec codec : {TakeCodec::Ffv1, TakeCodec::H264}) {
    const auto take = folder / text("take", static_cast<int>(codec));
    record_small_take(take, 2, 40, codec);
    auto reader = TakeReader::open(take);
    ASSERT_THAT(reader, IsOk());
    std::vector<Frame> alone(80), together(80);
    auto read = [&](std::vector<Frame>& into) {
      return [&](std::size_t i) {
        into[i] = (*reader)->frame(static_cast<int>(i % 2), static_cast<int>(i / 2)).value();
      };
    };
    parallel_for(80, 1, read(alone));
    parallel_for(80, 4, read(together));
    for (std::size_t i = 0; i < 80; ++i) EXPECT_TRUE(same_pixels(alone[i], together[i])) << i;
  }
}

TEST(Take, IsWrittenByAThreadACamera) {
  const TempFolder folder;
  auto writer = TakeWriter::create(folder / "take", small_rig(4, 32, 24), {});
  ASSERT_THAT(writer, IsOk());
  parallel_for(4, 4, [&](std::size_t c) {
    for (std::uint64_t k = 0; k < 10; ++k)
      EXPECT_THAT((*writer)->write(patterned_frame(c % 2 ? PixelFormat::Yuyv : PixelFormat::Rgb8, 32, 24,
                                                   static_cast<int>(c), k)),
                  IsOk());
  });
  ASSERT_THAT((*writer)->finish(), IsOk());
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  for (int c = 0; c < 4; ++c)
    EXPECT_TRUE(same_pixels((*reader)->frame(c, 9).value(),
                            patterned_frame(c % 2 ? PixelFormat::Yuyv : PixelFormat::Rgb8, 32, 24, c, 9)));
}

TEST(Take, KeepsFramesValidAfterTheReaderIsGone) {
  const TempFolder folder;
  record_small_take(folder / "take", 1, 2);
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  const Frame held = (*reader)->frame(0, 0).value();
  (*reader)->frame(0, 1).value();
  reader->reset();
  EXPECT_TRUE(same_pixels(held, patterned_frame(PixelFormat::Rgb8, 32, 24, 0, 0)));
}

}  // namespace
}  // namespace floatstage::capture
