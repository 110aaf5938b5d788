// What a TakeWriter does not record, and what it leaves alone.

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/take.h"
#include "core/file.h"
#include "tests/capture/pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(TakeWriter, NeverOverwrites) {
  const TempFolder folder;
  record_small_take(folder / "take", 1, 2);
  const std::string before = read_file(folder / "take" / "cam0.mkv").value();
  EXPECT_THAT(TakeWriter::create(folder / "take", small_rig(1, 8, 8), {}),
              FailsWith(ErrorCode::AlreadyExists, "is not empty"));
  EXPECT_EQ(read_file(folder / "take" / "cam0.mkv").value(), before);

  folder.write("notes.txt", "mine");
  EXPECT_THAT(TakeWriter::create(folder.path(), small_rig(1, 8, 8), {}),
              FailsWith(ErrorCode::AlreadyExists, "is not empty"));
  EXPECT_THAT(folder.names(), ElementsAre("notes.txt", "take"));
}

TEST(TakeWriter, RecordsIntoAnEmptyFolder) {
  const TempFolder folder;
  EXPECT_THAT(TakeWriter::create(folder.path(), small_rig(1, 8, 8), {}), IsOk());
}

TEST(TakeWriter, SaysWhichFolderCannotBeMade) {
  const TempFolder folder;
  folder.write("file", "");
  EXPECT_THAT(TakeWriter::create(folder / "file" / "take", small_rig(1, 8, 8), {}),
              FailsWith(ErrorCode::Io, "file/take"));
  EXPECT_THAT(TakeWriter::create("/proc/take", small_rig(1, 8, 8), {}),
              FailsWith(ErrorCode::Io, "/proc/take"));
}

TEST(TakeWriter, RefusesARigThatIsNone) {
  const TempFolder folder;
  EXPECT_THAT(TakeWriter::create(folder / "take", {}, {}),
              FailsWith(ErrorCode::InvalidArgument, "no camera"));
  Rig rig = small_rig(2, 8, 8);
  rig.cameras[1].model.fx = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(TakeWriter::create(folder / "take", rig, {}), FailsWith(ErrorCode::InvalidArgument, "cam1"));
  rig = small_rig(2, 8, 8);
  rig.cameras[1].serial = "cam0";
  EXPECT_THAT(TakeWriter::create(folder / "take", rig, {}),
              FailsWith(ErrorCode::InvalidArgument, "two cameras"));
  EXPECT_THAT(folder.names(), IsEmpty());
}

