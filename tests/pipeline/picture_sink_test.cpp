#include "pipeline/picture_sink.h"

#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/media_file.h"
#include "core/file.h"
#include "core/png.h"
#include "tests/support/matchers.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

TEST(PictureSink, WritesAFolderOfPngsThatAppearsWhenItIsWhole) {
  TempFolder folder;
  const fs::path out = folder.path() / "film";
  auto sink = open_picture_sink(out, 32, 16, 25);
  ASSERT_THAT(sink, IsOk());
  ASSERT_THAT((*sink)->write(Image(32, 16, 3, 10)), IsOk());
  ASSERT_THAT((*sink)->write(Image(32, 16, 3, 20)), IsOk());
  EXPECT_FALSE(fs::exists(out));
  ASSERT_THAT((*sink)->finish(), IsOk());
  EXPECT_EQ(*load_png(out / "000001.png"), Image(32, 16, 3, 20));
}

TEST(PictureSink, TakesAFoldersNameWithASlashAtItsEnd) {
  TempFolder folder;
  auto sink = open_picture_sink(folder.path() / "film/", 32, 16, 25);
  ASSERT_THAT(sink, IsOk());
  ASSERT_THAT((*sink)->write(Image(32, 16, 3, 10)), IsOk());
  ASSERT_THAT((*sink)->finish(), IsOk());
  EXPECT_EQ(*load_png(folder.path() / "film" / "000000.png"), Image(32, 16, 3, 10));
}

TEST(PictureSink, LeavesNothingBehindWhenItIsAbandoned) {
  TempFolder folder;
  for (const char* name : {"film", "film.mp4"}) {
    auto sink = open_picture_sink(folder.path() / name, 32, 16, 25);
    ASSERT_THAT(sink, IsOk());
    ASSERT_THAT((*sink)->write(Image(32, 16, 3)), IsOk());
  }
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(PictureSink, WritesAVideoThatOthersRead) {
  TempFolder folder;
  auto sink = open_picture_sink(folder.path() / "film.mp4", 64, 48, 25);
  ASSERT_THAT(sink, IsOk());
  for (int i = 0; i < 5; ++i) ASSERT_THAT((*sink)->write(Image(64, 48, 3, 90)), IsOk());
  ASSERT_THAT((*sink)->finish(), IsOk());
  auto reader = capture::MediaReader::open(folder.path() / "film.mp4");
  ASSERT_THAT(reader, IsOk());
  int pictures = 0;
  for (Result<Image> p = (*reader)->next(); p; p = (*reader)->next()) {
    EXPECT_NEAR(p->at(20, 20)[1], 90, 2);
    ++pictures;
  }
  EXPECT_EQ(pictures, 5);
}

TEST(PictureSink, WritesTheContainerThatTheNameSays) {
  TempFolder folder;
  for (const auto& [name, begins, kind] :
       {std::tuple("film.mp4", "ftypisom", "mov,mp4"), std::tuple("film.mov", "ftypqt  ", "mov,mp4"),
        std::tuple("film.mkv", "\x1a\x45\xdf\xa3", "matroska,webm")}) {
    const fs::path film = folder.path() / name;
    auto sink = open_picture_sink(film, 64, 48, 25);
    ASSERT_THAT(sink, IsOk());
    for (int i = 0; i < 30; ++i)
      ASSERT_THAT((*sink)->write(Image(64, 48, 3, static_cast<std::uint8_t>(8 * i))), IsOk());
    ASSERT_THAT((*sink)->finish(), IsOk());
    EXPECT_NE(read_file(film)->substr(0, 12).find(begins), std::string::npos) << name;
    const Ended probed = run_command(
        "ffprobe -v error -count_frames -show_entries "
        "format=format_name,start_time:stream=nb_read_frames,avg_frame_rate -of csv " +
        film.string());
    EXPECT_EQ(probed.code, 0) << probed.output;
    EXPECT_THAT(probed.output, testing::HasSubstr(kind));
    EXPECT_THAT(probed.output, testing::HasSubstr("25/1,30\n"));
    EXPECT_THAT(probed.output, testing::HasSubstr("0.000000")) << "begins at once";
  }
}

// Opacity from left to right, one colour: straight alpha keeps it where nothing is opaque.
Image fading(int width, int height) {
  Image picture(width, height, 4);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::uint8_t pixel[4] = {200, 120, 40, static_cast<std::uint8_t>(255 * x / (width - 1))};
      std::copy_n(pixel, 4, picture.at(x, y));
    }
  return picture;
}

TEST(PictureSink, KeepsOpacityInPngsAndInProRes) {
  TempFolder folder;
  const Image picture = fading(33, 17);
  for (const char* name : {"film", "film.mov"}) {
    auto sink = open_picture_sink(folder.path() / name, picture.width, picture.height, 25, true);
    ASSERT_THAT(sink, IsOk());
    for (int i = 0; i < 3; ++i) ASSERT_THAT((*sink)->write(picture), IsOk());
    ASSERT_THAT((*sink)->finish(), IsOk());
  }
  EXPECT_EQ(*load_png(folder.path() / "film" / "000001.png"), picture);

  // As another program reads it: three pictures of 16-bit RGBA.
  const std::string film = (folder.path() / "film.mov").string();
  const Ended probed =
      run_command("ffprobe -v error -show_entries stream=codec_name,profile,pix_fmt '" + film + "'");
  EXPECT_THAT(probed.output, testing::AllOf(testing::HasSubstr("prores"), testing::HasSubstr("4444"),
                                            testing::HasSubstr("yuva444p")));
  const fs::path pixels = folder.path() / "film.rgba";
  const Ended read =
      run_command("ffmpeg -v error -i '" + film + "' -f rawvideo -pix_fmt rgba '" + pixels.string() + "'");
  ASSERT_EQ(read.code, 0) << read.output;
  const Result<std::string> bytes = read_file(pixels);
  ASSERT_THAT(bytes, IsOk());
  ASSERT_EQ(bytes->size(), 3 * picture.pixels.size()) << read.output;
  for (std::size_t i = 0; i < picture.pixels.size(); ++i)
    EXPECT_NEAR(static_cast<std::uint8_t>((*bytes)[i]), picture.pixels[i], i % 4 == 3 ? 1 : 3) << i;
}

TEST(PictureSink, HoldsNoOpacityInH264) {
  TempFolder folder;
  EXPECT_THAT(open_picture_sink(folder.path() / "film.mp4", 32, 16, 25, true),
              FailsWith(ErrorCode::InvalidArgument, ".mov"));
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(PictureSink, RefusesToOverwriteAndSaysSo) {
  TempFolder folder;
  fs::create_directory(folder.path() / "film");
  EXPECT_THAT(open_picture_sink(folder.path() / "film", 32, 16, 25),
              FailsWith(ErrorCode::AlreadyExists, "another --out"));
  EXPECT_THAT(open_picture_sink(folder.path() / "film.gif", 32, 16, 25),
              FailsWith(ErrorCode::InvalidArgument, ".mp4"));
  EXPECT_THAT(open_picture_sink(folder.path() / "no" / "such" / "film.mp4", 32, 16, 25),
              FailsWith(ErrorCode::Io, "film.mp4"));
}

}  // namespace
}  // namespace floatstage::pipeline
