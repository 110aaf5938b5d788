#include "capture/recorder.h"

#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/text.h"
#include "tests/capture/pictures.h"
#include "tests/support/child_process.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;

constexpr std::int64_t kPeriod = 40'000'000;  // 25 frames a second

RecorderOptions options_at(double rate = 25, TakeCodec codec = TakeCodec::Raw) {
  RecorderOptions options;
  options.take.codec = codec;
  options.take.frame_rate = rate;
  return options;
}

Frame shot(int camera, std::uint64_t sequence, std::int64_t ns) {
  Frame frame = patterned_frame(PixelFormat::Rgb8, 32, 24, camera, sequence);
  frame.info.exposure_start = {ns};
  return frame;
}

class ARecorder : public testing::Test {
 protected:
  std::unique_ptr<Recorder> started(int cameras, RecorderOptions options = options_at()) {
    Result<std::unique_ptr<Recorder>> recorder = Recorder::start(take_, small_rig(cameras, 32, 24), options);
    EXPECT_THAT(recorder, IsOk());
    return recorder ? std::move(*recorder) : nullptr;
  }
  /// "oo.o": the rows of a camera, a dot for a gap.
  std::string rows(int camera) {
    const Result<std::unique_ptr<TakeReader>> take = TakeReader::open(take_);
    EXPECT_THAT(take, IsOk());
    std::string row;
    for (const FrameRow& r : (*take)->rows(camera)) row += r.media_index ? 'o' : '.';
    return row;
  }

  TempFolder folder_;
  std::filesystem::path take_ = folder_ / "take";
};

