// Sound of videos, made by another program (ffmpeg).

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/formats/format_files.h"
#include "capture/sound/sound_reader.h"
#include "core/file.h"
#include "pipeline/import/import.h"
#include "tests/pipeline/import/import_support.h"
#include "tests/support/matchers.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

// Two cameras' videos of four seconds at 25 a second. That of "a" has sound that is silent but for a burst of
// 10 ms at 2 s; `lead` is how much later than its pictures it begins.
class ImportOfSound : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_THAT(calib::write_easymocap(test_rig(2), folder_ / "in"), IsOk());
    fs::create_directories(folder_ / "in" / "videos");
    options_.calibration = {"opencv", folder_ / "in"};
    options_.pictures = folder_ / "in" / "videos";
    options_.out = folder_ / "take";
    film("b", "");
  }
  void film(const std::string& camera, const std::string& sound, const std::string& coded = "") {
    const Ended ended =
        run_command("ffmpeg -nostdin -y -v error -f lavfi -i testsrc=size=32x24:rate=25:duration=4 " + sound +
                    " -c:v libx264 -pix_fmt yuv420p " + coded + " '" +
                    (folder_ / "in" / "videos" / camera).string() + ".mp4'");
    ASSERT_EQ(ended.code, 0) << ended.output;
  }
  static std::string burst(double lead) {
    return "-itsoffset " + std::to_string(lead) + " -f lavfi -i \"aevalsrc='if(between(t," +
           std::to_string(2 - lead) + "," + std::to_string(2.01 - lead) +
           "),0.9*sin(2*PI*1000*t),0)':s=48000:d=" + std::to_string(4 - lead) + "\"";
  }
  // When on the take's clock the first loud sample is.
  double heard(const std::string& name) {
    const TakeLayout take(options_.out);
    const auto tracks = capture::load_sound_tracks(take);
    EXPECT_THAT(tracks, IsOk());
    const auto track = capture::sound_track_named(*tracks, name);
    EXPECT_THAT(track, IsOk());
    const auto sound = capture::SoundReader::open(take, *track);
    EXPECT_THAT(sound, IsOk());
    std::vector<float> levels(static_cast<std::size_t>((*sound)->samples() * track->channels));
    EXPECT_THAT((*sound)->read(0, levels), IsOk());
    for (std::size_t i = 0; i < levels.size(); ++i)
      if (std::abs(levels[i]) > 0.4f)
        return static_cast<double>(
                   (*sound)->clock().time_of(static_cast<std::int64_t>(i) / track->channels)->ns) *
               1e-9;
    return -1;
  }

  TempFolder folder_;
  ImportOptions options_;
};

TEST_F(ImportOfSound, KeepsItAtThePicturesTimes) {
  for (const double lead : {0.0, 0.3}) {
    film("a", burst(lead), "-c:a aac");
    const auto report = import_take(options_);
    ASSERT_THAT(report, IsOk());
    EXPECT_EQ(report->sounds, 1) << "b has none";
    EXPECT_NEAR(heard("a"), 2, 0.003) << lead;
    fs::remove_all(options_.out);
  }
}

TEST_F(ImportOfSound, CutsItToTheFramesWithASecondAround) {
  film("a", burst(0), "-c:a aac");
  options_.frames = {.first = 40, .end = 60, .step = 1};
  ASSERT_THAT(import_take(options_), IsOk());
  EXPECT_NEAR(heard("a"), 2 - 1.6, 0.003);
  const TakeLayout take(options_.out);
  const auto sound = capture::SoundReader::open(take, capture::load_sound_tracks(take)->front());
  ASSERT_THAT(sound, IsOk());
  EXPECT_NEAR(static_cast<double>((*sound)->samples()) / 48'000, 2.76, 0.1);
}

TEST_F(ImportOfSound, LeavesItOutWhereItIsNotWantedOrCannotFit) {
  film("a", burst(0), "-c:a aac");
  options_.sound = false;
  ASSERT_THAT(import_take(options_), IsOk());
  EXPECT_THAT(capture::load_sound_tracks(TakeLayout(options_.out)), IsOkAnd(IsEmpty()));
  EXPECT_FALSE(fs::exists(options_.out / "sound.json"));
  fs::remove_all(options_.out);
  options_.sound = true;
  options_.frame_rate = 50;
  const auto report = import_take(options_);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->sounds, 0);
  EXPECT_THAT(report->notes,
              Contains(HasSubstr("the sound of camera 'a' is left out: its pictures are shown 2 as")));
}

TEST_F(ImportOfSound, OfAnEmptyTrackIsRefusedAndLeavesNothing) {
  // A track that is announced and has no sample.
  film("a", "-f lavfi -i anullsrc=r=48000:d=4 -filter:a 'aselect=0'", "-c:a pcm_s16le -f matroska");
  const std::vector<std::string> before = folder_.names();
  const auto report = import_take(options_);
  EXPECT_THAT(report, FailsWith(ErrorCode::BadData, "--no-sound"));
  EXPECT_THAT(report.error().message, HasSubstr("a.mp4"));
  EXPECT_EQ(folder_.names(), before);
}

}  // namespace
}  // namespace floatstage::pipeline
