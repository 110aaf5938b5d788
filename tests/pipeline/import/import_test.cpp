#include "pipeline/import/import.h"

#include <gmock/gmock.h>

#include "calib/formats/format_files.h"
#include "core/file.h"
#include "core/png.h"
#include "pipeline/import/matte_files.h"
#include "tests/pipeline/import/import_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// What another program would have left: a calibration and pictures, below one folder.
class Import : public testing::Test {
 protected:
  Import() { options_.out = folder_ / "take"; }

  // Middlebury: a picture a camera, in the same folder.
  void middlebury_stills(int cameras) {
    std::vector<std::string> images;
    fs::create_directories(folder_ / "in");
    for (int i = 0; i < cameras; ++i) {
      images.push_back(std::string(1, static_cast<char>('a' + i)) + ".png");
      ASSERT_THAT(save_png(test_picture(i, 0), folder_ / "in" / images.back()), IsOk());
    }
    ASSERT_THAT(calib::write_middlebury(test_rig(cameras), images, folder_ / "in" / "x_par.txt"), IsOk());
    options_.calibration = {"middlebury", folder_ / "in"};
  }

  // OpenCV: a folder of pictures a camera, with as many pictures as `counts` says.
  void opencv_folders(const std::vector<int>& counts) {
    const Rig rig = test_rig(static_cast<int>(counts.size()));
    ASSERT_THAT(calib::write_easymocap(rig, folder_ / "in"), IsOk());
    for (std::size_t i = 0; i < counts.size(); ++i)
      save_pictures(folder_ / "in" / "images" / rig.cameras[i].serial, static_cast<int>(i), counts[i]);
    options_.calibration = {"opencv", folder_ / "in"};
    options_.frame_rate = 50;
  }

  // The take's picture must be the file's, byte by byte.
  static void expect_picture(capture::TakeReader& take, int camera, int frame, const Image& expected) {
    const Result<Frame> read = take.frame(camera, frame);
    ASSERT_THAT(read, IsOk());
    const Result<Image> rgb = to_rgb(*read);
    ASSERT_THAT(rgb, IsOk());
    EXPECT_TRUE(*rgb == expected) << "camera " << camera << ", frame " << frame;
  }

  std::unique_ptr<capture::TakeReader> imported() {
    report_ = import_take(options_);
    EXPECT_THAT(report_, IsOk());
    if (!report_) return nullptr;
    Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(options_.out);
    EXPECT_THAT(take, IsOk());
    return take ? std::move(*take) : nullptr;
  }

  // A failed import leaves the folder as it was.
  void expect_refused(ErrorCode code, const std::string& part) {
    const std::vector<std::string> before = folder_.names();
    EXPECT_THAT(import_take(options_), FailsWith(code, part));
    EXPECT_EQ(folder_.names(), before);
  }

  TempFolder folder_;
  ImportOptions options_;
  Result<ImportReport> report_ = ImportReport{};
};

TEST_F(Import, OneStillACameraBecomesATakeOfOneInstant) {
  middlebury_stills(3);
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_EQ(take->frame_count(), 1);
  EXPECT_EQ(take->manifest().frame_rate, 0);
  EXPECT_EQ(take->manifest().label, "middlebury");
  EXPECT_TRUE(take->manifest().complete);
  EXPECT_THAT(report_->serials, ElementsAre("a", "b", "c"));
  EXPECT_THAT(report_->notes, IsEmpty());
  for (int i = 0; i < 3; ++i) expect_picture(*take, i, 0, test_picture(i, 0));
}

TEST_F(Import, PixelsThatAreNotSquareAreSaidOfTheOddestCamera) {
  middlebury_stills(3);
  Rig rig = test_rig(3);
  rig.cameras[0].model.fy = 1.1 * rig.cameras[0].model.fx;
  rig.cameras[2].model.fy = 1.5 * rig.cameras[2].model.fx;
  ASSERT_THAT(calib::write_middlebury(rig, {"a.png", "b.png", "c.png"}, folder_ / "in" / "x_par.txt"),
              IsOk());
  ASSERT_TRUE(imported());
  EXPECT_THAT(report_->notes, ElementsAre(AllOf(HasSubstr("2 of 3 cameras"), HasSubstr("camera 'c'"))));
}

TEST_F(Import, TheRigGetsTheSizeOfItsPicturesAndKeepsItsGeometry) {
  middlebury_stills(2);
  const auto take = imported();
  ASSERT_TRUE(take);
  const Rig expected = test_rig(2);
  for (std::size_t i = 0; i < 2; ++i) {
    const RigCamera& c = take->rig().cameras[i];
    EXPECT_EQ(c.model.width, kImportWidth);
    EXPECT_EQ(c.model.height, kImportHeight);
    EXPECT_NEAR(c.model.cx, 16.25, 1e-12);
    EXPECT_LT((c.cam_from_world.matrix() - expected.cameras[i].cam_from_world.matrix()).norm(), 1e-12);
  }
}

