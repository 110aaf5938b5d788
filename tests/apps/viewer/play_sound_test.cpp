// The real window under a virtual display, with a loudspeaker that is a file.

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "capture/sound/media_sound.h"
#include "capture/sound/play_out.h"
#include "capture/sound/sound_writer.h"
#include "core/file.h"
#include "core/png.h"
#include "pipeline/derive/list_takes.h"
#include "pipeline/process/process.h"
#include "tests/support/run_command.h"
#include "tests/support/small_take.h"
#include "tests/support/under_display.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 40, kFps = 25, kRate = 48'000;
constexpr float kBed = 0.05f, kLoud = 0.5f, kQuiet = 0.005f;
const std::vector<double> kClicks = {0.3, 0.52, 1.05};  // s after the first frame

/// A tone that never ceases, and clicks in it.
void add_sound(const fs::path& folder) {
  const auto take = capture::TakeReader::open(folder);
  ASSERT_THAT(take, IsOk());
  const capture::SoundTrack track = {.name = "mic", .rate = kRate, .channels = 1, .bits = 16, .from = "test"};
  ASSERT_THAT(capture::save_sound_tracks({track}, TakeLayout(folder)), IsOk());
  const auto sound = capture::SoundWriter::create(TakeLayout(folder), track);
  ASSERT_THAT(sound, IsOk());
  std::vector<float> levels;
  for (int i = 0; i < 2 * kRate; ++i)
    levels.push_back(kBed * static_cast<float>(std::sin(2 * std::numbers::pi * 300 * i / kRate)));
  for (const double click : kClicks)
    for (int i = 0; i < 48; ++i)
      levels[static_cast<std::size_t>(std::lround(click * kRate)) + i] = i % 2 ? -0.9f : 0.9f;
  ASSERT_THAT((*sound)->stamp(0, *pipeline::begin_of(**take)), IsOk());
  ASSERT_THAT((*sound)->write(levels), IsOk());
  ASSERT_THAT((*sound)->finish(), IsOk());
}

class PlayWithSound : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempFolder;
    take_ = small_take(*folder_, kFrames);
    pipeline::ProcessOptions options{.take = take_, .matte = "chroma", .hull = recon::HullOptions{}};
    options.hull->resolution = 48;
    ASSERT_THAT(pipeline::process_take(options), IsOk());
    add_sound(take_);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }

  /// Plays while hands do `hands` ($window is there, what is said goes to $said), then ends.
  struct Played {
    nlohmann::json report;
    std::string said;
  };
  Played play(const std::string& hands, const std::string& sound) {
    const fs::path json = *folder_ / "play.json", said = *folder_ / "said";
    fs::remove(json);
    const fs::path script = folder_->write("hands.sh", "said='" + said.string() + "'\n" + player(sound) +
                                                           " --json '" + json.string() + R"(' > "$said" 2>&1 &
player=$!
window=$(xdotool search --sync --onlyvisible --name Floatstage | head -1)
xdotool windowmove --sync $window 0 0 2>/dev/null
xdotool windowfocus --sync $window
)" + hands + R"(
kill -INT $player
wait $player
)");
    const Ended ended =
        run_command("cd " + folder_->path().string() + " && " + under_display("bash " + script.string()));
    const std::string words = *read_file(said);
    EXPECT_EQ(ended.code, 0) << ended.output << words;
    const Result<std::string> bytes = read_file(json);
    EXPECT_THAT(bytes, IsOk()) << words;
    return {.report = bytes ? nlohmann::json::parse(*bytes) : nlohmann::json(), .said = words};
  }
  nlohmann::json play(const std::string& hands) {
    return play(hands, "--sound-output 'file:" + (*folder_ / "heard.wav").string() + "'").report;
  }
  static std::string player(const std::string& sound) {
    return FLOATSTAGE_PROGRAM " play '" + take_.string() + "' --size 900x600 --method nearest --playing " +
           sound;
  }

  /// What the loudspeaker gave, one channel.
  static std::vector<float> loudspeaker() {
    std::vector<float> out;
    const auto sound = capture::MediaSound::open(*folder_ / "heard.wav");
    EXPECT_THAT(sound, IsOk());
    for (;;) {
      const auto block = (*sound)->next();
      if (!block) return out;
      for (std::size_t i = 0; i < block->samples.size(); i += 2) out.push_back(block->samples[i]);
    }
  }

  static TempFolder* folder_;
  static fs::path take_;
};
TempFolder* PlayWithSound::folder_ = nullptr;
fs::path PlayWithSound::take_;

struct Shown {
  int frame;
  double output, heard;
};

