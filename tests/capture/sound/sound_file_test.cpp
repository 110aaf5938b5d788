#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/sound/film_sound.h"
#include "capture/sound/media_sound.h"
#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

// A second of a tone that begins after 0.2 s.
FilmSound tone() {
  FilmSound sound;
  sound.channels = 2;
  sound.samples = kPlayOutRate;
  sound.read = [](std::int64_t first, std::span<float> to) {
    for (std::size_t i = 0; i < to.size(); ++i) {
      const double t = (static_cast<double>(first) + static_cast<double>(i / 2)) / kPlayOutRate;
      to[i] = t < 0.2 ? 0 : static_cast<float>(0.8 * std::sin(2 * 3.14159265358979 * 1000 * t));
    }
    return Result<void>();
  };
  return sound;
}

TEST(SoundFile, IsHeardAtItsTimeAndHasTheSameBytesEachTime) {
  const TempFolder folder;
  ASSERT_THAT(write_sound(tone(), folder / "a.m4a"), IsOk());
  ASSERT_THAT(write_sound(tone(), folder / "b.m4a"), IsOk());
  EXPECT_EQ(*read_file(folder / "a.m4a"), *read_file(folder / "b.m4a"));
  const auto sound = MediaSound::open(folder / "a.m4a");
  ASSERT_THAT(sound, IsOk());
  ASSERT_NE(*sound, nullptr);
  EXPECT_EQ((*sound)->channels(), 2);
  double begins = -1;
  for (auto block = (*sound)->next(); block && begins < 0; block = (*sound)->next())
    for (std::size_t i = 0; i < block->samples.size() && begins < 0; ++i)
      if (block->samples[i] > 0.4f) begins = seconds(block->time) + static_cast<double>(i / 2) / kPlayOutRate;
  EXPECT_NEAR(begins, 0.2, 0.002);
}

TEST(SoundFile, OverwritesNothingAndLeavesNothingWhereItFails) {
  const TempFolder folder;
  ASSERT_THAT(write_file(folder / "a.m4a", "mine"), IsOk());
  EXPECT_THAT(write_sound(tone(), folder / "a.m4a"), FailsWith(ErrorCode::AlreadyExists, "a.m4a"));
  FilmSound broken = tone();
  broken.read = [](std::int64_t first, std::span<float>) {
    return first == 0 ? Result<void>() : fail(ErrorCode::BadData, "mic.mka is damaged");
  };
  EXPECT_THAT(write_sound(broken, folder / "b.m4a"), FailsWith(ErrorCode::BadData, "mic.mka"));
  EXPECT_EQ(folder.names(), std::vector<std::string>{"a.m4a"});
}

}  // namespace
}  // namespace floatstage::capture