TEST_F(Import, CamerasWithoutPicturesAndPicturesWithoutCameraAreLeftOutWithANote) {
  middlebury_stills(3);
  fs::remove(folder_ / "in" / "b.png");
  ASSERT_THAT(save_png(test_picture(0, 0), folder_ / "in" / "stranger.png"), IsOk());
  ASSERT_TRUE(imported());
  EXPECT_THAT(report_->serials, ElementsAre("a", "c"));
  EXPECT_THAT(report_->notes, ElementsAre(HasSubstr("left out: b"), HasSubstr("stranger.png")));
}

TEST_F(Import, FoldersOfPicturesBecomeFramesAtTheGivenRate) {
  opencv_folders({3, 3});
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_EQ(take->frame_count(), 3);
  EXPECT_EQ(take->manifest().frame_rate, 50);
  for (int camera = 0; camera < 2; ++camera)
    for (int frame = 0; frame < 3; ++frame) expect_picture(*take, camera, frame, test_picture(camera, frame));
  EXPECT_EQ(take->rows(1)[2].info.exposure_start.ns, 40'000'000);
}

TEST_F(Import, FoldersWithoutARateAreTakenAtTwentyFiveWithANote) {
  opencv_folders({2});
  options_.frame_rate.reset();
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_EQ(take->manifest().frame_rate, 25);
  EXPECT_THAT(report_->notes, ElementsAre(HasSubstr("25 frames a second")));
}

TEST_F(Import, AShorterCameraEndsInGapsThatKeepTheirRows) {
  opencv_folders({4, 2});
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_EQ(take->frame_count(), 4);
  EXPECT_EQ(report_->gaps, 2);
  ASSERT_EQ(take->rows(1).size(), 4u);
  EXPECT_EQ(take->rows(1)[3].info.status, FrameStatus::Lost);
  EXPECT_FALSE(take->rows(1)[3].media_index.has_value());
  EXPECT_THAT(report_->notes, Contains(HasSubstr("camera 'b' has 2 of 4 frames")));
}

TEST_F(Import, TakesOnlyTheFramesAndCamerasThatAreAskedFor) {
  opencv_folders({5, 5, 5});
  options_.frames = {.first = 1, .end = 3};
  options_.cameras = {"c", "a"};
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_THAT(report_->serials, ElementsAre("a", "c"));
  EXPECT_EQ(take->frame_count(), 2);
  expect_picture(*take, 1, 0, test_picture(2, 1));
  expect_picture(*take, 1, 1, test_picture(2, 2));
}

TEST_F(Import, ReadsVideosWithTheirOwnRate) {
  const Rig rig = test_rig(2);
  ASSERT_THAT(calib::write_colmap(rig, {"a.png", "b.png"}, folder_ / "in"), IsOk());
  fs::create_directories(folder_ / "in" / "images");
  for (int camera = 0; camera < 2; ++camera) {
    auto video = capture::VideoWriter::create(
        folder_ / "in" / "images" / (rig.cameras[static_cast<std::size_t>(camera)].serial + ".mp4"),
        kImportWidth, kImportHeight, 30);
    ASSERT_THAT(video, IsOk());
    for (int frame = 0; frame < 4; ++frame) ASSERT_THAT((*video)->write(test_picture(camera, frame)), IsOk());
    ASSERT_THAT((*video)->finish(), IsOk());
  }
  options_.calibration = {"colmap", folder_ / "in"};
  options_.frames.first = 1;
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_EQ(take->frame_count(), 3);
  EXPECT_NEAR(take->manifest().frame_rate, 30, 1e-6);
  const Result<Frame> frame = take->frame(1, 2);
  ASSERT_THAT(frame, IsOk());
  const Result<Image> rgb = to_rgb(*frame);
  ASSERT_THAT(rgb, IsOk());
  EXPECT_THAT(*rgb, ImageNear(test_picture(1, 3), 20.0));  // the video is lossy, the take is not
}

TEST_F(Import, TakesWhicheverCalibrationIsThere) {
  middlebury_stills(2);
  options_.calibration.format = calib::kAnyRigFormat;
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_EQ(take->manifest().label, "middlebury") << "the format that it was";
}

