#include <algorithm>
#include <map>

#include <gtest/gtest.h>

#include "calib/detect.h"
#include "capture/media_file.h"
#include "tests/calib/detections.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"

namespace floatstage::calib {
namespace {

// All pictures of a video, in order.
std::vector<Image> pictures(const std::filesystem::path& file) {
  std::vector<Image> all;
  Result<std::unique_ptr<capture::MediaReader>> reader = capture::MediaReader::open(file);
  EXPECT_THAT(reader, IsOk());
  if (!reader) return all;
  for (Result<Image> image = (*reader)->next(); image; image = (*reader)->next())
    all.push_back(*std::move(image));
  return all;
}

std::vector<Detection> detect_images(const TargetDesign& design, const std::vector<Image>& images) {
  std::vector<PictureToDetect> wanted;
  for (std::size_t i = 0; i < images.size(); ++i)
    wanted.push_back({text(i), "", [&images, i]() -> Result<Image> { return images[i]; }});
  return detect_all(design, wanted);
}

TEST(CaliscopeSet, ShowsTheInvertedBoardInAtLeastAsManyPicturesAsOpenCvFinds) {
  const auto folder = real_data("caliscope-4cam") / "charuco_calibration/calibration/extrinsic";
  FLOATSTAGE_NEEDS_DATA(folder);
  const TargetDesign design =
      target("charuco columns=4 rows=5 square=54mm marker=40.5mm dictionary=4x4_1000 inverted");
  constexpr int kBaseline[] = {46, 29, 43, 45};
  for (int camera = 0; camera < 4; ++camera) {
    const std::vector<Image> images = pictures(folder / text("cam_", camera, ".mp4"));
    ASSERT_EQ(images.size(), 111u);
    const std::vector<Detection> found = detect_images(design, images);
    std::size_t with = 0, points = 0;
    for (const Detection& d : found) with += !d.points.empty(), points += d.points.size();
    std::printf("cam_%d: %s; %zu corners\n", camera, summary(found).c_str(), points);
    EXPECT_GE(with, static_cast<std::size_t>(kBaseline[camera])) << camera;
    EXPECT_GE(points, 10 * with) << "most of the twelve corners";
  }
}

TEST(CaliscopeSet, ToldTheWrongWayIsDiagnosed) {
  const auto folder = real_data("caliscope-4cam") / "charuco_calibration/calibration/extrinsic";
  FLOATSTAGE_NEEDS_DATA(folder);
  const std::vector<Image> images = pictures(folder / "cam_2.mp4");
  for (const auto& [line, advice] :
       {std::pair{"charuco columns=4 rows=5 square=54mm marker=40.5mm dictionary=4x4_1000",
                  "add the word 'inverted'"},
        std::pair{"charuco columns=5 rows=4 square=54mm marker=40.5mm dictionary=4x4_1000 inverted",
                  "other way round"},
        std::pair{"charuco columns=4 rows=5 square=54mm marker=40.5mm dictionary=5x5_50 inverted",
                  "dictionary=4x4"}})
    EXPECT_THAT(summary(detect_images(target(line), images)), testing::HasSubstr(advice)) << line;
}

TEST(Pose2SimSet, ShowsItsChessboardWholeOrSaysThatItIsCutOff) {
  const auto folder = real_data("pose2sim-balancing") / "calibration/intrinsics";
  FLOATSTAGE_NEEDS_DATA(folder);
  const TargetDesign design = target("chessboard columns=8 rows=5 square=60mm");
  std::size_t with = 0;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().extension() == ".jpg") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  for (const auto& file : files) {
    const std::vector<Image> images = pictures(file);
    ASSERT_EQ(images.size(), 1u);
    const Detection found = detect(design, images[0]);
    with += found.points.size() == 28;
    std::printf("%s: %zu %s\n", file.filename().c_str(), found.points.size(), found.reason.c_str());
  }
  EXPECT_GE(with, 26u) << "of " << files.size();
}

}  // namespace
}  // namespace floatstage::calib
