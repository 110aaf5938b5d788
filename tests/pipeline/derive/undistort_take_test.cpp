#include "pipeline/derive/undistort_take.h"

#include <cmath>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "capture/added_file.h"
#include "capture/take.h"
#include "capture/take_check.h"
#include "capture/time_offsets.h"
#include "core/file.h"
#include "core/png.h"
#include "core/synthetic/synthetic_studio.h"
#include "pipeline/occluders.h"
#include "pipeline/undistort.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::HasSubstr;

// Lenses of every kind that rigs hold, wide and narrow, and one camera without any.
struct Kind {
  const char* serial;
  Lens lens;
  double skew;
};
const std::vector<Kind> kKinds = {{"barrel", BrownConrady{-0.2, 0.05, 0.002, -0.001, 0}, 0},
                                  {"cushion", BrownConrady{0.15, 0, 0, 0, 0}, 0},
                                  {"rational", BrownConrady{0.3, 0.02, 1e-3, 5e-4, 0.01, 0.5, 0.05, 0.01}, 0},
                                  {"fisheye", KannalaBrandt{0.05, -0.01, 0.003, 0}, 0},
                                  {"skewed", {}, 3.5},
                                  {"plain", {}, 0}};

Rig rig_of_kinds() {
  Rig rig = synthetic_rig(
      {.shape = RigShape::Ring, .cameras = static_cast<int>(kKinds.size()), .width = 240, .height = 180});
  for (std::size_t c = 0; c < kKinds.size(); ++c) {
    rig.cameras[c].serial = kKinds[c].serial;
    rig.cameras[c].model.lens = kKinds[c].lens;
    rig.cameras[c].model.skew = kKinds[c].skew;
  }
  return rig;
}

class AStraightTake : public testing::Test {
 protected:
  static constexpr int kFrames = 2, kLost = 1;  // the plain camera lacks that one

  static void SetUpTestSuite() {
    folder_ = new TempFolder();
    const Rig rig = rig_of_kinds();
    const auto studio = SyntheticStudio::create(rig, {.samples = 4});
    ASSERT_THAT(studio, IsOk());
    auto writer = capture::TakeWriter::create(bent(), rig, {});
    ASSERT_THAT(writer, IsOk());
    for (int c = 0; c < static_cast<int>(rig.cameras.size()); ++c) {
      for (int f = 0; f < kFrames; ++f) {
        SyntheticShot shot = studio->shoot(c, f);
        const TakeLayout take(bent());
        ASSERT_THAT(make_folder(take.matte(rig.cameras[c].serial, f).parent_path()), IsOk());
        ASSERT_THAT(save_png(to_image(shot.matte), take.matte(rig.cameras[c].serial, f)), IsOk());
        if (c + 1 == static_cast<int>(rig.cameras.size()) && f == kLost) {
          shot.frame.pixels.reset();
          shot.frame.info.status = FrameStatus::Lost;
        }
        ASSERT_THAT((*writer)->write(shot.frame), IsOk());
      }
      ASSERT_THAT(make_folder(TakeLayout(bent()).plate("x").parent_path()), IsOk());
      ASSERT_THAT(save_png(studio->plate(c), TakeLayout(bent()).plate(rig.cameras[c].serial)), IsOk());
      // The same picture as the first matte, so that it can be compared with that.
      const fs::path mask = occluder_file(TakeLayout(bent()), rig.cameras[c].serial);
      ASSERT_THAT(make_folder(mask.parent_path()), IsOk());
      fs::copy_file(TakeLayout(bent()).matte(rig.cameras[c].serial, 0), mask);
    }
    ASSERT_THAT((*writer)->finish(), IsOk());
    ASSERT_THAT(capture::save_time_offsets({"silhouettes", {{"barrel", Nanoseconds{5}, Nanoseconds{1}, ""}}},
                                           capture::times_file(TakeLayout(bent()))),
                IsOk());
    const auto made = undistort_take({.take = bent(), .out = straight_take(), .label = ""});
    ASSERT_THAT(made, IsOk());
    report_ = *made;
  }
  static void TearDownTestSuite() { delete folder_; }

  static fs::path bent() { return *folder_ / "bent"; }
  static fs::path straight_take() { return *folder_ / "straight"; }
  static std::unique_ptr<capture::TakeReader> open(const fs::path& folder) {
    auto take = capture::TakeReader::open(folder);
    EXPECT_THAT(take, IsOk());
    return std::move(*take);
  }

  static TempFolder* folder_;
  static UndistortReport report_;
};
TempFolder* AStraightTake::folder_ = nullptr;
UndistortReport AStraightTake::report_;