TEST_F(Import, FindsPicturesBesideACamchainByTheirTopics) {
  const Rig rig = test_rig(2);
  fs::create_directories(folder_ / "in");
  ASSERT_THAT(calib::write_kalibr(rig, folder_ / "in" / "camchain.yaml"), IsOk());
  for (int i = 0; i < 2; ++i)
    ASSERT_THAT(save_png(test_picture(i, 0),
                         folder_ / "in" / (rig.cameras[static_cast<std::size_t>(i)].serial + ".png")),
                IsOk());
  options_.calibration = {"kalibr", folder_ / "in"};
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_THAT(report_->serials, ElementsAre(rig.cameras[0].serial, rig.cameras[1].serial));
  expect_picture(*take, 1, 0, test_picture(1, 0));
}

TEST_F(Import, MattesBesideTheImagesSpareTheKeying) {
  middlebury_stills(2);
  fs::create_directories(folder_ / "mattes");
  Image matte(kImportWidth, kImportHeight, 1);
  matte.at(3, 4)[0] = 200;
  for (const char* name : {"a.png", "b.png"}) ASSERT_THAT(save_png(matte, folder_ / "mattes" / name), IsOk());
  options_.mattes = folder_ / "mattes";
  const auto take = imported();
  ASSERT_TRUE(take);
  const Result<Image> read = load_png(take->layout().matte("b", 0));
  ASSERT_THAT(read, IsOk());
  EXPECT_TRUE(*read == matte);
  EXPECT_FALSE(fs::exists(take->layout().made_mattes())) << "they are somebody's: used, never touched";
}

TEST_F(Import, TheAlphaOfPicturesThatHaveOneIsTheirMatte) {
  middlebury_stills(2);
  for (int i = 0; i < 2; ++i) {
    const Image rgb = test_picture(i, 0);
    Image rgba(rgb.width, rgb.height, 4, 255);
    for (std::size_t p = 0; p < rgb.pixels.size(); ++p) rgba.pixels[p / 3 * 4 + p % 3] = rgb.pixels[p];
    rgba.at(3, 4)[3] = 17;
    ASSERT_THAT(save_png(rgba, folder_ / "in" / (i == 0 ? "a.png" : "b.png")), IsOk());
  }
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_THAT(report_->notes, Contains(HasSubstr("alpha channel")));
  expect_picture(*take, 1, 0, test_picture(1, 0));
  const Result<Image> read = load_png(take->layout().matte("b", 0));
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(read->at(3, 4)[0], 17);
  EXPECT_EQ(read->at(4, 4)[0], 255);
}

TEST_F(Import, MattesAloneMakeATakeAndStandForItsPictures) {
  opencv_folders({1, 1});
  fs::remove_all(folder_ / "in" / "images");
  fs::create_directories(folder_ / "mattes");
  Image matte(kImportWidth, kImportHeight, 1);
  matte.at(3, 4)[0] = 200;
  const Rig rig = test_rig(2);
  for (const RigCamera& camera : rig.cameras)
    ASSERT_THAT(save_png(matte, folder_ / "mattes" / (camera.serial + ".png")), IsOk());
  expect_refused(ErrorCode::NotFound, "images");
  options_.mattes = folder_ / "mattes";
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_THAT(report_->notes, Contains(HasSubstr("the mattes are shown in their place")));
  const Result<Image> read = load_png(take->layout().matte(rig.cameras[1].serial, 0));
  ASSERT_THAT(read, IsOk());
  EXPECT_TRUE(*read == matte);
}

TEST_F(Import, NamesTheCameraWithoutAMatteAndKeepsItsPictures) {
  middlebury_stills(2);
  fs::create_directories(folder_ / "mattes");
  ASSERT_THAT(save_png(Image(kImportWidth, kImportHeight, 1), folder_ / "mattes" / "a.png"), IsOk());
  options_.mattes = folder_ / "mattes";
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_THAT(report_->notes, Contains(HasSubstr("camera 'b' has no matte")));
  EXPECT_TRUE(fs::exists(take->layout().matte("a", 0)));
  EXPECT_FALSE(fs::exists(take->layout().matte("b", 0)));
  expect_picture(*take, 1, 0, test_picture(1, 0));
}

TEST_F(Import, MattesOfNoCameraOrOfAnotherSizeAreRefused) {
  middlebury_stills(2);
  fs::create_directories(folder_ / "mattes");
  options_.mattes = folder_ / "mattes";
  expect_refused(ErrorCode::NotFound, "no matte for any camera");
  ASSERT_THAT(save_png(Image(kImportWidth, kImportHeight, 1), folder_ / "mattes" / "a.png"), IsOk());
  ASSERT_THAT(save_png(Image(kImportWidth, 7, 1), folder_ / "mattes" / "b.png"), IsOk());
  expect_refused(ErrorCode::BadData, "the matte is 32x7");
}

