#include "matting/video/video_matting.h"

#include <atomic>
#include <filesystem>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "matting/guided_upsample.h"
#include "tests/matting/small_scenes.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::matting {
namespace {

using testing::ElementsAre;

constexpr int kWidth = 90, kHeight = 60, kFrames = 14;  // more than one run of the store

DiscPicture frame_of(int frame) { return disc_picture(kWidth, kHeight, 1.5 * frame); }

MattingClip clip_of(int frames) {
  return {frames, [](int frame) -> Result<Image> { return frame_of(frame).rgb; }};
}

VideoMatting open(const std::filesystem::path& cache, MattingClip clip,
                  const VideoMattingOptions& options = {}) {
  auto video = VideoMatting::create(std::move(clip), cache, options);
  EXPECT_THAT(video, IsOk());
  return std::move(*video);
}

std::vector<int> range(int first, int last) {
  std::vector<int> out;
  for (int i = first; i <= last; ++i) out.push_back(i);
  return out;
}

Image matte_at(const VideoMatting& video, int frame) {
  const auto matte = video.working_matte(frame);
  EXPECT_THAT(matte, IsOk());
  return matte ? *matte : Image();
}

MatteConstraint click(int x, int y, int opacity) {
  MatteConstraint said{Image(kWidth, kHeight, 1), Image(kWidth, kHeight, 1)};
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      *said.opacity.at(x + dx, y + dy) = static_cast<std::uint8_t>(opacity);
      *said.weight.at(x + dx, y + dy) = 255;
    }
  return said;
}

// One prepared clip for the tests that only propagate.
class VideoMattingOfADisc : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    VideoMatting video = open(folder_->path(), clip_of(kFrames), {.threads = 2});
    ASSERT_THAT(video.prepare(), IsOk());
    ASSERT_EQ(video.usable(), kFrames);
  }
  static void TearDownTestSuite() { delete folder_; }

  static VideoMatting prepared(const VideoMattingOptions& options = {}, MattingClip clip = clip_of(kFrames)) {
    VideoMatting video = open(folder_->path(), std::move(clip), options);
    EXPECT_THAT(video.prepare(), IsOk());
    return video;
  }
  static TempFolder* folder_;
};
TempFolder* VideoMattingOfADisc::folder_ = nullptr;

TEST_F(VideoMattingOfADisc, CarriesOneMatteThroughTheClip) {
  VideoMatting video = prepared();
  ASSERT_THAT(video.set_keyframe(0, {frame_of(0).alpha, {}}), IsOk());
  EXPECT_THAT(video.propagate(), IsOkAnd(testing::Eq(range(0, kFrames - 1))));
  EXPECT_EQ(matte_at(video, 0), frame_of(0).alpha) << "a whole matte is taken as it is";
  for (int frame = 1; frame < kFrames; ++frame) {
    EXPECT_LT(mean_square(matte_at(video, frame), frame_of(frame).alpha), 4e-3) << "frame " << frame;
    EXPECT_LT(video.report(frame).flicker, 0.05);
  }
  EXPECT_TRUE(video.report(0).keyframe);
  EXPECT_FALSE(video.report(1).keyframe);
}

TEST_F(VideoMattingOfADisc, CarriesOneClickForwardsAndBackwards) {
  VideoMatting video = prepared();
  ASSERT_THAT(video.set_keyframe(6, click(50, 30, 255)), IsOk());
  ASSERT_THAT(video.propagate(), IsOk());
  for (int frame = 0; frame < kFrames; ++frame)
    EXPECT_LT(mean_square(matte_at(video, frame), frame_of(frame).alpha), 6e-3) << "frame " << frame;
}

TEST_F(VideoMattingOfADisc, MakesOnlyWhatIsStaleBetweenKeyframes) {
  VideoMatting video = prepared();
  for (int frame : {0, 4, 9}) ASSERT_THAT(video.set_keyframe(frame, {frame_of(frame).alpha, {}}), IsOk());
  ASSERT_THAT(video.propagate(), IsOkAnd(testing::SizeIs(kFrames)));
  EXPECT_THAT(video.propagate(), IsOkAnd(testing::IsEmpty()));
  const Image before = matte_at(video, 2), after = matte_at(video, 12);
  ASSERT_THAT(video.set_keyframe(6, {frame_of(6).alpha, {}}), IsOk());
  EXPECT_THAT(video.working_matte(5), FailsWith(ErrorCode::NotFound, "frame 5"));
  EXPECT_THAT(video.propagate(), IsOkAnd(testing::Eq(range(4, 9))));
  EXPECT_EQ(matte_at(video, 2), before);
  EXPECT_EQ(matte_at(video, 12), after);
  video.remove_keyframe(6);
  EXPECT_THAT(video.propagate(), IsOkAnd(testing::Eq(range(4, 9))));
}

