// A recording of pictures and sound whose program is killed: what a power cut or the system's hunger for
// memory leaves.

#include <cmath>
#include <csignal>
#include <numbers>

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include "apps/viewer/play/sound_player.h"
#include "capture/sound/play_out.h"
#include "capture/sound/sound_reader.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/film_sound.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage {
namespace {

namespace fs = std::filesystem;
using capture::kPlayOutRate;

constexpr int kFps = 25;
constexpr double kTone = 10, kPpm = 50;                        // Hz: tells times within 50 ms either way
constexpr double kLate = 0.005, kMissing = 0.1, kNear = 1e-3;  // s

Timestamp now() {
  timespec t = {};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return {std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec};
}

/// `floatstage capture` of two cameras and a tone, for so long, and then killed. When that was.
Timestamp record_and_kill(const TempFolder& folder, double seconds_long) {
  std::string studio = text("[studio]\nframe_rate = ", kFps, "\n[recording]\nkeep_free_mb = 0\n");
  for (int c = 0; c < 2; ++c)
    studio +=
        text("[[camera]]\nserial = \"cam", c, "\"\nsource = \"synthetic:live=on&loop=2&width=32&height=24&",
             "samples=1&cameras=2&camera=", c, "&rate=", kFps, "\"\n");
  const std::string config = folder.write("studio.toml", studio), take = folder / "take",
                    said = folder / "said.txt", tone = text("tone:", kTone, "?ppm=", kPpm);
  const pid_t program = ::fork();
  if (program == 0) {
    ::dup2(::open(said.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600), STDERR_FILENO);
    ::execl(FLOATSTAGE_PROGRAM, FLOATSTAGE_PROGRAM, "capture", "--config", config.c_str(), "--record",
            "--out", take.c_str(), "--sound", tone.c_str(), nullptr);
    ::_exit(127);
  }
  const auto rows = [&] {
    const Result<std::string> csv = read_file(fs::path(take) / "cam1.frames.csv");
    return csv ? std::count(csv->begin(), csv->end(), '\n') : 0;
  };
  const Timestamp began = now();
  while (rows() < 2 && seconds(now() - began) < 60) ::poll(nullptr, 0, 20);
  EXPECT_GE(rows(), 2) << read_file(said).value();
  const Timestamp first = now();
  while (seconds(now() - first) < seconds_long) ::poll(nullptr, 0, 10);
  const Timestamp killed = now();
  ::kill(program, SIGKILL);
  int status = 0;
  EXPECT_EQ(::waitpid(program, &status, 0), program);
  EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL)
      << "the program itself, while it recorded: " << read_file(said).value();
  return killed;
}

/// How much later than it should be what is heard at sample `at` of the film is, s; the sound begins at
/// `begins` s.
double lateness(const std::vector<float>& film, double begins, double at, double expected_phase) {
  constexpr auto kPeriod = static_cast<std::int64_t>(kPlayOutRate / kTone);
  // The period of the tone before it; where the sound has just begun (and a film fades it in) after that.
  const auto end = static_cast<std::int64_t>(at);
  const std::int64_t first =
      std::max<std::int64_t>(end - kPeriod, std::llround((std::max(begins, 0.0) + 0.01) * kPlayOutRate));
  double in_phase = 0, across = 0;
  for (std::int64_t i = first; i < first + kPeriod; ++i) {
    const double turn = 2 * std::numbers::pi * kTone * (static_cast<double>(i) - at) / kPlayOutRate;
    in_phase += film[static_cast<std::size_t>(i)] * std::sin(turn);
    across += film[static_cast<std::size_t>(i)] * std::cos(turn);
  }
  const double phase = std::atan2(across, in_phase),
               off = std::remainder(expected_phase - phase, 2 * std::numbers::pi);
  return off / (2 * std::numbers::pi * kTone);
}