TEST_F(Import, PhotographsOfTheEmptyStageBecomePlates) {
  opencv_folders({2, 2, 2});
  fs::create_directories(folder_ / "empty");
  ASSERT_THAT(save_png(test_picture(0, 100), folder_ / "empty" / "a.png"), IsOk());
  save_pictures(folder_ / "empty" / "b", 1, 40);
  options_.plates = folder_ / "empty";
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_EQ(take->frame_count(), 2);
  EXPECT_EQ(report_->plates, 2);
  EXPECT_THAT(report_->notes, Contains(AllOf(HasSubstr("'c'"), HasSubstr("no plate"))));
  EXPECT_TRUE(*load_png(take->layout().plate("a")) == test_picture(0, 100));
  // Of the forty, every fourth: 16 at most, from the first on.
  const fs::path several = folder_ / "take" / "plates" / "b";
  int count = 0;
  for ([[maybe_unused]] const fs::directory_entry& entry : fs::directory_iterator(several)) ++count;
  EXPECT_EQ(count, 10);
  EXPECT_TRUE(*load_png(several / "00.png") == test_picture(1, 0));
  EXPECT_TRUE(*load_png(several / "09.png") == test_picture(1, 36));
  EXPECT_FALSE(fs::exists(folder_ / "take" / "plates" / "c.png"));
}

TEST_F(Import, PlatesOfNoCameraOrOfAnotherSizeAreRefused) {
  opencv_folders({1, 1});
  fs::create_directories(folder_ / "empty");
  options_.plates = folder_ / "empty";
  expect_refused(ErrorCode::NotFound, "no plate for any camera");
  ASSERT_THAT(save_png(test_picture(0, 0, 16, 24), folder_ / "empty" / "a.png"), IsOk());
  expect_refused(ErrorCode::BadData, "camera 'a': ");
  expect_refused(ErrorCode::BadData, "the plate is 16x24, but the pictures of camera 'a' are 32x24");
}

TEST_F(Import, NeverOverwrites) {
  middlebury_stills(1);
  fs::create_directories(folder_ / "take");
  folder_.write("take/mine.txt", "mine");
  expect_refused(ErrorCode::AlreadyExists, "nothing is ever overwritten");
  EXPECT_TRUE(fs::exists(folder_ / "take" / "mine.txt"));
}

TEST_F(Import, FillsAnEmptyFolderAndClearsWhatAKilledImportLeft) {
  middlebury_stills(1);
  fs::create_directories(folder_ / "take");
  fs::create_directories(temporary_name(folder_ / "take"));
  folder_.write(temporary_name("take").string() + "/half.mkv", "half");
  options_.out = (folder_ / "take").string() + "/";
  ASSERT_TRUE(imported());
  EXPECT_THAT(folder_.names(), ElementsAre("in", "take"));
}

TEST_F(Import, ADamagedPictureIsNamedAndNothingIsLeft) {
  opencv_folders({3, 3});
  folder_.write("in/images/b/000002.png", "not a picture");
  expect_refused(ErrorCode::BadData, "000002.png");
}

TEST_F(Import, PicturesOfAnotherSizeThanTheCalibrationsAreRefused) {
  opencv_folders({1, 1});
  ASSERT_THAT(save_png(test_picture(1, 0, 30, 24), folder_ / "in" / "images" / "b" / "000000.png"), IsOk());
  expect_refused(ErrorCode::BadData, "camera 'b': its pictures are 30x24, but it was calibrated for 32x24");
}

TEST_F(Import, ScaledPicturesScaleTheirCamerasCalibrationAxisByAxis) {
  opencv_folders({1, 1});
  ASSERT_THAT(save_png(test_picture(1, 0, 30, 24), folder_ / "in" / "images" / "b" / "000000.png"), IsOk());
  options_.other_size = OtherSize::Scaled;
  const auto take = imported();
  ASSERT_TRUE(take);
  EXPECT_THAT(report_->notes, Contains(HasSubstr("camera 'b': its pictures are 30x24")));
  const CameraModel before = test_rig(2).cameras[1].model, after = take->rig().cameras[1].model;
  EXPECT_EQ(after.width, 30);
  EXPECT_NEAR(after.fx, before.fx * 30 / 32, 1e-9);
  EXPECT_NEAR(after.cx, before.cx * 30 / 32, 1e-9);
  EXPECT_NEAR(after.fy, before.fy, 1e-9);
  EXPECT_NEAR(after.cy, before.cy, 1e-9);
  EXPECT_EQ(take->rig().cameras[0].model.width, 32) << "the other camera is as it was";
}