TEST_F(VideoMattingOfADisc, MakesASpanAloneAsItMakesItWithTheOthers) {
  VideoMatting whole = prepared(), part = prepared();
  for (VideoMatting* video : {&whole, &part})
    for (int frame : {2, 6, 10}) ASSERT_THAT(video->set_keyframe(frame, {frame_of(frame).alpha, {}}), IsOk());
  ASSERT_THAT(whole.propagate(), IsOk());
  EXPECT_THAT(part.propagate(nullptr, 7, 9), IsOkAnd(testing::Eq(range(6, 10))));
  for (int frame = 6; frame <= 10; ++frame) EXPECT_EQ(matte_at(part, frame), matte_at(whole, frame)) << frame;
  EXPECT_THAT(part.working_matte(3), FailsWith(ErrorCode::NotFound, "frame 3"));
  ASSERT_THAT(part.propagate(), IsOk());
  for (int frame = 0; frame < kFrames; ++frame)
    EXPECT_EQ(matte_at(part, frame), matte_at(whole, frame)) << frame;
}

TEST_F(VideoMattingOfADisc, StopsOnTheWayAndGoesOn) {
  VideoMatting video = prepared();
  ASSERT_THAT(video.set_keyframe(0, {frame_of(0).alpha, {}}), IsOk());
  int calls = 0;
  EXPECT_THAT(video.propagate([&](int) { return ++calls < 4; }), FailsWith(ErrorCode::Cancelled, "stopped"));
  EXPECT_EQ(calls, 4);
  EXPECT_THAT(video.propagate(), IsOkAnd(testing::SizeIs(kFrames)));
}

TEST(MatteFlicker, SeesAMatteJumpButNotTheSubjectMove) {
  const DiscPicture a = disc_picture(kWidth, kHeight, 0), b = disc_picture(kWidth, kHeight, 3);
  const Result<double> moved = matte_flicker(a.rgb, a.alpha, b.rgb, b.alpha),
                       still = matte_flicker(a.rgb, a.alpha, a.rgb, a.alpha);
  const Result<double> gone = matte_flicker(a.rgb, a.alpha, b.rgb, Image(kWidth, kHeight, 1));
  ASSERT_THAT(moved, IsOk());
  ASSERT_THAT(still, IsOk());
  ASSERT_THAT(gone, IsOk());
  EXPECT_LT(*still, 1e-3);
  EXPECT_LT(*moved, 0.02);
  EXPECT_GT(*gone, 5 * *moved);
  EXPECT_THAT(matte_flicker(a.rgb, a.alpha, b.rgb, Image(3, 3, 1)),
              FailsWith(ErrorCode::InvalidArgument, "one size"));
}

TEST_F(VideoMattingOfADisc, DoesNotDependOnTheOrderOfEdits) {
  VideoMatting together = prepared(), one_by_one = prepared();
  for (int frame : {3, 11}) ASSERT_THAT(together.set_keyframe(frame, {frame_of(frame).alpha, {}}), IsOk());
  ASSERT_THAT(together.propagate(), IsOk());
  for (int frame : {11, 3}) {
    ASSERT_THAT(one_by_one.set_keyframe(frame, {frame_of(frame).alpha, {}}), IsOk());
    ASSERT_THAT(one_by_one.propagate(), IsOk());
  }
  for (int frame = 0; frame < kFrames; ++frame)
    EXPECT_EQ(matte_at(together, frame), matte_at(one_by_one, frame)) << frame;
}

TEST_F(VideoMattingOfADisc, LetsAKeyerSpeakForTheSubject) {
  MattingClip clip = clip_of(kFrames);
  clip.likelihood = [](int frame) -> Result<MatteConstraint> {
    return MatteConstraint{frame_of(frame).alpha, {}};
  };
  VideoMatting video = prepared({}, std::move(clip));
  ASSERT_THAT(video.propagate(), IsOk());
  for (int frame = 0; frame < kFrames; ++frame)
    EXPECT_LT(mean_square(matte_at(video, frame), frame_of(frame).alpha), 5e-3) << frame;
}

