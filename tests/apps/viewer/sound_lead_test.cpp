#include "apps/viewer/play/sound_lead.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/sound/sound_writer.h"
#include "core/synthetic/synthetic_studio.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

using capture::kOutputChannels;
using capture::kPlayOutRate;

constexpr int kFps = 25, kFrames = 100, kRate = 8'000;
const Timestamp kBegin{50'000'000'000};

/// A take of four seconds, whose cameras' clock runs 200 ppm slow, with a track of rising levels: what a
/// sample was says when it was.
std::filesystem::path record(const std::filesystem::path& folder) {
  SyntheticRigOptions rig;
  rig.cameras = 1, rig.width = 16, rig.height = 8;
  capture::TakeWriterOptions options;
  options.codec = capture::TakeCodec::Raw;
  options.frame_rate = kFps;
  const auto writer = capture::TakeWriter::create(folder, synthetic_rig(rig), options);
  EXPECT_THAT(writer, IsOk());
  for (int f = 0; f < kFrames; ++f) {
    FrameInfo info;
    info.camera = 0;
    info.sequence = static_cast<std::uint64_t>(f);
    info.exposure_start = kBegin + Nanoseconds{std::llround(f * 1.0002 / kFps * 1e9)};
    EXPECT_THAT((*writer)->write(make_frame(info, Image(16, 8, 3))), IsOk());
  }
  EXPECT_THAT((*writer)->finish(), IsOk());
  const TakeLayout take(folder);
  const capture::SoundTrack rising = {.name = "rising", .rate = kRate, .channels = 1, .bits = 24, .from = ""},
                            falling = {
                                .name = "falling", .rate = kRate, .channels = 1, .bits = 24, .from = ""};
  EXPECT_THAT(capture::save_sound_tracks({rising, falling}, take), IsOk());
  for (const capture::SoundTrack& track : {rising, falling}) {
    const auto sound = capture::SoundWriter::create(take, track);
    EXPECT_THAT(sound, IsOk());
    EXPECT_THAT((*sound)->stamp(0, kBegin), IsOk());
    std::vector<float> levels;
    for (int i = 0; i < 5 * kRate; ++i)
      levels.push_back((track.name == "rising" ? 0.1f : -0.1f) * (1 + static_cast<float>(i) / kRate));
    EXPECT_THAT((*sound)->write(levels), IsOk());
    EXPECT_THAT((*sound)->finish(), IsOk());
  }
  return folder;
}

/// A loudspeaker that remembers what it was given.
class Remembers final : public capture::SoundOutput {
 public:
  explicit Remembers(Timestamp& now) : by_clock_(capture::silent_output([&now] { return now; })) {}
  Result<std::int64_t> room() override {
    if (gone) return fail(ErrorCode::Disconnected, "the loudspeaker is gone");
    return by_clock_->room();
  }
  Result<void> write(std::span<const float> interleaved) override {
    written.insert(written.end(), interleaved.begin(), interleaved.end());
    return by_clock_->write(interleaved);
  }
  Result<std::int64_t> heard() override {
    if (gone) return fail(ErrorCode::Disconnected, "the loudspeaker is gone");
    return by_clock_->heard();
  }
  void drop() override {
    written.clear();
    by_clock_->drop();
  }
  double clock() override { return by_clock_->clock(); }

  /// When what is heard now was recorded, by its level.
  double recorded() {
    const auto at = static_cast<std::size_t>(*by_clock_->heard()) * kOutputChannels;
    return at < written.size() ? std::abs(written[at]) / 0.1 - 1 : -1;
  }

  std::vector<float> written;
  bool gone = false;

 private:
  std::unique_ptr<capture::SoundOutput> by_clock_;
};

class SoundLeads : public testing::Test {
 protected:
  SoundLeads() {
    record(folder_ / "take");
    auto take = capture::TakeReader::open(folder_ / "take");
    EXPECT_THAT(take, IsOk());
    take_ = std::move(*take);
    auto output = std::make_unique<Remembers>(now_);
    output_ = output.get();
    std::string problem;
    player_ = SoundPlayer::of_take(*take_, std::move(output), problem, SoundPlayer::Feeding::ByHand);
    EXPECT_EQ(problem, "");
    lead_.emplace(player_.get());
  }

  /// The window draws a picture that takes `took` seconds, meanwhile the output is fed.
  void draw(double took, double ahead = 0) {
    lead_->advance(time_, took, seconds(now_ - Timestamp{}), ahead, by_path_);
    player_->feed();
    for (double left = took; left > 1e-9; left -= 0.01) {
      now_ = now_ + Nanoseconds{std::llround(std::min(left, 0.01) * 1e9)};
      player_->feed();
    }
  }

  /// When the frame that the time line shows was taken.
  double shown() const { return player_->clock().seconds_at(time_.position()); }

  TempFolder folder_;
  Timestamp now_{1'000'000'000};
  std::unique_ptr<capture::TakeReader> take_;
  Remembers* output_ = nullptr;
  std::unique_ptr<SoundPlayer> player_;
  std::optional<SoundLead> lead_;
  TimeLine time_{kFrames, kFps};
  bool by_path_ = false;
};

TEST_F(SoundLeads, PicturesToWhatIsHeardHoweverLongTheyTake) {
  time_.playing = true;
  time_.loop = false;
  int pictures = 0;
  for (const double took : {0.02, 0.02, 0.3, 0.02, 0.7, 0.04, 0.11, 0.5, 0.02}) {
    draw(took);
    if (output_->recorded() < 0.1) continue;
    lead_->advance(time_, 0, seconds(now_ - Timestamp{}), 0, false);
    EXPECT_NEAR(shown(), output_->recorded(), 0.002) << "after a picture of " << took << " s";
    ++pictures;
  }
  EXPECT_GE(pictures, 5);
}

TEST_F(SoundLeads, WithWhatWillBeHeardOncePicturesAreSeen) {
  time_.playing = true;
  for (int i = 0; i < 8; ++i) draw(0.1, 0.1);
  lead_->advance(time_, 0, seconds(now_ - Timestamp{}), 0.1, false);
  EXPECT_NEAR(shown(), output_->recorded() + 0.1, 0.002);
}

TEST_F(SoundLeads, IsSilentWhileAHandSeeksAndGoesOnWhereItLetGo) {
  time_.playing = true;
  for (int i = 0; i < 10; ++i) draw(0.04);
  EXPECT_TRUE(lead_->heard());
  for (int i = 0; i < 10; ++i) {
    time_.seek(40 + i);
    draw(0.04);
    EXPECT_FALSE(lead_->heard()) << i;
    EXPECT_TRUE(output_->written.empty()) << "what was written is not heard any more";
  }
  for (int i = 0; i < 8; ++i) draw(0.04);
  EXPECT_TRUE(lead_->heard());
  lead_->advance(time_, 0, seconds(now_ - Timestamp{}), 0, false);
  EXPECT_NEAR(shown(), output_->recorded(), 0.002);
  EXPECT_GT(shown(), 49.0 / kFps);
}

TEST_F(SoundLeads, IsSilentWherePlayingIsNoneOfAsItWasRecorded) {
  draw(0.1);
  EXPECT_FALSE(lead_->heard()) << "paused";
  time_.step(1);
  draw(0.3);
  EXPECT_FALSE(lead_->heard()) << "stepped";
  time_.playing = true;
  for (const double speed : {0.5, 1.5}) {
    time_.speed = speed;
    for (int i = 0; i < 10; ++i) draw(0.04);
    EXPECT_FALSE(lead_->heard()) << speed;
  }
  time_.speed = 1;
  by_path_ = true;
  for (int i = 0; i < 10; ++i) draw(0.04);
  EXPECT_FALSE(lead_->heard()) << "a path says what is shown";
  by_path_ = false;
  for (int i = 0; i < 3; ++i) draw(0.04);
  EXPECT_TRUE(lead_->heard());
  time_.playing = false;
  draw(0.04);
  EXPECT_FALSE(lead_->heard()) << "paused again";
}

TEST_F(SoundLeads, BeginsAgainWithoutAGapWhereTheTakeLoops) {
  time_.playing = true;
  time_.seek(90);
  for (int i = 0; i < 6; ++i) draw(0.04);
  std::vector<float> levels;
  bool again = false;
  for (int i = 0; i < 20; ++i) {
    draw(0.04);
    lead_->advance(time_, 0, seconds(now_ - Timestamp{}), 0, false);
    again = again || time_.frame() < 10;
    EXPECT_NEAR(shown(), output_->recorded(), 0.002);
  }
  EXPECT_TRUE(again);
  // From the end's level to the first one's in one sample.
  std::size_t jumps = 0;
  for (std::size_t i = kOutputChannels; i < output_->written.size(); i += kOutputChannels)
    jumps += std::abs(output_->written[i] - output_->written[i - kOutputChannels]) > 0.1f ? 1 : 0;
  EXPECT_EQ(jumps, 1u);
}

TEST_F(SoundLeads, EndsWithTheTakeWhereItDoesNotLoop) {
  time_.playing = true;
  time_.loop = false;
  time_.seek(80);
  for (int i = 0; i < 60 && time_.playing; ++i) draw(0.04);
  EXPECT_FALSE(time_.playing);
  EXPECT_EQ(time_.frame(), kFrames - 1);
  EXPECT_FALSE(lead_->heard());
}

TEST_F(SoundLeads, MutesAtOnceAndChangesTracksWithoutLosingItsPlace) {
  time_.playing = true;
  for (int i = 0; i < 10; ++i) draw(0.04);
  player_->set_gain(0);
  draw(0.02);
  EXPECT_THAT(output_->written, testing::Each(0.f));
  lead_->advance(time_, 0, seconds(now_ - Timestamp{}), 0, false);
  EXPECT_NEAR(shown(), 0.42, 0.03) << "silent, and still in step";
  player_->set_gain(1);
  player_->choose(1);
  for (int i = 0; i < 5; ++i) draw(0.04);
  EXPECT_LT(output_->written.back(), 0) << "the other track falls";
  lead_->advance(time_, 0, seconds(now_ - Timestamp{}), 0, false);
  EXPECT_NEAR(shown(), output_->recorded(), 0.002);
}

TEST_F(SoundLeads, GoesOnByTheWallWhereTheDeviceIsGoneAndSaysSoOnce) {
  time_.playing = true;
  for (int i = 0; i < 10; ++i) draw(0.04);
  output_->gone = true;
  const double before = time_.position();
  for (int i = 0; i < 10; ++i) draw(0.04);
  EXPECT_NEAR(time_.position(), before + 10, 1.1);
  EXPECT_EQ(player_->take_problem(), "the loudspeaker is gone");
  EXPECT_EQ(player_->take_problem(), std::nullopt);
}

TEST(AFrameClock, FollowsThePicturesOwnTimes) {
  const FrameClock clock(std::vector<double>{0, 0.04, 0.09, 0.12});
  EXPECT_DOUBLE_EQ(clock.length(), 0.16);
  EXPECT_DOUBLE_EQ(clock.seconds_at(1.5), 0.065);
  EXPECT_DOUBLE_EQ(clock.position_at(0.065), 1.5);
  EXPECT_DOUBLE_EQ(clock.position_at(-1), 0);
  EXPECT_DOUBLE_EQ(clock.position_at(9), 4);
  for (double p = 0; p < 4; p += 0.13) EXPECT_NEAR(clock.position_at(clock.seconds_at(p)), p, 1e-9);
  EXPECT_FALSE(FrameClock(std::vector<double>{0}).known());
}

}  // namespace
}  // namespace floatstage::apps