TEST_F(Import, CroppedPicturesKeepTheirPrincipalPointAndCannotBeLarger) {
  opencv_folders({1, 1});
  ASSERT_THAT(save_png(test_picture(1, 0, 30, 24), folder_ / "in" / "images" / "b" / "000000.png"), IsOk());
  options_.other_size = OtherSize::Cropped;
  {
    const auto take = imported();
    ASSERT_TRUE(take);
    EXPECT_NEAR(take->rig().cameras[1].model.cx, test_rig(2).cameras[1].model.cx, 1e-9);
    EXPECT_EQ(take->rig().cameras[1].model.width, 30);
  }
  ASSERT_THAT(save_png(test_picture(1, 0, 34, 24), folder_ / "in" / "images" / "b" / "000000.png"), IsOk());
  options_.out = folder_ / "other";
  expect_refused(ErrorCode::BadData, "cannot have been cropped");
}

TEST_F(Import, PicturesOfOneCameraMustKeepTheirSize) {
  opencv_folders({2});
  ASSERT_THAT(save_png(test_picture(0, 1, 30, 24), folder_ / "in" / "images" / "a" / "000001.png"), IsOk());
  expect_refused(ErrorCode::BadData, "picture 1 is 30x24");
}

TEST_F(Import, NamesWhatIsMissing) {
  options_.calibration = {"middlebury", folder_ / "nowhere"};
  expect_refused(ErrorCode::NotFound, "nowhere");
  middlebury_stills(2);
  options_.cameras = {"z"};
  expect_refused(ErrorCode::InvalidArgument, "no camera 'z'");
  options_.cameras.clear();
  options_.frames.first = 3;  // a range does not apply to a single still
  EXPECT_THAT(import_take(options_), IsOk());
  fs::remove(folder_ / "in" / "a.png");
  fs::remove(folder_ / "in" / "b.png");
  options_.out = folder_ / "other";
  expect_refused(ErrorCode::NotFound, "named after a camera");
}

TEST_F(Import, RefusesARangeBehindTheEnd) {
  opencv_folders({2});
  options_.frames.first = 2;
  expect_refused(ErrorCode::NotFound, "no picture from number 2 on");
}

TEST_F(Import, GivesTheSameBytesAtAnyThreadCount) {
  opencv_folders({3, 2});
  options_.threads = 1;
  ASSERT_TRUE(imported());
  options_.out = folder_ / "again";
  options_.threads = 4;
  ASSERT_TRUE(imported());
  for (const char* file : {"a.mkv", "b.mkv", "a.frames.csv", "b.frames.csv", "rig.json"})
    EXPECT_EQ(*read_file(folder_ / "take" / file), *read_file(folder_ / "again" / file)) << file;
}

TEST(FrameRange, IsWrittenWithAColon) {
  EXPECT_EQ(parse_frame_range("2:5")->first, 2);
  EXPECT_EQ(parse_frame_range("2:5")->end, 5);
  EXPECT_EQ(parse_frame_range("2:")->end, std::nullopt);
  EXPECT_EQ(parse_frame_range(":5")->first, 0);
  EXPECT_EQ(parse_frame_range("2:9:3")->step, 3);
  EXPECT_EQ(parse_frame_range("5")->first, 5);
  EXPECT_EQ(parse_frame_range("5")->end, 6);
  for (const char* bad : {"", ":", "5:5", "5:2", "-1:2", "a:b", "1:2:0", "1:2:3:4", "::"})
    EXPECT_THAT(parse_frame_range(bad), FailsWith(ErrorCode::InvalidArgument, bad)) << bad;
}

TEST(ImportedMatte, ComesFromAlphaOrGreyAndMasksOfOnesAreScaled) {
  Image grey(2, 1, 1), mask(2, 1, 1), rgba(2, 1, 4), colour(2, 1, 3);
  grey.at(1, 0)[0] = 77;
  mask.at(1, 0)[0] = 1;
  rgba.at(1, 0)[3] = 55;
  colour.at(1, 0)[2] = 9;
  EXPECT_THAT(matte_from_picture(grey)->pixels, ElementsAre(0, 77));
  EXPECT_THAT(matte_from_picture(mask)->pixels, ElementsAre(0, 255));
  EXPECT_THAT(matte_from_picture(rgba)->pixels, ElementsAre(0, 55));
  EXPECT_THAT(matte_from_picture(colour), FailsWith(ErrorCode::BadData, "colour"));
}

}  // namespace
}  // namespace floatstage::pipeline