TEST_F(ARecorder, WritesEveryPictureAndPasses) {
  const auto recorder = started(2);
  for (std::uint64_t i = 0; i < 10; ++i)
    for (int camera = 0; camera < 2; ++camera)
      ASSERT_THAT(recorder->push(shot(camera, i, static_cast<std::int64_t>(i) * kPeriod + camera * 100'000)),
                  IsOk());
  const Result<RecordingQuality> quality = recorder->finish();
  ASSERT_THAT(quality, IsOk());
  EXPECT_TRUE(quality->pass());
  EXPECT_EQ(rows(0), "oooooooooo");
  EXPECT_EQ(quality->cameras[1].recorded, 10u);
  EXPECT_NEAR(quality->cameras[1].frame_rate, 25, 1e-9);
  EXPECT_NEAR(quality->spread_max_ms, 0.1, 1e-9);
  const Result<std::unique_ptr<TakeReader>> take = TakeReader::open(take_);
  EXPECT_TRUE(same_pixels(*(*take)->frame(1, 7), shot(1, 7, 0)));
}

TEST_F(ARecorder, LeavesARowForEveryLostFrame) {
  const auto recorder = started(1);
  for (const std::uint64_t i : {0, 1, 4, 5})
    ASSERT_THAT(recorder->push(shot(0, i, static_cast<std::int64_t>(i) * kPeriod)), IsOk());
  const Result<RecordingQuality> quality = recorder->finish();
  EXPECT_EQ(rows(0), "oo..oo");
  EXPECT_EQ(quality->cameras[0].skips, 2u);
  EXPECT_THAT(quality->complaints, ElementsAre(HasSubstr("camera 'cam0': 2 frames are missing")));
}

TEST_F(ARecorder, PutsCamerasThatCountDifferentlyIntoTheSameRows) {
  // Camera 1 has streamed for a while and its first picture here is of the third instant.
  const auto recorder = started(2);
  for (std::uint64_t i = 0; i < 6; ++i)
    ASSERT_THAT(recorder->push(shot(0, i, static_cast<std::int64_t>(i) * kPeriod)), IsOk());
  for (std::uint64_t i = 2; i < 6; ++i)
    ASSERT_THAT(recorder->push(shot(1, 7000 + i, static_cast<std::int64_t>(i) * kPeriod + 300'000)), IsOk());
  const Result<RecordingQuality> quality = recorder->finish();
  EXPECT_EQ(rows(1), "..oooo");
  EXPECT_EQ(quality->cameras[1].skips, 2u);
  EXPECT_NEAR(quality->spread_max_ms, 0.3, 1e-9);
  const Result<std::unique_ptr<TakeReader>> take = TakeReader::open(take_);
  const Result<FrameSet> set = (*take)->frame_set(4);
  ASSERT_THAT(set, IsOk());
  EXPECT_EQ(set->frames[0].info.exposure_start.ns + 300'000, set->frames[1].info.exposure_start.ns);
}

// A camera that stamps arrivals, most of a period after its exposures.
TEST_F(ARecorder, FindsRowsByInstantsWhereStampsAreKnownToBeOff) {
  constexpr std::int64_t kLag = 30'000'000;
  RecorderOptions options = options_at();
  options.times = {
      "targets",
      {{"cam0", Nanoseconds{0}, Nanoseconds{0}, ""}, {"cam1", Nanoseconds{-kLag}, Nanoseconds{100'000}, ""}}};
  const auto recorder = started(2, options);
  for (std::uint64_t i = 0; i < 8; ++i)
    for (int camera = 0; camera < 2; ++camera)
      ASSERT_THAT(recorder->push(shot(camera, i, static_cast<std::int64_t>(i) * kPeriod + camera * kLag)),
                  IsOk());
  const Result<RecordingQuality> quality = recorder->finish();
  ASSERT_THAT(quality, IsOk());
  EXPECT_TRUE(quality->pass());
  EXPECT_EQ(rows(1), "oooooooo");
  EXPECT_NEAR(quality->spread_max_ms, 0, 1e-9);
  const Result<std::unique_ptr<TakeReader>> take = TakeReader::open(take_);
  EXPECT_EQ((*take)->rows(1)[3].info.exposure_start, (Timestamp{3 * kPeriod + kLag}));  // stamps stay
  const Result<TimeOffsetFile> kept = load_time_offsets((*take)->layout());
  ASSERT_THAT(kept, IsOk());
  EXPECT_EQ(*kept, options.times);
}

TEST_F(ARecorder, LeavesOutWhatWasSeenBeforeTheFirstRow) {
  const auto recorder = started(2);
  ASSERT_THAT(recorder->push(shot(0, 50, 10 * kPeriod)), IsOk());
  for (std::uint64_t i = 8; i < 12; ++i)
    ASSERT_THAT(recorder->push(shot(1, i, static_cast<std::int64_t>(i) * kPeriod)), IsOk());
  ASSERT_THAT(recorder->finish(), IsOk());
  EXPECT_EQ(rows(0), "o.");
  EXPECT_EQ(rows(1), "oo");
}

TEST_F(ARecorder, GivesACameraThatMissesTriggersWithoutCountingThemItsPlaceBack) {
  // A fake camera that is late skips a tick and counts on as if nothing had been.
  const auto recorder = started(2);
  for (std::uint64_t i = 0; i < 8; ++i)
    ASSERT_THAT(recorder->push(shot(0, i, static_cast<std::int64_t>(i) * kPeriod)), IsOk());
  std::uint64_t counted = 0;
  for (const std::int64_t i : {0, 1, 3, 4, 7})
    ASSERT_THAT(recorder->push(shot(1, counted++, i * kPeriod + 200'000)), IsOk());
  const Result<RecordingQuality> quality = recorder->finish();
  EXPECT_EQ(rows(1), "oo.oo..o");
  EXPECT_EQ(quality->cameras[1].skips, 3u);
  EXPECT_EQ(quality->cameras[1].unexposed, 3u);
  EXPECT_NEAR(quality->spread_max_ms, 0.2, 1e-6);
  EXPECT_NEAR(quality->cameras[1].frame_rate, 25.0 * 4 / 7, 0.1) << "what it exposed, not what was expected";
}

TEST_F(ARecorder, KnowsWhatWasLostOnTheWayFromWhatWasNeverExposed) {
  const auto recorder = started(1);
  ASSERT_THAT(recorder->push(shot(0, 0, 0), 40), IsOk());
  ASSERT_THAT(recorder->push(shot(0, 3, 3 * kPeriod), 42), IsOk());  // two failed
  ASSERT_THAT(recorder->push(shot(0, 4, 6 * kPeriod), 42), IsOk());  // two never exposed
  const Result<RecordingQuality> quality = recorder->finish();
  EXPECT_EQ(rows(0), "o..o..o");
  EXPECT_EQ(quality->cameras[0].skips, 4u);
  EXPECT_EQ(quality->cameras[0].unexposed, 2u);
  EXPECT_EQ(quality->cameras[0].lost, 2u);
  EXPECT_EQ(quality->cameras[0].failed, 2u);
}

TEST_F(ARecorder, CountsAPictureThatCameLateAsExposedThoughItsRowIsEmpty) {
  const auto recorder = started(1);
  // Picture 2 comes 0.9 periods late and stands in row 3; of pictures 3 to 5 two are lost.
  for (const auto& [sequence, row, failed] :
       {std::tuple{0, 0.0, 0}, {1, 1.0, 0}, {2, 2.9, 0}, {5, 5.0, 2}, {6, 6.0, 2}})
    ASSERT_THAT(recorder->push(shot(0, static_cast<std::uint64_t>(sequence),
                                    static_cast<std::int64_t>(row * static_cast<double>(kPeriod))),
                               static_cast<std::uint64_t>(failed)),
                IsOk());
  const Result<RecordingQuality> quality = recorder->finish();
  EXPECT_EQ(rows(0), "oo.o.oo");
  EXPECT_EQ(quality->cameras[0].skips, 2u);
  EXPECT_EQ(quality->cameras[0].lost, 2u);
  EXPECT_EQ(quality->cameras[0].unexposed, 0u);
}

TEST_F(ARecorder, EndsWithTheFirstInstantThatAllCamerasSaw) {
  const auto recorder = started(3);
  const auto push = [&](int camera, std::int64_t i) {
    ASSERT_THAT(recorder->push(shot(camera, static_cast<std::uint64_t>(i), i * kPeriod)), IsOk());
  };
  for (int camera = 0; camera < 3; ++camera)
    for (std::int64_t i = 0; i < 4; ++i) push(camera, i);
  recorder->end_at({4 * kPeriod + 1000});
  for (std::int64_t i = 4; i < 9; ++i) push(0, i);    // the fast one goes on
  for (const std::int64_t i : {5, 6, 7}) push(1, i);  // loses row 4
  EXPECT_FALSE(recorder->ended());
  for (const std::int64_t i : {4, 6, 7}) push(2, i);  // loses row 5
  EXPECT_TRUE(recorder->ended());
  const Result<RecordingQuality> quality = recorder->finish();
  EXPECT_EQ(rows(0), "ooooooo");
  EXPECT_EQ(rows(1), "oooo.oo");
  EXPECT_EQ(rows(2), "ooooo.o");
  EXPECT_EQ(quality->cameras[1].skips, 1u);
}

TEST_F(ARecorder, EndsWithoutACameraThatIsGone) {
  const auto recorder = started(3);
  for (int camera = 0; camera < 3; ++camera)
    for (std::int64_t i = 0; i < 4; ++i)
      ASSERT_THAT(recorder->push(shot(camera, static_cast<std::uint64_t>(i), i * kPeriod)), IsOk());
  recorder->end_at({4 * kPeriod});
  for (std::int64_t i = 4; i < 8; ++i)
    ASSERT_THAT(recorder->push(shot(0, static_cast<std::uint64_t>(i), i * kPeriod)), IsOk());
  ASSERT_THAT(recorder->push(shot(1, 4, 4 * kPeriod)), IsOk());
  EXPECT_FALSE(recorder->ended());
  const Result<RecordingQuality> quality = recorder->finish();
  EXPECT_EQ(rows(0), "ooooo");
  EXPECT_EQ(rows(1), "ooooo");
  EXPECT_EQ(rows(2), "oooo.");
  EXPECT_EQ(quality->cameras[2].skips, 1u);
}

TEST_F(ARecorder, BeginsAtTheInstantItIsGiven) {
  RecorderOptions options = options_at();
  options.origin = Timestamp{2 * kPeriod};
  const auto recorder = started(2, options);
  for (std::int64_t i = 0; i < 5; ++i)
    for (int camera = 0; camera < 2; ++camera)
      ASSERT_THAT(recorder->push(shot(camera, static_cast<std::uint64_t>(i), i * kPeriod - camera * 90'000)),
                  IsOk());
  ASSERT_THAT(recorder->finish(), IsOk());
  EXPECT_EQ(rows(0), "ooo");
  EXPECT_EQ(rows(1), "ooo");
}

TEST_F(ARecorder, SavesItsVerdictWhileItGrows) {
  const auto recorder = started(1);
  ASSERT_THAT(recorder->push(shot(0, 0, 0)), IsOk());
  ASSERT_THAT(recorder->save_quality(), IsOk());
  EXPECT_TRUE(nlohmann::json::parse(*read_file(take_ / "quality.json")).contains("verdict"));
}

TEST_F(ARecorder, FindsTheRowsOfACameraThatWasStartedAgainByItsTimes) {
  const auto recorder = started(1);
  for (std::uint64_t i = 0; i < 3; ++i)
    ASSERT_THAT(recorder->push(shot(0, i, static_cast<std::int64_t>(i) * kPeriod)), IsOk());
  recorder->restarted(0);
  for (std::uint64_t i = 0; i < 2; ++i)
    ASSERT_THAT(recorder->push(shot(0, i, static_cast<std::int64_t>(i + 6) * kPeriod + 1000)), IsOk());
  const Result<RecordingQuality> quality = recorder->finish();
  EXPECT_EQ(rows(0), "ooo...oo");
  EXPECT_EQ(quality->cameras[0].skips, 3u);
  EXPECT_EQ(quality->cameras[0].duplicates, 0u);
}

TEST_F(ARecorder, CountsAFrameThatComesTwiceAndWritesItOnce) {
  const auto recorder = started(1);
  for (const std::uint64_t i : {0, 1, 1, 2})
    ASSERT_THAT(recorder->push(shot(0, i, static_cast<std::int64_t>(i) * kPeriod)), IsOk());
  const Result<RecordingQuality> quality = recorder->finish();
  EXPECT_EQ(rows(0), "ooo");
  EXPECT_THAT(quality->complaints, ElementsAre(HasSubstr("1 frames came twice")));
}

TEST_F(ARecorder, KnowsThatARowWasNotExposedWhereItsPictureWentToTheRowBefore) {
  const auto recorder = started(1);
  // Picture 3 comes a period early, so row 3 has none: it was neither lost nor counted for it.
  for (const auto& [sequence, row] : {std::pair{0, 0.0}, {1, 1.0}, {2, 2.0}, {3, 2.2}, {4, 4.0}, {5, 5.0}})
    ASSERT_THAT(recorder->push(shot(0, static_cast<std::uint64_t>(sequence),
                                    static_cast<std::int64_t>(row * static_cast<double>(kPeriod)))),
                IsOk());
  const Result<RecordingQuality> quality = recorder->finish();
  ASSERT_THAT(quality, IsOk());
  EXPECT_EQ(rows(0), "ooo.oo");
  EXPECT_EQ(quality->cameras[0].duplicates, 1u);
  EXPECT_EQ(quality->cameras[0].skips, 1u);
  EXPECT_EQ(quality->cameras[0].unexposed, 1u);
  EXPECT_EQ(quality->cameras[0].lost, 0u);
  EXPECT_NEAR(quality->cameras[0].frame_rate, 25, 1e-9);
}

TEST_F(ARecorder, FailsATakeWhoseCamerasDisagreeOrRunSlow) {
  const auto recorder = started(2);
  for (std::uint64_t i = 0; i < 10; ++i) {
    const auto at = static_cast<std::int64_t>(i) * kPeriod * 11 / 10;
    ASSERT_THAT(recorder->push(shot(0, i, at)), IsOk());
    ASSERT_THAT(recorder->push(shot(1, i, at + 5'000'000)), IsOk());
  }
  const Result<RecordingQuality> quality = recorder->finish();
  EXPECT_THAT(quality->complaints,
              IsSupersetOf({HasSubstr("camera 'cam0': 22.7"), HasSubstr("camera 'cam1': 22.7"),
                            HasSubstr("up to 5 ms apart")}));
}

TEST_F(ARecorder, SaysWhichCameraNeverCame) {
  const auto recorder = started(2);
  ASSERT_THAT(recorder->push(shot(0, 0, 0)), IsOk());
  EXPECT_THAT(recorder->finish()->complaints,
              ElementsAre(HasSubstr("camera 'cam1': no picture was recorded")));
  EXPECT_EQ(rows(1), ".") << "all cameras have equally many rows";
}

TEST_F(ARecorder, WritesItsVerdictBesideTheTake) {
  const auto recorder = started(1);
  for (std::uint64_t i = 0; i < 3; ++i)
    ASSERT_THAT(recorder->push(shot(0, i, static_cast<std::int64_t>(i) * kPeriod)), IsOk());
  ASSERT_THAT(recorder->finish(), IsOk());
  const nlohmann::json json = nlohmann::json::parse(*read_file(take_ / "quality.json"));
  EXPECT_EQ(json["verdict"], "PASS");
  EXPECT_EQ(json["cameras"][0]["recorded"], 3);
  EXPECT_EQ(json["cameras"][0]["skips"], 0);
  EXPECT_THAT(json["complaints"], IsEmpty());
}

TEST_F(ARecorder, TakesEachCameraFromAThreadOfItsOwn) {
  const auto recorder = started(4, options_at(25, TakeCodec::Ffv1));
  std::vector<std::thread> cameras;
  for (int camera = 0; camera < 4; ++camera) {
    cameras.emplace_back([&, camera] {
      for (std::uint64_t i = 0; i < 30; ++i)
        EXPECT_THAT(recorder->push(shot(camera, i, static_cast<std::int64_t>(i) * kPeriod)), IsOk());
    });
  }
  EXPECT_LE(recorder->quality().cameras[0].recorded, 30u);
  for (std::thread& camera : cameras) camera.join();
  ASSERT_THAT(recorder->finish(), IsOk());
  for (int camera = 0; camera < 4; ++camera) EXPECT_EQ(rows(camera), std::string(30, 'o'));
}

TEST_F(ARecorder, KeepsWhatWasWrittenWhenTheDiskIsFull) {
  ChildProcess child([&](const std::function<void()>&) {
    let_files_grow_to(20'000);
    const auto recorder = started(2);
    Result<void> pushed;
    for (std::uint64_t i = 0; i < 200 && pushed; ++i)
      pushed = recorder->push(shot(0, i, static_cast<std::int64_t>(i) * kPeriod));
    const Result<RecordingQuality> finished = recorder->finish();
    return !finished && finished.error().code == ErrorCode::Io ? 0 : 1;
  });
  EXPECT_EQ(child.wait(), 0);
  const Result<std::unique_ptr<TakeReader>> take = TakeReader::open(take_);
  ASSERT_THAT(take, IsOk());
  EXPECT_GT((*take)->rows(0).size(), 2u);
}

TEST_F(ARecorder, RefusesToBeginWithoutARateOrOverATake) {
  EXPECT_THAT(Recorder::start(take_, small_rig(1, 32, 24), options_at(0)),
              FailsWith(ErrorCode::InvalidArgument, "frame rate"));
  ASSERT_THAT(started(1)->finish(), IsOk());
  EXPECT_THAT(Recorder::start(take_, small_rig(1, 32, 24), options_at()),
              FailsWith(ErrorCode::AlreadyExists, ""));
}

TEST(Detached, FramesKeepTheirPixelsWhenTheBufferIsReused) {
  const Frame frame = shot(0, 3, 0);
  const Frame own = detached(frame);
  EXPECT_NE(own.pixels, frame.pixels);
  EXPECT_TRUE(same_pixels(own, frame));
  EXPECT_EQ(own.info, frame.info);
  EXPECT_TRUE(detached(lost_frame(0, 1)).empty());
}

}  // namespace
}  // namespace floatstage::capture