TEST_F(VideoMattingOfADisc, GoesOnFromAKeyThatNoComponentsCameNear) {
  MattingClip clip = clip_of(kFrames);
  Image slanted(kWidth, kHeight,
                1);  // a key that went wrong in the first frame: no component ends along its edge
  for (int y = 0; y < kHeight; ++y)
    std::fill_n(slanted.at(0, y), kWidth * (y + 1) / kHeight, std::uint8_t{255});
  clip.likelihood = [&](int frame) -> Result<MatteConstraint> {
    return MatteConstraint{frame == 0 ? slanted : frame_of(frame).alpha, {}};
  };
  VideoMatting video = prepared({.likelihood_is_matte = true}, std::move(clip));
  ASSERT_THAT(video.propagate(), IsOk());
  EXPECT_EQ(matte_at(video, 0), slanted);
  EXPECT_FALSE(video.report(1).fits)
      << "components are the disc, the carried key is not: closed form begins at the key";
}

TEST_F(VideoMattingOfADisc, GuessesWhenNobodySaysAnything) {
  VideoMatting video = prepared();
  ASSERT_THAT(video.propagate(), IsOk());
  EXPECT_LT(mean_square(matte_at(video, 0), frame_of(0).alpha), 0.01);
}

TEST_F(VideoMattingOfADisc, RefusesKeyframesThatSayNothing) {
  VideoMatting video = prepared();
  EXPECT_THAT(video.set_keyframe(0, {Image(kWidth, kHeight, 1, 0), {}}),
              FailsWith(ErrorCode::InvalidArgument, "all background"));
  EXPECT_THAT(video.set_keyframe(0, {Image(kWidth, kHeight, 1, 255), {}}),
              FailsWith(ErrorCode::InvalidArgument, "all subject"));
  EXPECT_THAT(video.set_keyframe(0, {Image(kWidth, kHeight, 1), Image(kWidth, kHeight, 1)}),
              FailsWith(ErrorCode::InvalidArgument, "says nothing"));
  EXPECT_THAT(video.set_keyframe(99, {frame_of(0).alpha, {}}),
              FailsWith(ErrorCode::InvalidArgument, "frame 99"));
  EXPECT_THAT(video.set_keyframe(0, {frame_of(0).rgb, {}}),
              FailsWith(ErrorCode::InvalidArgument, "one channel"));
  ASSERT_THAT(video.set_keyframe(0, click(5, 5, 0)), IsOk());
  EXPECT_THAT(video.propagate(), FailsWith(ErrorCode::InvalidArgument, "background only"));
}

TEST(VideoMatting, GivesTheSameBytesAtAnyThreadCount) {
  TempFolder one, two;
  VideoMatting a = open(one.path(), clip_of(kFrames), {.threads = 1}),
               b = open(two.path(), clip_of(kFrames), {.threads = 3});
  ASSERT_THAT(a.prepare(), IsOk());
  ASSERT_THAT(b.prepare(), IsOk());
  for (int frame = 0; frame < kFrames; ++frame)
    EXPECT_EQ(a.components(frame)->alpha, b.components(frame)->alpha) << frame;
}

TEST(VideoMatting, GoesOnWhereItWasStoppedWithTheSameBytes) {
  TempFolder whole, cut;
  VideoMatting reference = open(whole.path(), clip_of(5));
  ASSERT_THAT(reference.prepare(), IsOk());
  {
    VideoMatting video = open(cut.path(), clip_of(5), {.threads = 1});
    EXPECT_THAT(video.prepare([](int frame) { return frame < 2; }),
                FailsWith(ErrorCode::Cancelled, "stopped"));
  }
  // What was being written is cut off.
  const auto last = cut.path() / "000002.components";
  ASSERT_TRUE(std::filesystem::exists(last));
  std::filesystem::resize_file(last, std::filesystem::file_size(last) / 2);
  const auto first = std::filesystem::last_write_time(cut.path() / "000000.components");
  VideoMatting video = open(cut.path(), clip_of(5));
  ASSERT_THAT(video.prepare(), IsOk());
  EXPECT_EQ(std::filesystem::last_write_time(cut.path() / "000000.components"), first) << "not made again";
  for (int frame = 0; frame < 5; ++frame)
    EXPECT_EQ(video.components(frame)->alpha, reference.components(frame)->alpha) << frame;
}

TEST(VideoMatting, MakesStaleFilesAgain) {
  TempFolder folder;
  {
    VideoMatting video = open(folder.path(), clip_of(2));
    ASSERT_THAT(video.prepare(), IsOk());
  }
  VideoMatting other = open(folder.path(), clip_of(2), {.spectral = {.components = 6}});
  ASSERT_THAT(other.prepare(), IsOk());
  EXPECT_EQ(other.components(1)->count(), 6);
}

