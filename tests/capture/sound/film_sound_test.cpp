#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/media_file.h"
#include "capture/sound/media_sound.h"
#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

constexpr int kPictures = 50;
constexpr std::int64_t kSamples = 2 * kPlayOutRate, kClick = 3 * kPlayOutRate / 2;

// Two seconds of pictures; a click at 1.5 s.
class AFilmWithSound : public testing::TestWithParam<const char*> {
 protected:
  AFilmWithSound() {
    sound_.channels = 2;
    sound_.samples = kSamples;
    sound_.read = [](std::int64_t first, std::span<float> to) -> Result<void> {
      for (std::size_t i = 0; i < to.size(); ++i)
        to[i] = first + static_cast<std::int64_t>(i) / 2 == kClick ? 0.9f : 0.f;
      return {};
    };
  }
  void SetUp() override {
    auto writer = VideoWriter::create(part_, 64, 48, 25);
    ASSERT_THAT(writer, IsOk());
    for (int i = 0; i < kPictures; ++i) {
      Image picture(64, 48, 3);
      std::fill(picture.pixels.begin(), picture.pixels.end(), static_cast<std::uint8_t>(4 * i));
      ASSERT_THAT((*writer)->write(picture), IsOk());
    }
    ASSERT_THAT((*writer)->finish(), IsOk());
  }
  TempFolder folder_;
  const std::filesystem::path part_ = folder_ / "part.mp4";
  FilmSound sound_;
};

TEST_P(AFilmWithSound, IsHeardWhereItShouldBeAndHasTheSameBytesEachTime) {
  const std::filesystem::path film = folder_ / (std::string("film") + GetParam()),
                              again = folder_ / (std::string("again") + GetParam());
  ASSERT_THAT(join_videos({part_}, 25, kPictures, film, &sound_), IsOk());
  ASSERT_THAT(join_videos({part_}, 25, kPictures, again, &sound_), IsOk());
  EXPECT_EQ(read_file(film).value(), read_file(again).value());

  const auto sound = MediaSound::open(film);
  ASSERT_THAT(sound, IsOk());
  ASSERT_TRUE(*sound);
  EXPECT_EQ((*sound)->channels(), 2);
  EXPECT_EQ((*sound)->rate(), kPlayOutRate);
  std::int64_t loudest = -1, samples = 0;
  float most = 0;
  for (;;) {
    const auto block = (*sound)->next();
    if (!block) break;
    const std::int64_t first = std::llround(seconds(block->time) * kPlayOutRate);
    for (std::size_t i = 0; i < block->samples.size(); i += 2)
      if (std::abs(block->samples[i]) > most)
        most = std::abs(block->samples[i]), loudest = first + static_cast<std::int64_t>(i) / 2;
    samples = first + static_cast<std::int64_t>(block->samples.size()) / 2;
  }
  EXPECT_NEAR(static_cast<double>(loudest), static_cast<double>(kClick), 48) << "a millisecond";
  EXPECT_GE(samples, kSamples);

  auto pictures = MediaReader::open(film);
  ASSERT_THAT(pictures, IsOk());
  int count = 0;
  for (; (*pictures)->next(); ++count) EXPECT_NEAR(seconds(*(*pictures)->time()), count / 25.0, 1e-3);
  EXPECT_EQ(count, kPictures);
}
INSTANTIATE_TEST_SUITE_P(InEachContainer, AFilmWithSound, testing::Values(".mp4", ".mkv", ".mov"));

TEST_F(AFilmWithSound, WhoseSoundCannotBeReadLeavesNothing) {
  sound_.read = [](std::int64_t, std::span<float>) -> Result<void> { return fail(ErrorCode::Io, "gone"); };
  EXPECT_THAT(join_videos({part_}, 25, kPictures, folder_ / "film.mp4", &sound_),
              FailsWith(ErrorCode::Io, "gone"));
  EXPECT_EQ(folder_.names(), std::vector<std::string>{"part.mp4"});
}

}  // namespace
}  // namespace floatstage::capture