double psnr(const Image& a, const Image& b, const PixelBox& box) {
  double sum = 0, n = 0;
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x)
      for (int c = 0; c < a.channels; ++c, ++n) sum += std::pow(a.at(x, y)[c] - b.at(x, y)[c], 2);
  return 10 * std::log10(255.0 * 255.0 * n / sum);
}

TEST_F(AStraightTake, HasThePicturesAndMattesThatCamerasWithoutLensesTake) {
  const auto take = open(straight_take());
  const auto studio = SyntheticStudio::create(take->rig(), {.samples = 4});
  ASSERT_THAT(studio, IsOk());
  const capture::AddedFile added = *capture::load_added(take->layout());
  for (std::size_t c = 0; c < kKinds.size(); ++c) {
    const CameraModel& m = take->rig().cameras[c].model;
    EXPECT_EQ(m, straight(rig_of_kinds().cameras[c].model));
    const SyntheticShot shot = studio->shoot(static_cast<int>(c), 0);
    const PixelBox box = inside(added.of(kKinds[c].serial), m.width, m.height);
    const double pictures = psnr(*to_rgb(*take->frame(static_cast<int>(c), 0)), *to_rgb(shot.frame), box);
    const double mattes =
        psnr(*load_png(take->layout().matte(kKinds[c].serial, 0)), to_image(shot.matte), box);
    const double plates =
        psnr(*load_png(take->layout().plate(kKinds[c].serial)), studio->plate(static_cast<int>(c)), box);
    std::printf("%-10s pictures %.1f dB, mattes %.1f, plates %.1f; kept %.3f, hidden %.3f\n",
                kKinds[c].serial, pictures, mattes, plates, report_.cameras[c].kept,
                report_.cameras[c].hidden);
    EXPECT_GT(pictures, 30) << kKinds[c].serial;
    EXPECT_GT(mattes, 24) << kKinds[c].serial;
    EXPECT_GT(plates, 30) << kKinds[c].serial;
    EXPECT_EQ(*load_png(occluder_file(take->layout(), kKinds[c].serial)),
              *load_png(take->layout().matte(kKinds[c].serial, 0)));
  }
}

// What OpenCV's own models say, half a pixel apart as its origin is the first pixel's centre.
cv::Point2d by_opencv(const CameraModel& m, const Eigen::Vector3d& ray) {
  const std::vector<cv::Point3d> point{{ray.x(), ray.y(), ray.z()}};
  const cv::Matx33d k(m.fx, m.skew, m.cx - 0.5, 0, m.fy, m.cy - 0.5, 0, 0, 1);
  const cv::Vec3d none(0, 0, 0);
  std::vector<cv::Point2d> at;
  if (const auto* f = std::get_if<KannalaBrandt>(&m.lens)) {
    cv::fisheye::projectPoints(point, at, none, none, k, cv::Vec4d(f->k1, f->k2, f->k3, f->k4));
  } else {
    const auto* b = std::get_if<BrownConrady>(&m.lens);
    const BrownConrady d = b ? *b : BrownConrady{};
    const std::vector<double> coefficients{d.k1, d.k2, d.p1, d.p2, d.k3, d.k4, d.k5, d.k6};
    const cv::Matx33d unit = cv::Matx33d::eye();  // projectPoints ignores a skew
    cv::projectPoints(point, none, none, unit, coefficients, at);
    const cv::Vec3d p = k * cv::Vec3d(at[0].x, at[0].y, 1);
    at[0] = {p[0], p[1]};
  }
  return {at[0].x + 0.5, at[0].y + 0.5};
}

