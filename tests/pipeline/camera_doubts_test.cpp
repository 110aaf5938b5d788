// Cameras whose pictures are not what the rig and the clock say: late, repeated, another's, moved meanwhile.
#include "pipeline/matte/camera_doubts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/png.h"
#include "pipeline/derive/set_times.h"
#include "pipeline/process/pose_doubts.h"
#include "pipeline/process/process.h"
#include "pipeline/synthesize.h"
#include "pipeline/take_times.h"
#include "tests/support/rewritten_take.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr int kFrames = 24;

class DoubtedCameras : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TempFolder();
    SynthesizeOptions options;
    options.out = recorded();
    options.rig.width = 240, options.rig.height = 180;
    options.studio.seed = 5, options.studio.samples = 4;
    options.frames = kFrames;
    ASSERT_THAT(synthesize_take(options), IsOk());
  }
  static void TearDownTestSuite() { delete shared_; }
  static fs::path recorded() { return *shared_ / "take"; }
  static std::unique_ptr<capture::TakeReader> open(const fs::path& folder) {
    auto take = capture::TakeReader::open(folder);
    EXPECT_THAT(take, IsOk());
    return std::move(*take);
  }
  /// A take in which some cameras are late by frames.
  fs::path late(std::vector<int> frames) const {
    const auto [least, most] = std::minmax_element(frames.begin(), frames.end());
    const DerivedTake other{.rig = {},
                            .first = std::max(0, *most),
                            .end = kFrames + std::min(0, *least),
                            .how = "late",
                            .label = {},
                            .moved = frames};
    EXPECT_THAT(derive_take(*open(recorded()), other, folder_ / "late"), IsOk());
    return folder_ / "late";
  }
  /// True mattes, as somebody's, of what a defect makes of photographs.
  fs::path with_true_mattes(const Defect& defect) const {
    const fs::path out = folder_ / "defective";
    rewrite_take(recorded(), out, defect);
    const auto take = open(recorded());
    for (int camera = 0; camera < 8; ++camera)
      for (int frame = 0; frame < kFrames; ++frame) {
        const std::string& serial = take->rig().cameras[static_cast<std::size_t>(camera)].serial;
        const fs::path file = TakeLayout(out).matte(serial, frame);
        fs::create_directories(file.parent_path());
        const Result<Image> matte = load_png(TakeLayout(recorded() / "truth").matte(serial, frame));
        EXPECT_THAT(matte, IsOk());
        EXPECT_THAT(save_png(defect(camera, frame, *matte), file), IsOk());
      }
    return out;
  }
  static std::vector<int> all() {
    std::vector<int> frames(kFrames);
    for (int f = 0; f < kFrames; ++f) frames[static_cast<std::size_t>(f)] = f;
    return frames;
  }

  static TempFolder* shared_;
  TempFolder folder_;
};
TempFolder* DoubtedCameras::shared_ = nullptr;

TEST_F(DoubtedCameras, AreNoneWhereAllIsWell) {
  const Result<ProcessReport> report = process_take({.take = recorded()});
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->camera_doubts, IsEmpty());
  EXPECT_THAT(report->pose_doubts, IsEmpty());
}

TEST_F(DoubtedCameras, ALateOneIsNamedAndNoMatteIsCutByOtherInstants) {
  const fs::path take = late({0, 0, 0, 2, 0, 0, 0, 0});
  const Result<ProcessReport> report = process_take({.take = take});
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->camera_doubts.size(), 1u);
  EXPECT_THAT(report->camera_doubts[0], AllOf(HasSubstr("camera 'cam03' is "), HasSubstr("behind the others"),
                                              HasSubstr("take set-times")));
  EXPECT_THAT(report->healed, IsEmpty());
  EXPECT_THAT(report->pose_doubts, IsEmpty()) << "a late camera looks like a turned one";

  // What it says to do brings back the pictures as they were taken.
  const auto reader = open(take);
  std::vector<int> frames = all();
  frames.resize(static_cast<std::size_t>(reader->frame_count()));
  const Result<TakeTimes> times = measure_take_times(*reader, frames, {.threads = 2}, nullptr);
  ASSERT_THAT(times, IsOk());
  const Result<SetTimesReport> set = set_times(*reader, times->file, folder_ / "set");
  ASSERT_THAT(set, IsOk());
  EXPECT_THAT(set->moved, ElementsAre(0, 0, 0, -2, 0, 0, 0, 0));
  const auto together = open(folder_ / "set"), original = open(recorded());
  EXPECT_EQ(together->frame_count(), kFrames - 4);
  for (const int camera : {2, 3})
    EXPECT_EQ(to_rgb(*together->frame(camera, 5))->pixels, to_rgb(*original->frame(camera, 7))->pixels)
        << camera;
  const Result<ProcessReport> again = process_take({.take = folder_ / "set"});
  ASSERT_THAT(again, IsOk());
  EXPECT_THAT(again->camera_doubts, IsEmpty());
}

TEST_F(DoubtedCameras, OneThatRepeatsItsLastPictureIsNamed) {
  const auto take = open(recorded());
  std::vector<Image> last(2);
  const fs::path frozen = with_true_mattes([&](int camera, int frame, Image picture) {
    if (camera != 3) return picture;
    Image& kept = last[picture.channels == 3 ? 0 : 1];
    if (frame <= 9) kept = picture;
    return kept;
  });
  const Result<std::vector<std::string>> doubts = camera_doubts(*open(frozen), all(), 2, nullptr);
  ASSERT_THAT(doubts, IsOk());
  EXPECT_THAT(*doubts, ElementsAre(HasSubstr("camera 'cam03' shows the same picture in frames 9 to 23")));
}

