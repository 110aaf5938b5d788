#include "capture/sound/sound_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/capture/sound/sound_support.h"
#include "tests/support/child_process.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

class ASoundSource : public testing::Test {
 protected:
  // The sound of a take as a file: ten seconds of patterned().
  std::string file() {
    const SoundTrack track = {.name = "other", .rate = 16'000, .channels = 2, .bits = 16, .from = "test"};
    record(TakeLayout(folder_.path()), track, 160'000);
    return "file:" + (folder_ / track.media()).string();
  }
  // What is recorded of these, until they end.
  void record_all(const std::vector<std::string>& uris) {
    std::vector<std::unique_ptr<SoundSource>> sources;
    for (const std::string& uri : uris) {
      auto source = open_sound(uri);
      ASSERT_THAT(source, IsOk());
      sources.push_back(std::move(*source));
    }
    const auto recording = SoundRecording::start(take_, uris, std::move(sources));
    ASSERT_THAT(recording, IsOk());
    (*recording)->wait();
    ASSERT_THAT((*recording)->finish(), IsOk());
  }
  std::unique_ptr<SoundReader> recorded(std::size_t track) {
    const auto tracks = load_sound_tracks(take_);
    EXPECT_THAT(tracks, IsOk());
    auto sound = SoundReader::open(take_, tracks->at(track));
    EXPECT_THAT(sound, IsOk());
    return std::move(*sound);
  }

  TempFolder folder_, take_folder_;
  const TakeLayout take_{take_folder_.path()};
};

TEST_F(ASoundSource, IsRecordedSampleBySampleWithTheDriftOfItsClock) {
  const std::string from = file();
  record_all({from + "?ppm=50&live=off", from + "?ppm=-20.5&live=off"});
  const auto first = recorded(0), second = recorded(1);
  EXPECT_EQ(first->track().name, "sound");
  EXPECT_EQ(second->track().name, "sound2");
  EXPECT_EQ(first->track().from, from + "?ppm=50&live=off");
  EXPECT_EQ(first->samples(), 160'000);
  EXPECT_EQ(read(*first, 0, 160'000), patterned(0, 160'000, 2));
  ASSERT_THAT(first->clock().runs(), SizeIs(1));
  EXPECT_NEAR(first->clock().runs()[0].ppm, 50, 0.1);
  EXPECT_NEAR(second->clock().runs()[0].ppm, -20.5, 0.1);
}

TEST_F(ASoundSource, ThatIsKilledWhileItRecordsPlaysUpToTheCut) {
  ChildProcess recorder([&](const std::function<void()>& report) {
    auto source = open_sound("tone:1000?live=off");
    if (!source) return 1;
    std::vector<std::unique_ptr<SoundSource>> sources;
    sources.push_back(std::move(*source));
    const auto recording = SoundRecording::start(take_, {"tone:"}, std::move(sources));
    if (!recording) return 2;
    for (std::int64_t there = 0; there < 96'000;) {
      const auto sound =
          SoundReader::open(take_, {.name = "sound", .rate = 48'000, .channels = 1, .bits = 16, .from = ""});
      if (sound) there = (*sound)->samples();
    }
    report();
    (*recording)->wait();  // for ever
    return 3;
  });
  ASSERT_TRUE(recorder.wait_for_reports(1));
  recorder.kill();
  recorder.wait();
  const auto sound = recorded(0);
  ASSERT_GE(sound->samples(), 96'000);
  EXPECT_THAT(sound->damage([](std::uint64_t) { return true; }), IsOkAnd(testing::IsEmpty()));
  EXPECT_NEAR(sound->clock().runs().at(0).ppm, 0, 0.1);
  const std::vector<float> last = read(*sound, sound->samples() - 480, 480);
  EXPECT_NEAR(*std::max_element(last.begin(), last.end()), 0.25, 0.01) << "it sounds to its end";
}

TEST_F(ASoundSource, OfATimeOfItsOwnKeepsToIt) {
  const auto source = open_sound("tone:");
  ASSERT_THAT(source, IsOk());
  Timestamp last{-1};
  for (int i = 0; i < 5; ++i) {
    const auto period = (*source)->next();
    ASSERT_THAT(period, IsOk());
    EXPECT_EQ(period->samples.size(), 480u);
    if (i > 0) {
      EXPECT_EQ(period->time, last + milliseconds(10));
    }
    last = period->time;
  }
}

TEST_F(ASoundSource, OfAnotherKindIsRefusedWithWhatThereIs) {
  for (const char* uri : {"", "hw:0", "tone", "alsa:", "tone:loud", "tone:0", "tone:?ppm=nan",
                          "tone:?ppm=2000", "tone:?live=perhaps", "file:x.wav?ppm="})
    EXPECT_THAT(open_sound(uri), FailsWith(ErrorCode::InvalidArgument, "write alsa:DEVICE")) << uri;
  EXPECT_THAT(open_sound("file:/nowhere.wav"), FailsWith(ErrorCode::NotFound, "/nowhere.wav"));
  EXPECT_THAT(open_sound("file:" + folder_.write("x.wav", "RIFF").string()),
              FailsWith(ErrorCode::BadData, "x.wav"));
}

TEST_F(ASoundSource, ThatTheMachineDoesNotHaveIsNamed) {
  EXPECT_THAT(open_sound("alsa:nosuch"), FailsWith(ErrorCode::NotFound, "cannot record from alsa:nosuch"));
}

// ALSA's own device without hardware: silence, as fast as it is asked.
TEST_F(ASoundSource, OfAlsaDeliversWhatItsDeviceHas) {
  const auto source = open_sound("alsa:null");
  ASSERT_THAT(source, IsOk());
  EXPECT_GE((*source)->channels(), 1);
  EXPECT_GE((*source)->rate(), kLowestSoundRate);
  const auto period = (*source)->next();
  ASSERT_THAT(period, IsOk());
  EXPECT_FALSE(period->samples.empty());
  EXPECT_GT(period->time.ns, 0);
}

}  // namespace
}  // namespace floatstage::capture