TEST(TakeWriter, RefusesARateThatIsNone) {
  const TempFolder folder;
  for (const double rate : {-1.0, 1e9, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THAT(TakeWriter::create(folder / "take", small_rig(1, 8, 8),
                                   {.frame_rate = rate, .label = {}, .created = {}}),
                FailsWith(ErrorCode::InvalidArgument, "frames per second"));
  EXPECT_THAT(
      TakeWriter::create(folder / "take", small_rig(1, 8, 8), {.frame_rate = 0, .label = {}, .created = {}}),
      IsOk())
      << "0 is a take of one instant";
}

class RefusedFrame : public testing::Test {
 protected:
  void SetUp() override { writer_ = TakeWriter::create(folder_ / "take", small_rig(2, 16, 12), {}).value(); }

  Frame good(std::uint64_t sequence) { return patterned_frame(PixelFormat::Gray8, 16, 12, 0, sequence); }

  // After any refusal the camera goes on as if nothing had been asked.
  void TearDown() override {
    EXPECT_THAT(writer_->write(good(10)), IsOk());
    EXPECT_THAT(writer_->write(good(11)), IsOk());
    ASSERT_THAT(writer_->finish(), IsOk());
    auto reader = TakeReader::open(folder_ / "take");
    ASSERT_THAT(reader, IsOk());
    const Result<Frame> last = (*reader)->frame(0, static_cast<int>((*reader)->rows(0).size()) - 1);
    ASSERT_THAT(last, IsOk());
    EXPECT_TRUE(same_pixels(*last, good(11)));
  }

  TempFolder folder_;
  std::unique_ptr<TakeWriter> writer_;
};

TEST_F(RefusedFrame, OfACameraThatIsNotThere) {
  Frame frame = good(0);
  for (const int camera : {-1, 2}) {
    frame.info.camera = camera;
    EXPECT_THAT(writer_->write(frame), FailsWith(ErrorCode::InvalidArgument, "the take has 2 cameras"));
  }
}

TEST_F(RefusedFrame, OfAnotherSizeThanTheRig) {
  EXPECT_THAT(writer_->write(patterned_frame(PixelFormat::Gray8, 17, 12, 0, 0)),
              FailsWith(ErrorCode::InvalidArgument, "17x12"));
}

TEST_F(RefusedFrame, OfAnotherFormatThanTheFirst) {
  ASSERT_THAT(writer_->write(good(0)), IsOk());
  EXPECT_THAT(writer_->write(patterned_frame(PixelFormat::Rgb8, 16, 12, 0, 1)),
              FailsWith(ErrorCode::InvalidArgument, "rgb8"));
}

TEST_F(RefusedFrame, ThatIsCompressed) {
  Frame frame = good(0);
  frame.layout.format = PixelFormat::Mjpeg;
  EXPECT_THAT(writer_->write(frame), FailsWith(ErrorCode::Unsupported, "MJPEG"));
}

TEST_F(RefusedFrame, WhoseBufferIsTooShort) {
  Frame frame = good(0);
  frame.layout.size_bytes -= 1;
  EXPECT_THAT(writer_->write(frame), FailsWith(ErrorCode::InvalidArgument, "too short"));
  frame = good(0);
  frame.layout.stride = 15;
  EXPECT_THAT(writer_->write(frame), FailsWith(ErrorCode::InvalidArgument, "too short"));
}

TEST_F(RefusedFrame, ThatWasLostButHasPixels) {
  Frame frame = good(0);
  frame.info.status = FrameStatus::Lost;
  EXPECT_THAT(writer_->write(frame), FailsWith(ErrorCode::InvalidArgument, "has pixels"));
}

TEST_F(RefusedFrame, ThatComesTwiceOrLate) {
  ASSERT_THAT(writer_->write(good(3)), IsOk());
  EXPECT_THAT(writer_->write(good(3)), FailsWith(ErrorCode::InvalidArgument, "does not follow 3"));
  EXPECT_THAT(writer_->write(good(2)), FailsWith(ErrorCode::InvalidArgument, "does not follow 3"));
}

TEST_F(RefusedFrame, WhoseCounterWasReset) {
  ASSERT_THAT(writer_->write(good(3)), IsOk());
  EXPECT_THAT(writer_->write(good(1'000'000'000)), FailsWith(ErrorCode::InvalidArgument, "counter"));
}

TEST(TakeWriter, IsFinishedOnce) {
  const TempFolder folder;
  auto writer = TakeWriter::create(folder / "take", small_rig(1, 8, 8), {});
  ASSERT_THAT(writer, IsOk());
  ASSERT_THAT((*writer)->finish(), IsOk());
  EXPECT_THAT((*writer)->finish(), FailsWith(ErrorCode::InvalidArgument, "finished already"));
  EXPECT_THAT((*writer)->write(patterned_frame(PixelFormat::Gray8, 8, 8, 0, 0)),
              FailsWith(ErrorCode::InvalidArgument, "finished"));
}

TEST(TakeWriter, NamesACodecThatCannotHoldThePicture) {
  const TempFolder folder;
  TakeWriterOptions options;
  options.codec = TakeCodec::H264;
  auto writer = TakeWriter::create(folder / "take", small_rig(1, 17, 13), options);
  ASSERT_THAT(writer, IsOk());
  EXPECT_THAT((*writer)->write(patterned_frame(PixelFormat::Nv12, 17, 13, 0, 0)),
              FailsWith(ErrorCode::Unsupported, "17x13 nv12"));
}

TEST(TakeWriter, HoldsNoPictureForWhichTheEncoderNeedsGigabytes) {
  const TempFolder folder;
  auto writer = TakeWriter::create(folder / "take", small_rig(1, 6000, 5200), {});
  ASSERT_THAT(writer, IsOk());
  FrameInfo info;
  info.camera = 0;
  EXPECT_THAT((*writer)->write(make_frame(info, Image(6000, 5200, 3))),
              FailsWith(ErrorCode::Unsupported, "6000x5200 rgb8 pictures are too large for FFV1"));
}

}  // namespace
}  // namespace floatstage::capture
