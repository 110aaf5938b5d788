#include <cmath>
#include <cstdlib>
#include <map>
#include <sstream>

#include <gmock/gmock.h>

#include "core/file.h"
#include "core/matte.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/import/import.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

TEST(ImportReal, TempleRingTakesTheNineteenViewsThatHaveAnImage) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-ring"));
  TempFolder folder;
  ImportOptions options;
  options.calibration = {"middlebury", real_data("middlebury-temple-ring")};
  options.out = folder / "T";
  const Result<ImportReport> report = import_take(options);
  ASSERT_THAT(report, IsOk());
  ASSERT_EQ(report->serials.size(), 19u);
  EXPECT_EQ(report->serials.front(), "templeR0013");
  EXPECT_EQ(report->frames, 1);
  EXPECT_THAT(report->notes, testing::ElementsAre(testing::HasSubstr("28 of 47")));
  const auto take = capture::TakeReader::open(options.out);
  ASSERT_THAT(take, IsOk());
  const int camera = camera_index((*take)->rig(), "templeR0014.png");
  ASSERT_GE(camera, 0);
  const Result<Image> original = load_png(real_data("middlebury-temple-ring/templeR0014.png"));
  const Result<Frame> frame = (*take)->frame(camera, 0);
  ASSERT_TRUE(original && frame);
  EXPECT_TRUE(*to_rgb(*frame) == *original);
}

// Where COLMAP saw its points, by picture: x and y of each.
std::map<int, std::pair<std::string, std::vector<Eigen::Vector2d>>> sights_in(const std::string& images_txt) {
  std::map<int, std::pair<std::string, std::vector<Eigen::Vector2d>>> pictures;
  std::istringstream in(images_txt);
  std::string line;
  while (std::getline(in, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream head(line);
    int id = 0, camera = 0;
    double pose[7];
    std::string name;
    head >> id;
    for (double& number : pose) head >> number;
    head >> camera >> name;
    std::getline(in, line);
    std::istringstream points(line);
    std::vector<Eigen::Vector2d> sights;
    for (double x = 0, y = 0, point = 0; points >> x >> y >> point;) sights.emplace_back(x, y);
    pictures[id] = {name, sights};
  }
  return pictures;
}

// Debian's COLMAP reconstructs a part of the ring; imported, its points are as far from where it saw them as
// COLMAP itself says (the ERROR of points3D.txt).
TEST(ImportReal, ColmapsOwnReconstructionReprojectsAsColmapSays) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-ring"));
  TempFolder folder;
  namespace fs = std::filesystem;
  const fs::path project = folder / "project", text_model = folder / "text";
  for (const fs::path& made : {project / "images", project / "sparse", text_model})
    fs::create_directories(made);
  for (int i = 13; i < 21; ++i) {
    const std::string name = text("templeR00", i, ".png");
    fs::copy_file(real_data("middlebury-temple-ring") / name, project / "images" / name);
  }
  const std::string colmap = "QT_QPA_PLATFORM=offscreen colmap ",
                    database = text(" --database_path '", (folder / "db").string(), "'"),
                    pictures = text(" --image_path '", (project / "images").string(), "'");
  for (const std::string& step :
       {"feature_extractor" + database + pictures +
            " --SiftExtraction.use_gpu 0 --ImageReader.single_camera 1 --SiftExtraction.max_num_features "
            "1500",
        "exhaustive_matcher" + database + " --SiftMatching.use_gpu 0",
        "mapper" + database + pictures + text(" --output_path '", (project / "sparse").string(), "'"),
        text("model_converter --input_path '", (project / "sparse/0").string(), "' --output_path '",
             text_model.string(), "' --output_type TXT")}) {
    const Ended ended = run_command(colmap + step);
    ASSERT_EQ(ended.code, 0) << step << "\n" << ended.output;
  }
  ImportOptions options;
  options.calibration = {"colmap", project};
  options.out = folder / "T";
  ASSERT_THAT(import_take(options), IsOk());
  const auto take = capture::TakeReader::open(options.out);
  ASSERT_THAT(take, IsOk());

  const auto sights = sights_in(*read_file(text_model / "images.txt"));
  std::istringstream points(*read_file(text_model / "points3D.txt"));
  std::string line;
  double worst = 0;
  int seen = 0;
  while (std::getline(points, line)) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    double id = 0, error = 0, color = 0;
    Eigen::Vector3d point;
    words >> id >> point.x() >> point.y() >> point.z() >> color >> color >> color >> error;
    double sum = 0, count = 0;
    for (int image = 0, index = 0; words >> image >> index; ++count) {
      const auto& [name, at] = sights.at(image);
      const RigCamera& c =
          (*take)->rig().cameras[static_cast<std::size_t>(camera_index((*take)->rig(), name))];
      const auto pixel = floatstage::project(c.model, c.cam_from_world * point);
      ASSERT_TRUE(pixel.has_value());
      sum += (*pixel - at[static_cast<std::size_t>(index)]).norm();
    }
    worst = std::max(worst, std::abs(sum / count - error));
    ++seen;
  }
  std::printf("%d points of %zu pictures, at most %.2e px from COLMAP's own residuals\n", seen, sights.size(),
              worst);
  EXPECT_GT(seen, 100);
  EXPECT_EQ(sights.size(), 8u);
  EXPECT_LT(worst, 1e-3);
}

