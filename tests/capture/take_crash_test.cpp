// Recordings that end badly: the power button, the full disk, the writer that is never finished.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/media_file.h"
#include "capture/side_file.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/text.h"
#include "tests/capture/pictures.h"
#include "tests/support/child_process.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::Contains;
using testing::Each;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kWidth = 160, kHeight = 120;

// Records two cameras for ever, reporting each instant that both have been written.
int record_for_ever(const std::filesystem::path& take, TakeCodec codec, const std::function<void()>& report) {
  TakeWriterOptions options;
  options.codec = codec;
  auto writer = TakeWriter::create(take, small_rig(2, kWidth, kHeight), options);
  if (!writer) return 1;
  for (std::uint64_t k = 0;; ++k) {
    for (int c = 0; c < 2; ++c)
      if (!(*writer)->write(patterned_frame(PixelFormat::Rgb8, kWidth, kHeight, c, k))) return 2;
    report();
  }
}

// Every row of every camera plays, bit by bit when the codec is lossless.
void expect_plays_to_the_cut(TakeReader& reader, TakeCodec codec, std::size_t at_least) {
  for (int c = 0; c < 2; ++c) {
    EXPECT_GE(reader.rows(c).size(), at_least);
    for (int k = 0; k < static_cast<int>(reader.rows(c).size()); ++k) {
      const Result<Frame> frame = reader.frame(c, k);
      ASSERT_THAT(frame, IsOk());
      ASSERT_EQ(frame->info.status, FrameStatus::Ok) << "camera " << c << " frame " << k;
      const Frame recorded =
          patterned_frame(PixelFormat::Rgb8, kWidth, kHeight, c, static_cast<std::uint64_t>(k));
      if (codec == TakeCodec::H264)
        EXPECT_THAT(to_rgb(*frame), IsOkAnd(ImageNear(to_rgb(recorded).value(), 27.0)));
      else
        EXPECT_TRUE(same_pixels(*frame, recorded)) << "camera " << c << " frame " << k;
    }
  }
}

class KilledRecording : public testing::TestWithParam<TakeCodec> {};

TEST_P(KilledRecording, PlaysUpToTheCut) {
  const TempFolder folder;
  for (const std::size_t instants : {1u, 2u, 5u, 13u, 40u}) {
    const auto take = folder / text("take", instants);
    ChildProcess recorder([&](const auto& report) { return record_for_ever(take, GetParam(), report); });
    ASSERT_TRUE(recorder.wait_for_reports(instants));
    recorder.kill();
    ASSERT_EQ(recorder.wait(), -1) << "killed while it recorded";
    auto reader = TakeReader::open(take);
    ASSERT_THAT(reader, IsOk());
    EXPECT_FALSE((*reader)->manifest().complete);
    EXPECT_THAT((*reader)->warnings(), Contains(HasSubstr("was cut off")));
    expect_plays_to_the_cut(**reader, GetParam(), instants);
  }
}

TEST_P(KilledRecording, PlaysInOtherPlayersToo) {
  const TempFolder folder;
  ChildProcess recorder(
      [&](const auto& report) { return record_for_ever(folder / "take", GetParam(), report); });
  ASSERT_TRUE(recorder.wait_for_reports(6));
  recorder.kill();
  recorder.wait();
  auto player = MediaReader::open(folder / "take" / "cam1.mkv");
  ASSERT_THAT(player, IsOk());
  for (int k = 0; k < 6; ++k) EXPECT_THAT((*player)->next(), IsOk()) << k;
}

INSTANTIATE_TEST_SUITE_P(AllCodecs, KilledRecording,
                         testing::Values(TakeCodec::Ffv1, TakeCodec::Raw, TakeCodec::H264),
                         [](const auto& tested) {
                           return tested.param == TakeCodec::Ffv1  ? "ffv1"
                                  : tested.param == TakeCodec::Raw ? "raw"
                                                                   : "h264";
                         });

TEST(CutTake, PlaysWhatAnAbandonedWriterWrote) {
  const TempFolder folder;
  {
    auto writer = TakeWriter::create(folder / "take", small_rig(2, kWidth, kHeight), {});
    ASSERT_THAT(writer, IsOk());
    for (std::uint64_t k = 0; k < 3; ++k)
      for (int c = 0; c < 2; ++c)
        ASSERT_THAT((*writer)->write(patterned_frame(PixelFormat::Rgb8, kWidth, kHeight, c, k)), IsOk());
  }
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  EXPECT_FALSE((*reader)->manifest().complete);
  expect_plays_to_the_cut(**reader, TakeCodec::Ffv1, 3);
}

TEST(CutTake, OpensWhenNothingWasRecordedYet) {
  const TempFolder folder;
  TakeWriter::create(folder / "take", small_rig(2, kWidth, kHeight), {}).value().reset();
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  EXPECT_EQ((*reader)->frame_count(), 0);
}

TEST(CutTake, KnowsItsFormatBeforeItsFirstPicture) {
  const TempFolder folder;
  auto writer = TakeWriter::create(folder / "take", small_rig(2, 16, 12), {});
  ASSERT_THAT(writer, IsOk());
  ASSERT_THAT((*writer)->write(patterned_frame(PixelFormat::Nv12, 16, 12, 1, 0)), IsOk());
  auto reader = TakeReader::open(folder / "take");  // while it is being written
  ASSERT_THAT(reader, IsOk());
  EXPECT_TRUE(same_pixels((*reader)->frame(1, 0).value(), patterned_frame(PixelFormat::Nv12, 16, 12, 1, 0)));
}

