// Reading any picture or video, and writing videos.

#include "capture/media_file.h"

#include <cmath>
#include <cstring>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "core/png.h"
#include "core/text.h"
#include "tests/capture/still_pictures.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::capture {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::Field;
using testing::IsEmpty;

// Smooth in both directions, and different in each corner.
Image scene(int width, int height, int shift = 0) {
  Image image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::uint8_t* p = image.at(x, y);
      p[0] = static_cast<std::uint8_t>(30 + 200 * x / width);
      p[1] = static_cast<std::uint8_t>(30 + 200 * y / height);
      p[2] = static_cast<std::uint8_t>(60 + shift);
    }
  return image;
}

Image read_only_picture(const std::filesystem::path& file) {
  auto reader = MediaReader::open(file);
  EXPECT_THAT(reader, IsOk());
  if (!reader) return {};
  EXPECT_EQ((*reader)->frame_rate(), 0) << "a still has no rate";
  Result<Image> image = (*reader)->next();
  EXPECT_THAT(image, IsOk());
  EXPECT_THAT((*reader)->next(), FailsWith(ErrorCode::EndOfStream, "1 pictures"));
  return image ? *image : Image{};
}

std::array<int, 3> color_at(const Image& image, int x, int y) {
  const std::uint8_t* p = image.at(x, y);
  return {p[0], p[1], p[2]};
}

TEST(MediaReader, ReadsAPngExactly) {
  const TempFolder folder;
  const Image image = scene(21, 13);
  ASSERT_THAT(save_png(image, folder / "a.png"), IsOk());
  EXPECT_EQ(read_only_picture(folder / "a.png"), image);
}

TEST(MediaReader, IsNotLedByTheNameOfAFile) {
  const TempFolder folder;
  const Image image = scene(8, 8);
  for (const char* name : {"shot%03d.png", "http:a.png", "no-extension", "a.mp4"}) {
    ASSERT_THAT(save_png(image, folder / "a.png"), IsOk());
    std::filesystem::rename(folder / "a.png", folder / name);
    EXPECT_EQ(read_only_picture(folder / name), image) << name;
  }
}

TEST(MediaReader, MakesGreyPicturesRgb) {
  const TempFolder folder;
  Image gray(5, 4, 1);
  for (int i = 0; i < 20; ++i) gray.pixels[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(13 * i);
  ASSERT_THAT(save_png(gray, folder / "a.png"), IsOk());
  const Image rgb = read_only_picture(folder / "a.png");
  ASSERT_EQ(rgb.channels, 3);
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 5; ++x) {
      const int v = gray.at(x, y)[0];
      EXPECT_EQ(color_at(rgb, x, y), (std::array{v, v, v})) << x << " " << y;
    }
}

TEST(MediaReader, MakesOneBitPicturesBlackAndWhite) {
  const TempFolder folder;
  folder.write("a.png", encode_still("png", "monob", 16, 4,
                                     [](int x, int y, int) { return static_cast<unsigned>((x + y) % 2); }));
  const Image rgb = read_only_picture(folder / "a.png");
  ASSERT_EQ(rgb.width, 16);
  EXPECT_EQ(color_at(rgb, 0, 0), (std::array{0, 0, 0}));
  EXPECT_EQ(color_at(rgb, 1, 0), (std::array{255, 255, 255}));
  EXPECT_EQ(color_at(rgb, 1, 1), (std::array{0, 0, 0}));
}

TEST(MediaReader, RoundsSixteenBitsToEight) {
  const TempFolder folder;
  auto value = [](int x, int y, int c) {
    return static_cast<unsigned>((x * 9377 + y * 311 + c * 20011) % 65536);
  };
  folder.write("rgb.png", encode_still("png", "rgb48be", 9, 5, value));
  folder.write("gray.png", encode_still("png", "gray16be", 9, 5, value));
  const Image rgb = read_only_picture(folder / "rgb.png"), gray = read_only_picture(folder / "gray.png");
  ASSERT_EQ(rgb.width, 9);
  ASSERT_EQ(gray.width, 9);
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 9; ++x)
      for (int c = 0; c < 3; ++c) {
        EXPECT_EQ(rgb.at(x, y)[c], std::lround(value(x, y, c) / 257.0));
        EXPECT_EQ(gray.at(x, y)[c], std::lround(value(x, y, 0) / 257.0));
      }
}

