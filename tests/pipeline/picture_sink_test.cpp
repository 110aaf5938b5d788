#include "pipeline/picture_sink.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/media_file.h"
#include "core/png.h"
#include "tests/support/matchers.h"
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
