#include "pipeline/import/media_files.h"

#include <fstream>

#include <gmock/gmock.h>

#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Which media a camera finds depends on names alone: the files are empty.
void touch(const std::filesystem::path& file) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file).put('x');
}

calib::ForeignRig named(const std::vector<std::string>& images, const std::vector<std::string>& serials) {
  calib::ForeignRig foreign;
  foreign.image_names = images;
  for (const std::string& serial : serials) foreign.rig.cameras.push_back({serial, {}, {}, {}});
  return foreign;
}

std::vector<std::string> names(const CameraMedia& media) {
  std::vector<std::string> out;
  for (const auto& p : media.stills) out.push_back(p.filename().string());
  if (!media.video.empty()) out.push_back(media.video.filename().string());
  return out;
}

TEST(MediaFiles, TakesTheImageThatTheCalibrationNames) {
  TempFolder folder;
  touch(folder / "a.png");
  touch(folder / "a.txt");
  touch(folder / "b.png");
  const Result<MediaSearch> found = find_media(folder.path(), named({"a.png", "c.png"}, {"a.png", "c.png"}));
  ASSERT_THAT(found, IsOk());
  EXPECT_THAT(names(found->cameras[0]), ElementsAre("a.png"));
  EXPECT_TRUE(found->cameras[1].empty());
  EXPECT_THAT(found->unused, ElementsAre("b.png"));
}

TEST(MediaFiles, TakesAllPicturesOfAFolderNamedAfterTheCameraInNaturalOrder) {
  TempFolder folder;
  for (const char* file : {"a/f10.png", "a/f9.png", "a/f1.png", "a/notes.txt", "a/.hidden.png"})
    touch(folder / file);
  const Result<MediaSearch> found = find_media(folder.path(), named({"a"}, {"a"}));
  ASSERT_THAT(found, IsOk());
  EXPECT_THAT(names(found->cameras[0]), ElementsAre("f1.png", "f9.png", "f10.png"));
  EXPECT_THAT(found->unused, IsEmpty());
}

TEST(MediaFiles, TakesTheFilmAroundACalibratedPictureInAFolderOfItsOwn) {
  TempFolder folder;
  for (const char* file : {"a/1.png", "a/2.png", "b/1.png", "b/2.png"}) touch(folder / file);
  const Result<MediaSearch> found =
      find_media(folder.path(), named({"a/1.png", "b/1.png"}, {"a_1.png", "b_1.png"}));
  ASSERT_THAT(found, IsOk());
  EXPECT_THAT(names(found->cameras[1]), ElementsAre("1.png", "2.png"));
}

TEST(MediaFiles, KeepsCamerasThatShareAFolderAtOnePictureEach) {
  TempFolder folder;
  for (const char* file : {"all/1.png", "all/2.png"}) touch(folder / file);
  const Result<MediaSearch> found =
      find_media(folder.path(), named({"all/1.png", "all/2.png"}, {"all_1.png", "all_2.png"}));
  ASSERT_THAT(found, IsOk());
  EXPECT_THAT(names(found->cameras[0]), ElementsAre("1.png"));
  EXPECT_THAT(names(found->cameras[1]), ElementsAre("2.png"));
}

TEST(MediaFiles, TakesVideosNamedAfterTheSerialOrEndingInIt) {
  TempFolder folder;
  for (const char* file : {"cam1.mp4", "walk_Miqus_1_23087.avi"}) touch(folder / file);
  const Result<MediaSearch> found =
      find_media(folder.path(), named({"cam1", "23087", "7"}, {"cam1", "23087", "7"}));
  ASSERT_THAT(found, IsOk());
  EXPECT_THAT(names(found->cameras[0]), ElementsAre("cam1.mp4"));
  EXPECT_THAT(names(found->cameras[1]), ElementsAre("walk_Miqus_1_23087.avi"));
  EXPECT_TRUE(found->cameras[2].empty()) << "23087 does not end in _7";
}

TEST(MediaFiles, RefusesToGuessBetweenTwo) {
  TempFolder folder;
  touch(folder / "a.png");
  touch(folder / "a.mp4");
  EXPECT_THAT(find_media(folder.path(), named({"a"}, {"a"})),
              FailsWith(ErrorCode::InvalidArgument, "camera 'a'"));
}

TEST(MediaFiles, NamesAFolderThatIsNotThere) {
  TempFolder folder;
  EXPECT_THAT(find_media(folder / "none", named({"a"}, {"a"})), FailsWith(ErrorCode::NotFound, "none"));
}

TEST(NaturalOrder, ComparesNumbersByValue) {
  EXPECT_TRUE(natural_less("a2", "a10"));
  EXPECT_FALSE(natural_less("a10", "a2"));
  EXPECT_TRUE(natural_less("a2b3", "a2b11"));
  EXPECT_TRUE(natural_less("f0009", "f10"));
  EXPECT_TRUE(natural_less("99999999999999999999998", "99999999999999999999999"));
  EXPECT_TRUE(natural_less("a", "ab"));
  EXPECT_NE(natural_less("a01", "a1"), natural_less("a1", "a01"));
  EXPECT_FALSE(natural_less("x7", "x7"));
}

}  // namespace
}  // namespace floatstage::pipeline