TEST(ImportReal, DomeComesWithItsMattes) {
  FLOATSTAGE_NEEDS_DATA(real_data("green-dome"));
  TempFolder folder;
  ImportOptions options;
  options.calibration = {"dome", real_data("green-dome")};
  options.mattes = real_data("green-dome/mattes");
  options.out = folder / "G";
  const Result<ImportReport> report = import_take(options);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->serials.size(), 20u);
  EXPECT_THAT(report->notes, testing::IsEmpty());
  const auto take = capture::TakeReader::open(options.out);
  ASSERT_THAT(take, IsOk());
  EXPECT_EQ((*take)->rig().cameras[3].serial, "03");
  for (const RigCamera& c : (*take)->rig().cameras) {
    const Result<Image> matte = load_png((*take)->layout().matte(c.serial, 0));
    ASSERT_THAT(matte, IsOk());
    EXPECT_EQ(matte->width, 1024);
    const double covered = coverage(make_matte({}, *matte));
    EXPECT_GT(covered, 0.02) << c.serial;
    EXPECT_LT(covered, 0.4) << c.serial;
  }
}

// The videos of cam01 and cam02 were scaled to another size than their calibration's, so they must be
// refused.
TEST(ImportReal, QualisysVideosOfAnotherSizeAreRefusedAndTheOthersTaken) {
  FLOATSTAGE_NEEDS_DATA(real_data("pose2sim-balancing"));
  TempFolder folder;
  ImportOptions options;
  options.calibration = {"qualisys", real_data("pose2sim-balancing/calibration/Calib.qca.txt")};
  options.pictures = real_data("pose2sim-balancing/videos");
  options.frames = {.first = 4, .end = 6};
  options.out = folder / "Q";
  EXPECT_THAT(import_take(options),
              FailsWith(ErrorCode::BadData, "camera 'cam01': its pictures are 1080x1920"));
  EXPECT_THAT(folder.names(), testing::IsEmpty());
  options.cameras = {"cam03", "cam04"};
  const Result<ImportReport> report = import_take(options);
  ASSERT_THAT(report, IsOk());
  EXPECT_EQ(report->frames, 2);
  const auto take = capture::TakeReader::open(options.out);
  ASSERT_THAT(take, IsOk());
  EXPECT_NEAR((*take)->manifest().frame_rate, 60, 1e-6);
}

}  // namespace
}  // namespace floatstage::pipeline