TEST(MediaReader, DropsTransparency) {
  const TempFolder folder;
  Image rgba(4, 4, 4);
  for (int i = 0; i < 16; ++i) {
    const std::uint8_t pixel[4] = {200, 100, 50, static_cast<std::uint8_t>(16 * i)};
    std::memcpy(rgba.pixels.data() + 4 * i, pixel, 4);
  }
  ASSERT_THAT(save_png(rgba, folder / "a.png"), IsOk());
  const Image rgb = read_only_picture(folder / "a.png");
  EXPECT_EQ(color_at(rgb, 1, 0), (std::array{200, 100, 50}));
}

TEST(MediaReader, ReadsJpegAsFullRange) {
  const TempFolder folder;
  for (const char* format : {"yuvj444p", "yuvj420p"}) {
    // Left: white; right: pure red, as JFIF (BT.601, 0..255) writes them.
    auto sample = [&](int x, int, int c) -> unsigned {
      const bool right = x >= (std::strcmp(format, "yuvj420p") == 0 && c > 0 ? 16 : 32);
      return right ? (c == 0 ? 76 : c == 1 ? 85 : 255) : (c == 0 ? 255 : 128);
    };
    folder.write("a.jpg", encode_still("mjpeg", format, 64, 32, sample));
    const Image rgb = read_only_picture(folder / "a.jpg");
    ASSERT_EQ(rgb.width, 64) << format;
    EXPECT_THAT(color_at(rgb, 8, 16), ElementsAre(testing::Ge(253), testing::Ge(253), testing::Ge(253)))
        << format;
    EXPECT_THAT(color_at(rgb, 56, 16), ElementsAre(testing::Ge(251), testing::Le(4), testing::Le(4)))
        << format;
  }
}

TEST(MediaReader, NamesAFileThatIsMissingOrNoPicture) {
  const TempFolder folder;
  EXPECT_THAT(MediaReader::open(folder / "none.png"), FailsWith(ErrorCode::NotFound, "none.png"));
  EXPECT_THAT(MediaReader::open(folder.write("text.png", "this is no picture")),
              FailsWith(ErrorCode::BadData, "text.png"));
  EXPECT_THAT(MediaReader::open(folder.write("empty.png", "")), FailsWith(ErrorCode::BadData, "empty.png"));
  EXPECT_THAT(MediaReader::open(folder.path()), FailsWith(ErrorCode::Io, "folder"));
}

TEST(MediaReader, OpensNoOtherFileForAPlayList) {
  const TempFolder folder;
  ASSERT_THAT(save_png(scene(8, 8), folder / "a.png"), IsOk());
  const auto list = folder.write("list.txt", "ffconcat version 1.0\nfile a.png\n");
  auto reader = MediaReader::open(list);
  if (reader) {
    EXPECT_FALSE((*reader)->next().has_value());
  }
}

TEST(MediaReader, NeverCrashesOnATruncatedPicture) {
  const TempFolder folder;
  const Image image = scene(24, 16);
  ASSERT_THAT(save_png(image, folder / "a.png"), IsOk());
  auto sample = [](int x, int y, int) { return static_cast<unsigned>(40 + 3 * x + 5 * y); };
  const std::string whole[] = {read_file(folder / "a.png").value(),
                               encode_still("mjpeg", "yuvj420p", 24, 16, sample)};
  for (const std::string& bytes : whole) {
    ASSERT_FALSE(bytes.empty());
    for (std::size_t length = 0; length < bytes.size(); length += 7) {
      auto reader = MediaReader::open(folder.write("cut", std::string_view(bytes).substr(0, length)));
      if (!reader) continue;
      const Result<Image> read = (*reader)->next();
      if (read) {
        EXPECT_EQ(read->pixels.size(), image.pixels.size()) << length;
      }
    }
  }
}

std::filesystem::path write_video(const std::filesystem::path& file, int width, int height, int pictures,
                                  double rate = 25) {
  auto writer = VideoWriter::create(file, width, height, rate);
  EXPECT_THAT(writer, IsOk());
  for (int k = 0; k < pictures; ++k) EXPECT_THAT((*writer)->write(scene(width, height, 2 * k)), IsOk());
  EXPECT_THAT((*writer)->finish(), IsOk());
  return file;
}