// The middle one of the frames in which `auto` compares methods has no cloth in it.
TEST_F(DoubtedCameras, ACoveredLensStopsNothingElse) {
  rewrite_take(recorded(), folder_ / "covered", [](int camera, int frame, Image picture) {
    for (std::size_t i = 0; camera == 3 && frame >= 10 && frame < 14 && i < picture.pixels.size(); ++i)
      picture.pixels[i] = static_cast<std::uint8_t>(40 + i * 7919 % 60 + (i % 3 == 0 ? 80 : 0));
    return picture;
  });
  fs::remove_all(folder_ / "covered" / "plates");
  const Result<ProcessReport> report = process_take({.take = folder_ / "covered"});
  ASSERT_THAT(report, IsOk());
  EXPECT_GE(report->mattes.made, 8 * kFrames - 4);
  EXPECT_EQ(report->meshes.made, kFrames);
}

TEST_F(DoubtedCameras, OneThatIsAnotherIsNamed) {
  Rig rig = open(recorded())->rig();
  std::swap(rig.cameras[3], rig.cameras[4]), std::swap(rig.cameras[3].serial, rig.cameras[4].serial);
  ASSERT_THAT(
      derive_take(*open(recorded()), {.rig = rig, .how = "swapped", .label = {}}, folder_ / "swapped"),
      IsOk());
  const Result<ProcessReport> report =
      process_take({.take = folder_ / "swapped", .matte = "chroma", .frames = {4, 12, 20}, .redo = true});
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->camera_doubts,
              ElementsAre(HasSubstr("camera 'cam03' shows what camera 'cam04' should see"),
                          AllOf(HasSubstr("camera 'cam04' shows what camera 'cam03' should see"),
                                HasSubstr("take set-rig"))));
  EXPECT_THAT(report->healed, IsEmpty());
}

TEST_F(DoubtedCameras, OneThatWasMovedBetweenTwoInstantsIsNamed) {
  const fs::path moved = with_true_mattes([](int camera, int frame, Image picture) {
    if (camera != 2 || frame < 12) return picture;
    Image aside = picture;
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x)
        for (int c = 0; c < picture.channels; ++c) aside.at(x, y)[c] = picture.at(std::max(0, x - 5), y)[c];
    return aside;
  });
  const Result<std::vector<std::string>> doubts = pose_doubts(*open(moved), all(), 2, nullptr);
  ASSERT_THAT(doubts, IsOk());
  EXPECT_THAT(*doubts, ElementsAre(AllOf(HasSubstr("camera 'cam02' stands otherwise"),
                                         HasSubstr("in frame 16, but not in frame 8"))));
}

TEST_F(DoubtedCameras, TimesAreSetOnlyWhereTheyAreApart) {
  const auto take = open(recorded());
  const auto times = [&](std::int64_t late_by) {
    capture::TimeOffsetFile file{"silhouettes", {}};
    for (const RigCamera& camera : take->rig().cameras)
      file.cameras.push_back(
          {camera.serial, Nanoseconds{camera.serial == "cam00" ? late_by : 0}, Nanoseconds{}, {}});
    return file;
  };
  const auto set = [&](const capture::TimeOffsetFile& file) {
    return set_times(*take, file, folder_ / "set");
  };
  const std::int64_t period = 40'000'000;
  EXPECT_THAT(set(times(-period / 3)), FailsWith(ErrorCode::InvalidArgument, "half a frame"));
  EXPECT_THAT(set(times(-40 * period)), FailsWith(ErrorCode::InvalidArgument, "no instant"));
  EXPECT_THAT(set({"silhouettes", {}}), FailsWith(ErrorCode::NotFound, "calibrate times"));
  EXPECT_FALSE(fs::exists(folder_ / "set"));

  // The first camera, which times are counted from, may itself be the one that is apart.
  const Result<SetTimesReport> made = set(times(-period * 5 / 4));
  ASSERT_THAT(made, IsOk());
  EXPECT_THAT(made->moved, ElementsAre(-1, 0, 0, 0, 0, 0, 0, 0));
  ASSERT_EQ(made->sentences.size(), 1u);
  EXPECT_THAT(made->sentences[0], HasSubstr("camera 'cam00' was 1.25 frames behind the others"));
  const auto together = open(folder_ / "set");
  EXPECT_EQ(together->frame_count(), kFrames - 1);
  EXPECT_EQ(together->rows(0)[3].info.sequence, take->rows(0)[4].info.sequence);
  EXPECT_EQ(together->rows(0)[3].info.exposure_start.ns, take->rows(0)[4].info.exposure_start.ns - period);
  EXPECT_EQ(together->rows(1)[3].info, take->rows(1)[3].info);
  const Result<capture::TimeOffsetFile> left = capture::load_time_offsets(together->layout());
  ASSERT_THAT(left, IsOk());
  EXPECT_EQ(left->cameras[0].offset->count, -period / 4);
  EXPECT_THAT(together->warnings(), IsEmpty());
}

}  // namespace
}  // namespace floatstage::pipeline
