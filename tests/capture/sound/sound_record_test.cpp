#include "capture/sound/sound_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

const SoundTrack kMic = {.name = "mic", .rate = 44'100, .channels = 1, .bits = 24, .from = "alsa:hw:0"};

TEST(SoundJson, SurvivesReadingAndWriting) {
  SoundTrack other = kMic;
  other.name = "cam0", other.channels = 8;
  const std::vector<SoundTrack> tracks = {kMic, other};
  EXPECT_THAT(parse_sound_tracks(to_json(tracks), "x"), IsOkAnd(tracks));
}

TEST(SoundJson, CutAnywhereIsRefused) {
  const std::string whole = to_json(std::vector<SoundTrack>{kMic});
  for (std::size_t bytes = 0; bytes + 2 < whole.size(); ++bytes)
    EXPECT_THAT(parse_sound_tracks(whole.substr(0, bytes), "x"), FailsWith(ErrorCode::BadData, "x"));
}

TEST(SoundJson, RefusesWhatNoTakeHolds) {
  const auto with = [](const std::string& what, const std::string& by) {
    std::string json = to_json(std::vector<SoundTrack>{kMic});
    json.replace(json.find(what), what.size(), by);
    return parse_sound_tracks(json, "sound.json");
  };
  EXPECT_THAT(with("\"channels\": 1", "\"channels\": 0"), FailsWith(ErrorCode::BadData, "0 channels"));
  EXPECT_THAT(with("\"rate\": 44100", "\"rate\": 0"), FailsWith(ErrorCode::BadData, "0 samples a second"));
  EXPECT_THAT(with("\"rate\": 44100", "\"rate\": NaN"), FailsWith(ErrorCode::BadData, "sound.json"));
  EXPECT_THAT(with("\"bits\": 24", "\"bits\": 32"), FailsWith(ErrorCode::BadData, "32 bits"));
  EXPECT_THAT(with("\"mic\"", "\"../mic\""), FailsWith(ErrorCode::BadData, "make a name"));
  EXPECT_THAT(with("\"from\"", "\"form\""), FailsWith(ErrorCode::BadData, "f"));
  EXPECT_THAT(with("\"floatstage_sound\": 1", "\"floatstage_sound\": 2"),
              FailsWith(ErrorCode::Unsupported, "format 2"));
}

TEST(SoundJson, ThatIsNotThereIsATakeWithoutSound) {
  const TempFolder folder;
  EXPECT_THAT(load_sound_tracks(TakeLayout(folder.path())), IsOkAnd(IsEmpty()));
  folder.write("sound.json", "");
  EXPECT_THAT(load_sound_tracks(TakeLayout(folder.path())), FailsWith(ErrorCode::BadData, "sound.json"));
}

TEST(SoundCsv, IsReadUpToItsLastWholeLineAndNoFurther) {
  const std::vector<SoundStamp> stamps = {{0, {-5}, 0}, {480, {10'000'000}, 0}, {960, {0}, 1}};
  std::string whole = sound_csv_header();
  for (const SoundStamp& s : stamps) whole += to_csv(s);
  EXPECT_THAT(parse_sound_csv(whole, "x"), IsOkAnd(stamps));
  std::size_t rows = 0;
  for (std::size_t bytes = 0; bytes < whole.size(); ++bytes) {
    const auto read = parse_sound_csv(whole.substr(0, bytes), "x");
    ASSERT_THAT(read, IsOk()) << bytes;
    EXPECT_GE(read->size(), rows);
    rows = read->size();
  }
}

TEST(SoundCsv, NamesTheLineThatMakesNoSense) {
  const auto of = [](const std::string& rows) { return parse_sound_csv(sound_csv_header() + rows, "m.csv"); };
  EXPECT_THAT(parse_sound_csv("sample,time\n", "m.csv"), FailsWith(ErrorCode::BadData, "line 1"));
  EXPECT_THAT(of("0,0,0\nx,1,0\n"), FailsWith(ErrorCode::BadData, "line 3: the sample is not"));
  EXPECT_THAT(of("0,nan,0\n"), FailsWith(ErrorCode::BadData, "line 2: the time is not"));
  EXPECT_THAT(of("0,0,0,0\n"), FailsWith(ErrorCode::BadData, "the run is not"));
  EXPECT_THAT(of("-1,0,0\n"), FailsWith(ErrorCode::BadData, "no recording has such a sample"));
  EXPECT_THAT(of("0,9223372036854775807,0\n"), FailsWith(ErrorCode::BadData, "no clock"));
  EXPECT_THAT(of("0,0,1\n"), FailsWith(ErrorCode::BadData, "the first run is not 0"));
  EXPECT_THAT(of("5,0,0\n5,1,0\n"), FailsWith(ErrorCode::BadData, "line 3: its sample does not follow"));
  EXPECT_THAT(of("5,7,0\n6,7,0\n"), FailsWith(ErrorCode::BadData, "line 3: its time does not follow"));
  EXPECT_THAT(of("5,7,0\n6,8,2\n"), FailsWith(ErrorCode::BadData, "line 3: its run does not follow"));
}

}  // namespace
}  // namespace floatstage::capture