TEST(VideoWriter, WritesWhatMediaReaderReads) {
  const TempFolder folder;
  write_video(folder / "a.mp4", 96, 64, 30, 30);
  EXPECT_THAT(folder.names(), ElementsAre("a.mp4"));
  auto reader = MediaReader::open(folder / "a.mp4");
  ASSERT_THAT(reader, IsOk());
  EXPECT_DOUBLE_EQ((*reader)->frame_rate(), 30);
  for (int k = 0; k < 30; ++k)
    EXPECT_THAT((*reader)->next(), IsOkAnd(ImageNear(scene(96, 64, 2 * k), 36.0))) << k;
  EXPECT_THAT((*reader)->next(), FailsWith(ErrorCode::EndOfStream, "30 pictures"));
}

TEST(VideoWriter, KeepsColours) {
  const TempFolder folder;
  const std::array<std::array<int, 3>, 5> colors = {
      {{255, 0, 0}, {0, 255, 0}, {0, 0, 255}, {255, 255, 255}, {16, 120, 60}}};
  for (const auto& color : colors) {
    Image image(32, 32, 3);
    for (std::size_t i = 0; i < image.pixels.size(); ++i)
      image.pixels[i] = static_cast<std::uint8_t>(color[i % 3]);
    auto writer = VideoWriter::create(folder / "a.mp4", 32, 32, 25);
    ASSERT_THAT(writer, IsOk());
    ASSERT_THAT((*writer)->write(image), IsOk());
    ASSERT_THAT((*writer)->finish(), IsOk());
    auto reader = MediaReader::open(folder / "a.mp4");
    ASSERT_THAT(reader, IsOk());
    const Image back = (*reader)->next().value();
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(back.at(16, 16)[c], color[static_cast<std::size_t>(c)], 4)
          << text(color[0], ' ', color[1], ' ', color[2]);
  }
}

TEST(VideoWriter, TagsBt709AndPutsTheIndexFirst) {
  const TempFolder folder;
  const std::string bytes = read_file(write_video(folder / "a.mp4", 32, 32, 3)).value();
  const std::size_t moov = bytes.find("moov"), mdat = bytes.find("mdat"), colr = bytes.find("colrnclx");
  ASSERT_NE(moov, std::string::npos);
  EXPECT_LT(moov, mdat);
  ASSERT_NE(colr, std::string::npos);
  EXPECT_EQ(bytes.substr(colr + 8, 7), std::string("\0\1\0\1\0\1\0", 7))
      << "primaries, transfer, matrix, limited range";
}

TEST(VideoWriter, GrowsOddSizesByRepeatingTheEdge) {
  const TempFolder folder;
  write_video(folder / "a.mp4", 33, 21, 2);
  auto reader = MediaReader::open(folder / "a.mp4");
  ASSERT_THAT(reader, IsOk());
  const Image back = (*reader)->next().value();
  ASSERT_EQ(back.width, 34);
  ASSERT_EQ(back.height, 22);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(back.at(33, 21)[c], scene(33, 21).at(32, 20)[c], 8);
}

TEST(VideoWriter, HasTheSameBytesEachTime) {
  const TempFolder folder;
  EXPECT_EQ(read_file(write_video(folder / "a.mp4", 64, 48, 12)).value(),
            read_file(write_video(folder / "b.mp4", 64, 48, 12)).value());
}

// A small checked figure that walks and fades in the dark.
Image walker(int i) {
  Image image(64, 48, 3, 0);
  for (int y = 14; y < 40; ++y)
    for (int x = 0; x < 12; ++x) {
      std::uint8_t* p = image.at(8 + (x + i) % 44, y);
      for (int c = 0; c < 3; ++c)
        p[c] = static_cast<std::uint8_t>(40 + (37 * (x / 2 + y / 3) * (c + 1) + 5 * i) % 190);
    }
  return image;
}

// x264 decided by memory that it had not written: about one film of three was another.
TEST(VideoWriter, SmallPicturesHaveTheSameBytesEachTimeToo) {
  const TempFolder folder;
  std::set<std::string> films;
  for (int film = 0; film < 40; ++film) {
    auto writer = VideoWriter::create(folder / "a.mp4", 64, 48, 25);
    ASSERT_THAT(writer, IsOk());
    for (int i = 0; i < 50; ++i) ASSERT_THAT((*writer)->write(walker(i)), IsOk());
    ASSERT_THAT((*writer)->finish(), IsOk());
    films.insert(read_file(folder / "a.mp4").value());
  }
  EXPECT_EQ(films.size(), 1u);
}

TEST(VideoWriter, LeavesTheOldFileUntilItIsFinished) {
  const TempFolder folder;
  folder.write("a.mp4", "the old video");
  {
    auto writer = VideoWriter::create(folder / "a.mp4", 32, 32, 25);
    ASSERT_THAT(writer, IsOk());
    ASSERT_THAT((*writer)->write(scene(32, 32)), IsOk());
  }
  EXPECT_THAT(folder.names(), ElementsAre("a.mp4"));
  EXPECT_EQ(read_file(folder / "a.mp4").value(), "the old video");
}

