#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/media_file.h"
#include "core/file.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 64, kHeight = 48;

// A square that wanders over a slope: something to predict, and to predict wrongly.
Image picture(int index) {
  Image image(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      for (int c = 0; c < 3; ++c)
        image.at(x, y)[c] = static_cast<std::uint8_t>(
            (x + 2 * index) % kWidth < 12 && y > 10 && y < 30 ? 230 - 30 * c : 40 + 2 * x + 20 * c);
  return image;
}

fs::path film(const fs::path& file, int first, int count, double rate, int width = kWidth) {
  auto writer = VideoWriter::create(file, width, kHeight, rate);
  EXPECT_THAT(writer, IsOk());
  for (int i = 0; i < count; ++i)
    EXPECT_THAT((*writer)->write(width == kWidth ? picture(first + i) : Image(width, kHeight, 3)), IsOk());
  EXPECT_THAT((*writer)->finish(), IsOk());
  return file;
}

std::vector<Image> decoded(const fs::path& file) {
  std::vector<Image> pictures;
  auto reader = MediaReader::open(file);
  EXPECT_THAT(reader, IsOk());
  for (Result<Image> p = (*reader)->next(); p; p = (*reader)->next()) pictures.push_back(std::move(*p));
  return pictures;
}

TEST(JoinedVideos, ShowWhatTheirPartsShowPictureByPicture) {
  const TempFolder folder;
  // Of one picture, of few, and of many with pictures that lean on later ones; a rate that is no whole
  // number.
  const double rate = 29.97;
  const std::vector<fs::path> parts = {film(folder / "a.mp4", 0, 50, rate),
                                       film(folder / "b.mp4", 50, 1, rate),
                                       film(folder / "c.mp4", 51, 7, rate)};
  ASSERT_THAT(join_videos(parts, rate, 58, folder / "whole.mp4"), IsOk());
  std::vector<Image> of_parts;
  for (const fs::path& part : parts)
    for (Image& p : decoded(part)) of_parts.push_back(std::move(p));
  const std::vector<Image> whole = decoded(folder / "whole.mp4");
  ASSERT_EQ(whole.size(), 58u);
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_EQ(whole[i], of_parts[i]) << i;
  EXPECT_DOUBLE_EQ((*MediaReader::open(folder / "whole.mp4"))->frame_rate(), rate);
}

TEST(JoinedVideos, AreInTheContainerThatTheirNameSaysWithTheSamePictures) {
  const TempFolder folder;
  const std::vector<fs::path> parts = {film(folder / "a.mp4", 0, 30, 25), film(folder / "b.mp4", 30, 12, 25)};
  ASSERT_THAT(join_videos(parts, 25, 42, folder / "whole.mp4"), IsOk());
  const std::vector<Image> pictures = decoded(folder / "whole.mp4");
  for (const auto& [name, begins] :
       {std::pair("whole.mkv", "\x1a\x45\xdf\xa3"), std::pair("whole.mov", "ftypqt  ")}) {
    ASSERT_THAT(join_videos(parts, 25, 42, folder / name), IsOk());
    EXPECT_NE(read_file(folder / name)->substr(0, 12).find(begins), std::string::npos) << name;
    EXPECT_EQ(decoded(folder / name), pictures) << name;
  }
}

TEST(JoinedVideos, OfTheSamePartsHaveTheSameBytes) {
  const TempFolder folder;
  const std::vector<fs::path> parts = {film(folder / "a.mp4", 0, 12, 25), film(folder / "b.mp4", 12, 12, 25)};
  for (const char* name : {"one.mp4", "two.mp4"})
    ASSERT_THAT(join_videos(parts, 25, 24, folder / name), IsOk());
  EXPECT_EQ(*read_file(folder / "one.mp4"), *read_file(folder / "two.mp4"));
}

TEST(JoinedVideos, LeaveNothingBehindWhenAPartIsMissingOrOtherwiseOrTooShort) {
  const TempFolder folder;
  const fs::path a = film(folder / "a.mp4", 0, 5, 25), wide = film(folder / "wide.mp4", 0, 5, 25, 96),
                 broken = folder.write("broken.mp4", "no film");
  const fs::path out = folder / "out.mp4";
  EXPECT_THAT(join_videos({a, folder / "none.mp4"}, 25, 10, out), FailsWith(ErrorCode::NotFound, "none.mp4"));
  EXPECT_THAT(join_videos({a, wide}, 25, 10, out), FailsWith(ErrorCode::BadData, "wide.mp4"));
  EXPECT_THAT(join_videos({a, broken}, 25, 10, out), FailsWith(ErrorCode::BadData, "broken.mp4"));
  EXPECT_THAT(join_videos({a, a}, 25, 11, out), FailsWith(ErrorCode::BadData, "10 pictures and not 11"));
  EXPECT_THAT(folder.names(), testing::UnorderedElementsAre("a.mp4", "wide.mp4", "broken.mp4"));
}

TEST(JoinedVideos, NeverReplaceAFile) {
  const TempFolder folder;
  const fs::path a = film(folder / "a.mp4", 0, 5, 25);
  folder.write("out.mp4", "mine");
  EXPECT_THAT(join_videos({a}, 25, 5, folder / "out.mp4"), FailsWith(ErrorCode::AlreadyExists, "out.mp4"));
  EXPECT_EQ(*read_file(folder / "out.mp4"), "mine");
}

}  // namespace
}  // namespace floatstage::capture