TEST_F(AStraightTake, TakesEveryPixelFromWhereOpenCVSeesItsRay) {
  double worst = 0;
  int compared = 0;
  for (const RigCamera& c : rig_of_kinds().cameras) {
    const CameraModel to = straight(c.model);
    const Retaking straighten(c.model, to);
    for (int y = 0; y < to.height; y += 3)
      for (int x = 0; x < to.width; x += 3)
        if (const auto from = straighten.source(x, y)) {
          const cv::Point2d theirs =
              by_opencv(c.model, {(x + 0.5 - to.cx) / to.fx, (y + 0.5 - to.cy) / to.fy, 1});
          worst = std::max({worst, std::abs(theirs.x - from->x()), std::abs(theirs.y - from->y())});
          ++compared;
        }
  }
  EXPECT_GT(compared, 20'000);
  EXPECT_LT(worst, 1e-3) << "px";
}

TEST_F(AStraightTake, HidesBehindBarsWhatNothingWasPhotographedOf) {
  const auto take = open(straight_take());
  const capture::AddedFile added = *capture::load_added(take->layout());
  EXPECT_TRUE(added.of("cushion").bars());
  EXPECT_FALSE(added.of("plain").bars());
  for (std::size_t c = 0; c < kKinds.size(); ++c) {
    const CameraModel from = rig_of_kinds().cameras[c].model, to = straight(from);
    const Retaking straighten(from, to);
    const PixelBox box = inside(added.of(kKinds[c].serial), to.width, to.height);
    for (int y = box.y; y < box.y + box.height; ++y)
      for (int x = box.x; x < box.x + box.width; ++x)
        ASSERT_TRUE(straighten.source(x, y)) << kKinds[c].serial << " " << x << ", " << y;
  }
}

TEST_F(AStraightTake, KeepsInstantsGapsAndPicturesOfCamerasThatWereStraight) {
  const auto before = open(bent()), after = open(straight_take());
  ASSERT_EQ(after->frame_count(), kFrames);
  for (int c = 0; c < static_cast<int>(kKinds.size()); ++c)
    for (int f = 0; f < kFrames; ++f)
      EXPECT_EQ(after->rows(c)[f].info.exposure_start, before->rows(c)[f].info.exposure_start);
  const int plain = static_cast<int>(kKinds.size()) - 1;
  EXPECT_TRUE(after->frame(plain, kLost)->empty());
  EXPECT_EQ(to_rgb(*after->frame(plain, 0))->pixels, to_rgb(*before->frame(plain, 0))->pixels);
  EXPECT_TRUE(report_.cameras[plain].was_straight);
  EXPECT_EQ(capture::load_time_offsets(after->layout())->cameras.size(), 1u);
  EXPECT_THAT(report_.notes, Contains(HasSubstr("mattes came along")));
  const auto check = capture::check_take(straight_take(), [](std::uint64_t) { return true; });
  ASSERT_THAT(check, IsOk());
  EXPECT_TRUE(check->sealed && check->problems.empty());
}

TEST_F(AStraightTake, IsRefusedOfOneThatIsStraightAndNeverReplacesAnything) {
  EXPECT_THAT(undistort_take({.take = straight_take(), .out = *folder_ / "again", .label = ""}),
              FailsWith(ErrorCode::InvalidArgument, "straight already"));
  EXPECT_FALSE(fs::exists(*folder_ / "again"));
  EXPECT_THAT(undistort_take({.take = bent(), .out = straight_take(), .label = ""}),
              FailsWith(ErrorCode::AlreadyExists, "straight"));
  EXPECT_THAT(undistort_take({.take = *folder_ / "none", .out = *folder_ / "again", .label = ""}),
              FailsWith(ErrorCode::NotFound, "none"));
}

TEST_F(AStraightTake, IsNotMadeOfMattesOfAnotherSize) {
  TempFolder own;
  fs::copy(bent(), own / "take", fs::copy_options::recursive);
  ASSERT_THAT(save_png(Image(10, 10, 1), TakeLayout(own / "take").matte("barrel", 0)), IsOk());
  EXPECT_THAT(undistort_take({.take = own / "take", .out = own / "new", .label = ""}),
              FailsWith(ErrorCode::BadData, "10x10"));
  EXPECT_FALSE(fs::exists(own / "new"));
}

TEST(LargestBox, IsThatOfAllRectangles) {
  std::mt19937 random(7);
  for (int round = 0; round < 50; ++round) {
    Image mask(7, 6, 1);
    for (std::uint8_t& p : mask.pixels) p = random() % 4 != 0;
    int most = 0;
    for (int y = 0; y < 6; ++y)
      for (int x = 0; x < 7; ++x)
        for (int h = 1; y + h <= 6; ++h)
          for (int w = 1; x + w <= 7; ++w) {
            bool whole = true;
            for (int j = 0; j < h; ++j)
              for (int i = 0; i < w; ++i) whole = whole && *mask.at(x + i, y + j);
            if (whole) most = std::max(most, w * h);
          }
    const PixelBox box = largest_box(mask);
    EXPECT_EQ(box.width * box.height, most);
    for (int j = 0; j < box.height; ++j)
      for (int i = 0; i < box.width; ++i) EXPECT_TRUE(*mask.at(box.x + i, box.y + j));
  }
  EXPECT_TRUE(largest_box(Image(4, 4, 1)).empty());
}

}  // namespace
}  // namespace floatstage::pipeline
