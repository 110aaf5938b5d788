#include <gmock/gmock.h>

#include "calib/formats/format_files.h"
#include "core/png.h"
#include "pipeline/import/contours.h"
#include "pipeline/import/import.h"
#include "tests/pipeline/import/import_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;

// Two cameras "a" and "b" with pictures, and contours of them.
class ImportOfContours : public testing::Test {
 protected:
  static constexpr int kPictures = 2;

  ImportOfContours() {
    const Rig rig = test_rig(2);
    EXPECT_THAT(calib::write_easymocap(rig, folder_ / "in"), IsOk());
    for (int i = 0; i < 2; ++i)
      save_pictures(folder_ / "in" / "images" / rig.cameras[static_cast<std::size_t>(i)].serial, i,
                    kPictures);
    options_.calibration = {"opencv", folder_ / "in"};
    options_.frame_rate = 50;
    options_.out = folder_ / "take";
    options_.contours = folder_ / "contours";
  }

  /// A square that begins where the picture's name says.
  static PictureContours square(double at) {
    return {"",
            kImportWidth,
            kImportHeight,
            {{"body", {{{at, at}, {at + 9.5, at}, {at + 9.5, at + 9}, {at, at + 9}}}}}};
  }

  void labelme(const std::string& file, double at, int width = kImportWidth) {
    fs::create_directories((folder_ / "contours" / file).parent_path());
    folder_.write("contours/" + file,
                  "{\"imageWidth\": " + std::to_string(width) +
                      ", \"imageHeight\": " + std::to_string(kImportHeight) +
                      ", \"shapes\": [{\"label\": \"body\", \"points\": " + points(at, true) + "}]}");
  }

  static std::string points(double at, bool pairs) {
    std::string out;
    const PictureContours contours = square(at);
    for (const Eigen::Vector2d& p : contours.shapes[0].polygons[0]) {
      const std::string pair = std::to_string(p.x()) + ", " + std::to_string(p.y());
      out += (out.empty() ? "" : ", ") + (pairs ? "[" + pair + "]" : pair);
    }
    return "[" + out + "]";
  }

  void all_labelme() {
    for (const char* camera : {"a", "b"})
      for (int k = 0; k < kPictures; ++k)
        labelme(std::string(camera) + "/00000" + std::to_string(k) + ".json", 3.25 + k);
  }

  /// Their names as a program that knows one folder only writes them.
  void all_coco(int pictures) {
    std::string images, annotations;
    for (int i = 0; i < 2 * pictures; ++i) {
      const std::string id = std::to_string(i), comma = i > 0 ? ", " : "";
      images += comma + "{\"id\": " + id + ", \"width\": 32, \"height\": 24, \"file_name\": \"" +
                std::string(i < pictures ? "a" : "b") + "_00000" + std::to_string(i % pictures) + ".png\"}";
      annotations += comma + "{\"image_id\": " + id + ", \"category_id\": 1, \"segmentation\": [" +
                     points(3.25 + i % pictures, false) + "]}";
    }
    folder_.write("contours.json", "{\"categories\": [{\"id\": 1, \"name\": \"body\"}], \"images\": [" +
                                       images + "], \"annotations\": [" + annotations + "]}");
    options_.contours = folder_ / "contours.json";
  }

  void expect_mattes() {
    const Result<ImportReport> report = import_take(options_);
    ASSERT_THAT(report, IsOk());
    EXPECT_TRUE(report->mattes);
    for (const char* camera : {"a", "b"})
      for (int k = 0; k < kPictures; ++k) {
        const Result<Image> read = load_png(TakeLayout(options_.out).matte(camera, k));
        ASSERT_THAT(read, IsOk());
        EXPECT_TRUE(*read == matte_of(square(3.25 + k))) << camera << " " << k;
      }
  }

  void expect_refused(ErrorCode code, const std::string& part) {
    const std::vector<std::string> before = folder_.names();
    EXPECT_THAT(import_take(options_), FailsWith(code, part));
    EXPECT_EQ(folder_.names(), before);
  }

  TempFolder folder_;
  ImportOptions options_;
};

TEST_F(ImportOfContours, MakesMattesOfLabelmesFiles) {
  all_labelme();
  expect_mattes();
}

TEST_F(ImportOfContours, FindsThemBesideThePictures) {
  all_labelme();
  for (const char* camera : {"a", "b"})
    for (int k = 0; k < kPictures; ++k) {
      const std::string file = std::string(camera) + "/00000" + std::to_string(k) + ".json";
      fs::rename(folder_ / "contours" / file, folder_ / "in" / "images" / file);
    }
  options_.contours = folder_ / "in" / "images";
  expect_mattes();
}

TEST_F(ImportOfContours, MakesMattesOfCocosFile) {
  all_coco(kPictures);
  expect_mattes();
}

TEST_F(ImportOfContours, TakesOnlyTheFramesThatAreAskedFor) {
  all_labelme();
  fs::remove(folder_ / "contours" / "a" / "000000.json");
  options_.frames.first = 1;
  ASSERT_THAT(import_take(options_), IsOk());
  EXPECT_TRUE(*load_png(TakeLayout(options_.out).matte("a", 0)) == matte_of(square(4.25)));
}

TEST_F(ImportOfContours, NamesWhatHasNoneAndWhatIsOfNoPicture) {
  all_labelme();
  fs::remove_all(folder_ / "contours" / "b");
  labelme("stranger/000000.json", 3);
  const Result<ImportReport> report = import_take(options_);
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->notes, Contains(HasSubstr("camera 'b' has no matte")));
  EXPECT_THAT(report->notes, Contains(HasSubstr("stranger/000000")));
  EXPECT_FALSE(fs::exists(TakeLayout(options_.out).matte("b", 0)));
}

TEST_F(ImportOfContours, SaysWhereTheSubjectIsNot) {
  all_labelme();
  folder_.write("contours/a/000001.json", R"({"imageWidth": 32, "imageHeight": 24, "shapes": []})");
  const Result<ImportReport> report = import_take(options_);
  ASSERT_THAT(report, IsOk());
  EXPECT_THAT(report->notes, Contains(HasSubstr("not in 1 of 4 pictures, by their contours: a/000001")));
}

TEST_F(ImportOfContours, RefusesWhatDoesNotFitItsPictures) {
  expect_refused(ErrorCode::NotFound, "contours");
  labelme("elsewhere/000000.json", 3);
  expect_refused(ErrorCode::NotFound, "no contours of any picture");
  all_labelme();
  labelme("b/000001.json", 4.25, 40);
  expect_refused(ErrorCode::BadData,
                 "the contours of picture 1 are of 40x24 pixels, but the pictures of camera 'b'");
  fs::remove(folder_ / "contours" / "b" / "000001.json");
  expect_refused(ErrorCode::NotFound, "camera 'b' has contours, but none of its picture 1");
  folder_.write("contours/b/000001.json", "{\"imageWidth\": 32, ");
  expect_refused(ErrorCode::BadData, "b/000001.json: not JSON");
  options_.contour_options.labels = {"nobody"};
  all_labelme();
  expect_refused(ErrorCode::NotFound, "are empty; see --contour-labels");
  options_.mattes = folder_ / "in";
  expect_refused(ErrorCode::InvalidArgument, "--mattes and --contours");
}

}  // namespace
}  // namespace floatstage::pipeline