TEST(VideoWriter, RefusesWhatCannotBeAVideo) {
  const TempFolder folder;
  EXPECT_THAT(VideoWriter::create(folder / "a.mp4", 0, 32, 25),
              FailsWith(ErrorCode::InvalidArgument, "0x32"));
  EXPECT_THAT(VideoWriter::create(folder / "a.mp4", 32, 32, 0),
              FailsWith(ErrorCode::InvalidArgument, "at 0"));
  EXPECT_THAT(VideoWriter::create(folder / "a.mp4", 32, 32, std::nan("")),
              FailsWith(ErrorCode::InvalidArgument, "nan"));
  EXPECT_THAT(VideoWriter::create(folder / "none" / "a.mp4", 32, 32, 25), FailsWith(ErrorCode::Io, "a.mp4"));
  auto writer = VideoWriter::create(folder / "a.mp4", 32, 32, 25);
  ASSERT_THAT(writer, IsOk());
  EXPECT_THAT((*writer)->write(scene(31, 32)), FailsWith(ErrorCode::InvalidArgument, "31x32"));
  EXPECT_THAT((*writer)->write(Image(32, 32, 1)), FailsWith(ErrorCode::InvalidArgument, "1 channels"));
  EXPECT_THAT((*writer)->finish(), FailsWith(ErrorCode::InvalidArgument, "at least one picture"));
  writer->reset();
  EXPECT_THAT(folder.names(), IsEmpty());
}

// The 3x3 matrix of the track header, as phones write it: 16.16 fixed point, big-endian, 40 bytes into the
// box.
void set_track_matrix(const std::filesystem::path& file, const std::array<int, 9>& matrix) {
  std::string bytes = read_file(file).value();
  const std::size_t box = bytes.find("tkhd");
  ASSERT_NE(box, std::string::npos);
  for (std::size_t i = 0; i < 9; ++i) {
    const auto value = static_cast<std::uint32_t>(matrix[i]) * (i % 3 == 2 ? 0x40000000u : 0x10000u);
    for (int b = 0; b < 4; ++b)
      bytes[box + 4 + 40 + 4 * i + static_cast<std::size_t>(b)] = static_cast<char>(value >> (24 - 8 * b));
  }
  ASSERT_THAT(write_file(file, bytes), IsOk());
}

struct Turn {
  const char* name;
  std::array<int, 9> matrix;
  bool portrait;
  std::array<int, 2>
      top_left_from;  // the corner of the stored picture that must be at the top left: 0 or 1 for x and y
};

class TurnedVideo : public testing::TestWithParam<Turn> {};

TEST_P(TurnedVideo, IsPutUpright) {
  const TempFolder folder;
  write_video(folder / "a.mp4", 64, 48, 1);
  set_track_matrix(folder / "a.mp4", GetParam().matrix);
  auto reader = MediaReader::open(folder / "a.mp4");
  ASSERT_THAT(reader, IsOk());
  const Result<Image> image = (*reader)->next();
  const int width = GetParam().portrait ? 48 : 64, height = GetParam().portrait ? 64 : 48;
  ASSERT_THAT(image, IsOkAnd(AllOf(Field(&Image::width, width), Field(&Image::height, height))));
  const Image stored = scene(64, 48);
  const auto [x, y] = GetParam().top_left_from;
  for (int c = 0; c < 2; ++c) EXPECT_NEAR(image->at(2, 2)[c], stored.at(x ? 61 : 2, y ? 45 : 2)[c], 6);
}

INSTANTIATE_TEST_SUITE_P(
    AllTurns, TurnedVideo,
    testing::Values(Turn{"none", {1, 0, 0, 0, 1, 0, 0, 0, 1}, false, {0, 0}},
                    Turn{"quarter_clockwise", {0, 1, 0, -1, 0, 0, 0, 0, 1}, true, {0, 1}},
                    Turn{"half", {-1, 0, 0, 0, -1, 0, 0, 0, 1}, false, {1, 1}},
                    Turn{"quarter_counter_clockwise", {0, -1, 0, 1, 0, 0, 0, 0, 1}, true, {1, 0}}),
    [](const auto& tested) { return std::string(tested.param.name); });

}  // namespace
}  // namespace floatstage::capture