TEST(VideoMatting, KeepsFinishedFramesWhenAFrameIsBad) {
  TempFolder folder;
  const auto broken = [](int at, Result<Image> what) {
    return MattingClip{6, [at, what](int frame) -> Result<Image> {
                         if (frame == at) return what;
                         return frame_of(frame).rgb;
                       }};
  };
  const struct {
    Result<Image> picture;
    ErrorCode code;
    const char* says;
  } cases[] = {
      {Image(kWidth, kHeight, 3, 9), ErrorCode::BadData, "frame 3: the 90x60 picture has one colour"},
      {disc_picture(kWidth - 2, kHeight).rgb, ErrorCode::BadData, "frame 3: the photograph is 88x60"},
      {fail(ErrorCode::EndOfStream, "the video is cut off"), ErrorCode::EndOfStream,
       "frame 3: the video is cut off"}};
  for (const auto& c : cases) {
    VideoMatting video = open(folder.path(), broken(3, c.picture));
    EXPECT_THAT(video.prepare(), FailsWith(c.code, c.says));
    EXPECT_EQ(video.usable(), 3);
    ASSERT_THAT(video.set_keyframe(0, {frame_of(0).alpha, {}}), IsOk());
    EXPECT_THAT(video.propagate(), IsOkAnd(ElementsAre(0, 1, 2)));
    EXPECT_THAT(video.components(3), FailsWith(ErrorCode::NotFound, "frame 3"));
  }
}

TEST(VideoMatting, SaysWhatItCannotOpen) {
  TempFolder folder;
  EXPECT_THAT(VideoMatting::create(clip_of(0), folder.path()),
              FailsWith(ErrorCode::InvalidArgument, "no frame"));
  EXPECT_THAT(VideoMatting::create(clip_of(1), folder.path(), {.temporal_filter = 2}),
              FailsWith(ErrorCode::InvalidArgument, "temporal_filter"));
  EXPECT_THAT(VideoMatting::create(
                  {2, [](int) -> Result<Image> { return fail(ErrorCode::NotFound, "gone"); }}, folder.path()),
              FailsWith(ErrorCode::NotFound, "gone"));
  ASSERT_THAT(write_file(folder.path() / "file", "x"), IsOk());
  EXPECT_THAT(VideoMatting::create(clip_of(1), folder.path() / "file"), FailsWith(ErrorCode::Io, "file"));
  VideoMatting video = open(folder.path(), clip_of(1));
  EXPECT_THAT(video.propagate(), FailsWith(ErrorCode::NotFound, "prepare"));
}

TEST(VideoMatting, ScalesLargePhotographsDownAndMattesUp) {
  TempFolder folder;
  const DiscPicture large = disc_picture(360, 240);
  VideoMatting video =
      open(folder.path(), {1, [&](int) -> Result<Image> { return large.rgb; }}, {.working_pixels = 8000});
  EXPECT_EQ(video.width(), 360);
  EXPECT_LE(video.working_width() * video.working_height(), 8200);
  ASSERT_THAT(video.prepare(), IsOk());
  ASSERT_THAT(video.set_keyframe(0, {large.alpha, {}}), IsOk());
  ASSERT_THAT(video.propagate(), IsOk());
  const auto matte = video.matte(0);
  ASSERT_THAT(matte, IsOk());
  EXPECT_EQ(matte->width, 360);
  EXPECT_LT(mean_square(*matte, large.alpha), 1e-3);
}

TEST(CarryUp, GivesTheEdgeOfTheLargePictureBack) {
  const DiscPicture large = disc_picture(240, 160, 0, 0), small = disc_picture(80, 160 / 3, 0, 0);
  Image coarse(80, 53, 1);
  for (int y = 0; y < 53; ++y)
    for (int x = 0; x < 80; ++x) *coarse.at(x, y) = *large.alpha.at(3 * x + 1, 3 * y + 1);
  const auto up = guided_upsample(coarse, large.rgb);
  ASSERT_THAT(up, IsOk());
  EXPECT_LT(mean_square(*up, large.alpha), 1.5e-3);
  EXPECT_THAT(guided_upsample(coarse, Image(100, 100, 3)), FailsWith(ErrorCode::InvalidArgument, "80x53"));
  EXPECT_THAT(guided_upsample(large.rgb, large.rgb), FailsWith(ErrorCode::InvalidArgument, "3 channels"));
  EXPECT_EQ(*guided_upsample(large.alpha, large.rgb), large.alpha);
}

}  // namespace
}  // namespace floatstage::matting