class FullDisk : public testing::TestWithParam<TakeCodec> {};

TEST_P(FullDisk, IsNamedAndLosesNothingThatWasWritten) {
  const TempFolder folder;
  enum { kNeverFull = 1, kWrongError, kWritesOn, kFinishes };
  ChildProcess recorder([&](const auto& report) -> int {
    let_files_grow_to(400'000);
    TakeWriterOptions options;
    options.codec = GetParam();
    auto writer = TakeWriter::create(folder / "take", small_rig(2, kWidth, kHeight), options);
    for (std::uint64_t k = 0; k < 2000; ++k) {
      const Result<void> ok = (*writer)->write(patterned_frame(PixelFormat::Rgb8, kWidth, kHeight, 0, k));
      if (ok) {
        report();
        continue;
      }
      const std::string media = (folder / "take" / "cam0.mkv").string();
      if (ok.error().code != ErrorCode::Io || ok.error().message.find(media) == std::string::npos)
        return kWrongError;
      const Result<void> again =
          (*writer)->write(patterned_frame(PixelFormat::Rgb8, kWidth, kHeight, 0, k + 1));
      if (again || again.error().message != ok.error().message) return kWritesOn;
      if (!(*writer)->write(patterned_frame(PixelFormat::Rgb8, kWidth, kHeight, 1, 0))) return kWritesOn;
      const Result<void> finished = (*writer)->finish();
      return !finished && finished.error().code == ErrorCode::Io ? 0 : kFinishes;
    }
    return kNeverFull;
  });
  EXPECT_TRUE(recorder.wait_for_reports(4));
  ASSERT_EQ(recorder.wait(), 0);
  auto reader = TakeReader::open(folder / "take");
  ASSERT_THAT(reader, IsOk());
  EXPECT_FALSE((*reader)->manifest().complete);
  expect_plays_to_the_cut(**reader, GetParam(), 1);
  EXPECT_GE((*reader)->rows(0).size(), 4u);
}

INSTANTIATE_TEST_SUITE_P(AllCodecs, FullDisk,
                         testing::Values(TakeCodec::Ffv1, TakeCodec::Raw, TakeCodec::H264),
                         [](const auto& tested) {
                           return tested.param == TakeCodec::Ffv1  ? "ffv1"
                                  : tested.param == TakeCodec::Raw ? "raw"
                                                                   : "h264";
                         });

TEST(FullDisk, LeavesWholeRowsInTheSideFile) {
  const TempFolder folder;
  ChildProcess writer([&](const auto& report) -> int {
    let_files_grow_to(1000);
    auto side_file = SideFileWriter::create(folder / "a.frames.csv");
    for (std::int64_t k = 0; k < 100; ++k) {
      const Result<void> ok = side_file->write(
          {patterned_frame(PixelFormat::Gray8, 1, 1, 0, static_cast<std::uint64_t>(k)).info, k});
      if (!ok)
        return ok.error().code == ErrorCode::Io &&
                       ok.error().message.find("a.frames.csv") != std::string::npos
                   ? 0
                   : 1;
      report();
    }
    return 2;
  });
  EXPECT_TRUE(writer.wait_for_reports(5));
  ASSERT_EQ(writer.wait(), 0);
  const std::string bytes = read_file(folder / "a.frames.csv").value();
  EXPECT_EQ(bytes.size(), 1000u) << "the last row was cut in the middle";
  EXPECT_THAT(parse_frames_csv(bytes, 0, "a.frames.csv"), IsOkAnd(testing::SizeIs(testing::Ge(5u))));
}

TEST(FullDisk, LeavesNoHalfTake) {
  const TempFolder folder;
  ChildProcess writer([&](const auto&) -> int {
    let_files_grow_to(300);  // not even the rig
    const auto made = TakeWriter::create(folder / "take", small_rig(2, kWidth, kHeight), {});
    return !made && made.error().code == ErrorCode::Io ? 0 : 1;
  });
  ASSERT_EQ(writer.wait(), 0);
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(FullDisk, LeavesNoHalfVideo) {
  const TempFolder folder;
  ChildProcess writer([&](const auto&) -> int {
    let_files_grow_to(30'000);
    auto video = VideoWriter::create(folder / "a.mp4", kWidth, kHeight, 25);
    if (!video) return 1;
    Result<void> ok;
    for (std::uint64_t k = 0; k < 200 && ok; ++k)
      ok = (*video)->write(to_rgb(patterned_frame(PixelFormat::Rgb8, kWidth, kHeight, 0, k)).value());
    if (ok) ok = (*video)->finish();
    return !ok && ok.error().code == ErrorCode::Io && ok.error().message.find("a.mp4") != std::string::npos
               ? 0
               : 2;
  });
  ASSERT_EQ(writer.wait(), 0);
  EXPECT_THAT(folder.names(), IsEmpty());
}

}  // namespace
}  // namespace floatstage::capture