std::vector<Shown> shown_in(const nlohmann::json& report) {
  std::vector<Shown> out;
  for (const nlohmann::json& s : report.at("heard"))
    out.push_back({s[0].get<int>(), s[1].get<double>(), s[2].get<double>()});
  return out;
}

TEST_F(PlayWithSound, ShowsThePicturesOfWhatIsHeard) {
  const nlohmann::json report = play("sleep 6");
  const std::vector<Shown> shown = shown_in(report);
  ASSERT_GT(shown.size(), 20u) << report.dump();
  std::vector<double> late;
  for (const Shown& s : shown) {
    // How far what is heard is from the middle of the frame, over the loop's seam too.
    const double length = static_cast<double>(kFrames) / kFps;
    late.push_back(std::abs(std::remainder(s.heard - (s.frame + 0.5) / kFps, length)));
  }
  std::sort(late.begin(), late.end());
  const double middle = late[late.size() / 2], most = late[late.size() * 9 / 10];
  std::printf("%zu frames shown; off by %.0f ms in the median, %.0f ms in nine of ten\n", shown.size(),
              1e3 * middle, 1e3 * most);
  EXPECT_LT(middle, 0.06);
  EXPECT_LT(most, 0.2);

  // And by the loudspeaker: each click is where the frames around it say that it was heard.
  const std::vector<float> levels = loudspeaker();
  int clicks = 0;
  double before = -1;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double at = static_cast<double>(i) / capture::kPlayOutRate;
    if (std::abs(levels[i]) < kLoud || at < before + 0.1) continue;
    before = at;
    const auto next = std::find_if(shown.begin(), shown.end(), [&](const Shown& s) { return s.output > at; });
    if (next == shown.begin() || next == shown.end()) continue;
    const double heard = std::prev(next)->heard + at - std::prev(next)->output;
    double nearest = 1;
    for (const double c : kClicks)
      nearest = std::min(nearest, std::abs(std::remainder(heard - c, static_cast<double>(kFrames) / kFps)));
    EXPECT_LT(nearest, 0.005) << "at " << at << " s of the loudspeaker";
    ++clicks;
  }
  EXPECT_GE(clicks, 5);
}

TEST_F(PlayWithSound, IsSilentWhileAHandDragsTheTimeLine) {
  const nlohmann::json report = play(R"(
sleep 3
xdotool mousemove --sync 560 555 mousedown 1
for i in $(seq 20); do xdotool mousemove $((560 + i * 14)) 555; sleep 0.1; done
xdotool mouseup 1
sleep 2)");
  const std::vector<Shown> shown = shown_in(report);
  ASSERT_GT(shown.size(), 10u) << report.dump();
  double longest = 0, quiet = 0, first = -1, last = -1;
  const std::vector<float> levels = loudspeaker();
  constexpr std::size_t kBlock = capture::kPlayOutRate / 50;
  for (std::size_t i = 0; i + kBlock <= levels.size(); i += kBlock) {
    const float most = *std::max_element(levels.begin() + static_cast<std::ptrdiff_t>(i),
                                         levels.begin() + static_cast<std::ptrdiff_t>(i + kBlock));
    const double at = static_cast<double>(i) / capture::kPlayOutRate;
    quiet = most < kQuiet ? quiet + 0.02 : 0;
    if (most >= kQuiet) first = first < 0 ? at : first, last = at;
    if (first >= 0) longest = std::max(longest, quiet);
  }
  EXPECT_GT(longest, 1.5) << "two seconds of dragging";
  EXPECT_GT(last, first + longest + 1) << "it goes on once the hand has let go";
  // No frame was shown to a sound meanwhile.
  double gap = 0;
  for (std::size_t i = 1; i < shown.size(); ++i) gap = std::max(gap, shown[i].output - shown[i - 1].output);
  EXPECT_GT(gap, 1.5);
}

TEST_F(PlayWithSound, SaysOnceThatThereIsNoLoudspeakerAndPlays) {
  const std::string words = "nothing is heard: cannot play to alsa:hw:77";
  const Played without =
      play("while kill -0 $player && ! grep -q 'nothing is heard' $said; do sleep 0.1; done; sleep 2",
           "--sound-output alsa:hw:77");
  const std::size_t said = without.said.find(words);
  ASSERT_NE(said, std::string::npos) << without.said;
  EXPECT_EQ(without.said.find(words, said + 1), std::string::npos) << "once";
  EXPECT_TRUE(without.report.at("heard").empty());
  EXPECT_EQ(play("sleep 2", "--no-sound").said.find("nothing is heard"), std::string::npos);
  const Ended other = run_command(under_display(player("--sound boom")));
  EXPECT_NE(other.output.find("has no sound 'boom'; it has mic"), std::string::npos) << other.output;
}

}  // namespace
}  // namespace floatstage::apps