TEST(ATakeCutByKill9, PlaysToTheCutWithSound) {
  const double length = wants_long_tests() ? 600 : 6;
  const TempFolder folder;
  const Timestamp killed = record_and_kill(folder, length);
  if (HasFailure()) return;
  const auto opened = capture::TakeReader::open(folder / "take");
  ASSERT_THAT(opened, IsOk());
  const capture::TakeReader& take = **opened;
  EXPECT_FALSE(take.manifest().complete);
  const auto tracks = capture::load_sound_tracks(take.layout());
  ASSERT_THAT(tracks, IsOk());
  ASSERT_EQ(tracks->size(), 1u);
  const auto sound = capture::SoundReader::open(take.layout(), tracks->front());
  ASSERT_THAT(sound, IsOk());
  ASSERT_EQ((*sound)->clock().runs().size(), 1u);
  const capture::SoundRun& run = (*sound)->clock().runs().front();
  EXPECT_NEAR(run.ppm, kPpm, 1);
  const Timestamp begin = (*sound)->clock().start_of(run), end = (*sound)->clock().end_of(run);

  // Nothing is missing at the cut, of either.
  const int frames = take.frame_count();
  ASSERT_GE(frames, static_cast<int>(0.9 * length * kFps));
  const Timestamp last = take.rows(0)[static_cast<std::size_t>(frames) - 1].info.exposure_start;
  EXPECT_LT(seconds(killed - end), kMissing) << "of the sound";
  EXPECT_LT(seconds(last - end), kMissing) << "of the last pictures' sound";
  EXPECT_LT(seconds(killed - last), 2 * kMissing + 1.0 / kFps) << "of the pictures";

  const Timestamp first = take.rows(0).front().info.exposure_start;

  // Every picture from when the sound began up to there has it: as `play` has them together, by the picture's
  // own time, and in a film, which shows each for one rate's length whenever a busy camera took it.
  const auto playing = capture::PlayOut::create(**sound, {0});
  ASSERT_THAT(playing, IsOk());
  (*playing)->seek(first);
  std::vector<float> played(static_cast<std::size_t>((seconds(last - first) + 1) * kPlayOutRate));
  ASSERT_THAT((*playing)->read(played), IsOk());
  std::vector<int> all;
  for (int f = 0; f < frames; ++f) all.push_back(f);
  const auto film = pipeline::FilmSounds::open(take, all, kFps, "");
  ASSERT_THAT(film, IsOk());
  ASSERT_TRUE(*film);
  std::vector<float> heard(static_cast<std::size_t>((*film)->sound().samples));
  ASSERT_THAT((*film)->sound().read(0, heard), IsOk());
  double worst = 0;
  std::vector<double> in_film;
  for (int f = 0; f < frames; ++f) {
    const Timestamp shown = take.rows(0)[static_cast<std::size_t>(f)].info.exposure_start;
    // A take begins with a picture that was there already when it was asked for.
    EXPECT_LT(seconds(begin - shown), kMissing) << "picture " << f << " was there before the sound";
    if (shown < begin || shown > end) continue;
    const double phase = 2 * std::numbers::pi * kTone * (1 + kPpm * 1e-6) * seconds(shown - begin);
    worst = std::max(worst, std::abs(lateness(played, seconds(begin - first),
                                              seconds(shown - first) * kPlayOutRate, phase)));
    in_film.push_back(std::abs(
        lateness(heard, seconds(begin - first), static_cast<double>(f) / kFps * kPlayOutRate, phase)));
  }
  EXPECT_GE(static_cast<int>(in_film.size()), frames - 2 * static_cast<int>(kMissing * kFps) - 1);
  EXPECT_LT(worst, kLate);
  const double film_most = percentile(in_film, 0.95);
  EXPECT_LT(film_most, kLate) << "in the film";

  // And so it plays.
  Timestamp clock{};
  std::string problem;
  const auto player = apps::SoundPlayer::of_take(take, capture::silent_output([&] { return clock; }), problem,
                                                 apps::SoundPlayer::Feeding::ByHand);
  ASSERT_NE(player, nullptr) << problem;
  player->play(0, false);
  double reached = 0;
  while (player->plays() && seconds(clock - Timestamp{}) < 2 * length + 10) {
    player->feed();
    clock = clock + milliseconds(100);
    if (const std::optional<double> now_heard = player->heard()) reached = *now_heard;
  }
  EXPECT_FALSE(player->plays());
  EXPECT_NEAR(reached, player->clock().length(), kNear);
  EXPECT_LT(seconds(killed - player->clock().begin()) - reached, 2 * kMissing + 1.0 / kFps);
  std::printf(
      "%d pictures of %.1f s: off by %.3f ms at most (in a film by %.3f ms, 19 of 20 by %.3f ms), missing at "
      "the kill %.0f ms of sound, %.0f ms of pictures\n",
      frames, seconds(last - begin), 1e3 * worst, 1e3 * percentile(in_film, 1), 1e3 * film_most,
      1e3 * seconds(killed - end), 1e3 * seconds(killed - last));
}

}  // namespace
}  // namespace floatstage
