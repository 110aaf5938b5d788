// What others' programs make of an exported rig, against our own projection.

#include "calib/formats/refit.h"

#include <algorithm>
#include <iomanip>
#include <regex>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "calib/child_program.h"
#include "calib/formats/format_files.h"
#include "core/file.h"
#include "core/text.h"
#include "tests/calib/format_support.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

using testing::HasSubstr;

constexpr double kSame = 1e-3;  // px

const RigFormat& format(std::string_view name) {
  for (const RigFormat& f : rig_formats())
    if (f.name == name) return f;
  throw std::runtime_error("no such format");
}

// Rigs as a calibration leaves them: every lens that a session can ask for.
std::vector<std::pair<std::string, Rig>> default_rigs() {
  std::vector<std::pair<std::string, Rig>> out;
  Rig two = ring_rig(4);
  for (RigCamera& c : two.cameras) std::get<BrownConrady>(c.model.lens).k3 = 0;
  out.emplace_back("two radial terms", two);
  out.emplace_back("three radial terms", ring_rig(4));
  Rig fisheye = mixed_rig();
  out.emplace_back("fisheyes and a long lens", fisheye);
  out.emplace_back("no lens", sample_rig(std::monostate{}));
  return out;
}

// Points before every camera, all over its picture.
std::vector<Eigen::Vector3d> points_before(const RigCamera& c) {
  std::vector<Eigen::Vector3d> out;
  for (int y = 0; y < 7; ++y)
    for (int x = 0; x < 9; ++x)
      if (const auto ray =
              unproject(c.model, {(x + 0.5) / 9 * c.model.width, (y + 0.5) / 7 * c.model.height}))
        out.push_back(c.cam_from_world.inverse() * Eigen::Vector3d(*ray * (1.5 + 0.2 * (x % 3))));
  return out;
}

TEST(ExportedRig, IsTheSameInEveryFormatThatHoldsItOrIsRefusedWithTheRemedy) {
  const TempFolder folder;
  int written = 0;
  for (const auto& [what, rig] : default_rigs())
    for (const char* name : {"colmap", "opencv", "kalibr", "qualisys"}) {
      SCOPED_TRACE(what + " as " + name);
      const RigFormat& f = format(name);
      const Result<FittedRig> fitted = fit_to_format(rig, f.holds, f.name, kSame);
      if (!fitted) {
        EXPECT_THAT(fitted, FailsWith(ErrorCode::Unsupported, "camera '"));
        EXPECT_TRUE(std::regex_search(fitted.error().message, std::regex("calibrate with|write ")))
            << fitted.error().message;
        std::printf("%s as %s: %s\n", what.c_str(), name, fitted.error().message.c_str());
        continue;
      }
      ++written;
      const std::string file = text("out", written, f.name == "kalibr" ? "_camchain.yaml" : ".qca.txt");
      const bool folder_format = f.name == "colmap" || f.name == "opencv";
      const std::filesystem::path out = folder / (folder_format ? text("out", written) : file);
      std::vector<std::string> pictures;
      for (const RigCamera& c : rig.cameras) pictures.push_back(c.serial + ".png");
      ASSERT_THAT(f.write(fitted->rig, pictures, out), IsOk());
      const Result<ForeignRig> back = f.read(out, kMetresPerUnit);
      ASSERT_THAT(back, IsOk());
      // A camchain has no world: its first camera is it.
      const Rigid3 first = f.name == "kalibr" ? fitted->rig.cameras[0].cam_from_world : Rigid3{};
      double most = 0;
      for (std::size_t c = 0; c < rig.cameras.size(); ++c)
        for (const Eigen::Vector3d& x : points_before(rig.cameras[c])) {
          const auto ours = project(rig.cameras[c].model, rig.cameras[c].cam_from_world * x);
          const RigCamera& read = back->rig.cameras[c];
          const auto theirs = project(read.model, read.cam_from_world * (first * x));
          ASSERT_TRUE(ours && theirs);
          most = std::max(most, (*ours - *theirs).norm());
        }
      EXPECT_LE(most, kSame);
    }
  EXPECT_GE(written, 12) << "of sixteen";
}

TEST(ExportedRig, OfADefaultSessionGoesToKalibr) {
  Rig rig = ring_rig(4);
  for (RigCamera& c : rig.cameras) std::get<BrownConrady>(c.model.lens).k3 = 0;  // as sessions leave it out
  const Result<FittedRig> fitted = fit_to_format(rig, format("kalibr").holds, "kalibr", kSame);
  ASSERT_THAT(fitted, IsOk());
  for (const Measured& r : fitted->residual_px) EXPECT_FALSE(r) << "held bit by bit";
}

// Its denominator would be left out without a word.
TEST(ExportedRig, WithARationalLensIsRefusedByEveryFormat) {
  Rig rig = ring_rig(4);
  std::get<BrownConrady>(rig.cameras[2].model.lens).k4 = 0.01;
  for (const RigFormat& f : rig_formats())
    EXPECT_THAT(fit_to_format(rig, f.holds, f.name, 100), FailsWith(ErrorCode::Unsupported, "rational lens"))
        << f.name;
}

TEST(ExportedRig, WithAThirdTermGoesToKalibrWithAStatedResidual) {
  const Rig rig = ring_rig(4);
  const Result<FittedRig> fitted = fit_to_format(rig, format("kalibr").holds, "kalibr", 0.1);
  ASSERT_THAT(fitted, IsOk());
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    ASSERT_TRUE(fitted->residual_px[c]);
    std::printf("camera %zu: %.5f px\n", c, *fitted->residual_px[c]);
    double most = 0;
    for (const Eigen::Vector3d& x : points_before(rig.cameras[c]))
      most =
          std::max(most, (*project(rig.cameras[c].model, rig.cameras[c].cam_from_world * x) -
                          *project(fitted->rig.cameras[c].model, fitted->rig.cameras[c].cam_from_world * x))
                             .norm());
    EXPECT_LE(most, *fitted->residual_px[c]) << "the residual is the most that it is off";
  }
}

TEST(ExportedRig, WithASkewIsRefusedByWhatIgnoresItAndHeldByQualisys) {
  Rig rig = ring_rig(3);
  for (RigCamera& c : rig.cameras) std::get<BrownConrady>(c.model.lens).k3 = 0;
  rig.cameras[1].model.skew = 0.8;
  for (const char* name : {"opencv", "colmap", "kalibr"}) {
    const Result<FittedRig> fitted = fit_to_format(rig, format(name).holds, name, kSame);
    EXPECT_THAT(fitted, FailsWith(ErrorCode::Unsupported, "camera 'cam1' has a skew")) << name;
    EXPECT_THAT(fitted, FailsWith(ErrorCode::Unsupported, "write qualisys or middlebury"));
  }
  EXPECT_THAT(fit_to_format(rig, format("qualisys").holds, "qualisys", kSame), IsOk());
  const Result<FittedRig> near = fit_to_format(rig, format("opencv").holds, "opencv", 0.5);
  ASSERT_THAT(near, IsOk());
  EXPECT_EQ(near->rig.cameras[1].model.skew, 0);
  ASSERT_TRUE(near->residual_px[1]);
  std::printf("a skew of 0.8 px: %.4f px remain\n", *near->residual_px[1]);
  EXPECT_LT(*near->residual_px[1], 0.4) << "dropping it would leave 0.25 px and more at the border";
  const TempFolder folder;
  EXPECT_THAT(write_easymocap(rig, folder / "out"), FailsWith(ErrorCode::Unsupported, "skew"));
}

TEST(ExportedRig, IsSeenByOpenCvWhereWeSeeIt) {
  for (const auto& [what, rig] : default_rigs())
    for (const RigCamera& c : rig.cameras) {
      const auto* brown = std::get_if<BrownConrady>(&c.model.lens);
      const auto* fisheye = std::get_if<KannalaBrandt>(&c.model.lens);
      const cv::Matx33d k(c.model.fx, 0, c.model.cx - 0.5, 0, c.model.fy, c.model.cy - 0.5, 0, 0, 1);
      const Eigen::AngleAxisd turn(c.cam_from_world.rotation);
      const Eigen::Vector3d r = turn.angle() * turn.axis(), t = c.cam_from_world.translation;
      const cv::Vec3d rv(r.x(), r.y(), r.z()), tv(t.x(), t.y(), t.z());
      std::vector<cv::Point3d> points;
      const std::vector<Eigen::Vector3d> before = points_before(c);
      for (const Eigen::Vector3d& x : before) points.emplace_back(x.x(), x.y(), x.z());
      std::vector<cv::Point2d> pixels;
      if (fisheye)
        cv::fisheye::projectPoints(points, pixels, rv, tv, k,
                                   cv::Vec4d(fisheye->k1, fisheye->k2, fisheye->k3, fisheye->k4));
      else
        cv::projectPoints(
            points, rv, tv, k,
            brown ? cv::Mat(cv::Matx<double, 1, 5>(brown->k1, brown->k2, brown->p1, brown->p2, brown->k3))
                  : cv::Mat(),
            pixels);
      for (std::size_t i = 0; i < before.size(); ++i) {
        const Eigen::Vector2d ours = *project(c.model, c.cam_from_world * before[i]);
        EXPECT_LE((ours - Eigen::Vector2d(pixels[i].x + 0.5, pixels[i].y + 0.5)).norm(), kSame) << what;
      }
    }
}

// A model whose points are where our projection sees them: COLMAP's own adjustment then begins with no error.
std::string points_model(const Rig& rig, const std::filesystem::path& folder) {
  const Result<std::string> images = read_file(folder / "images.txt");
  EXPECT_THAT(images, IsOk());
  std::vector<std::string> sights(rig.cameras.size());
  std::vector<int> counts(rig.cameras.size());
  std::string points;
  int id = 0;
  for (const Eigen::Vector3d& x : points_before(rig.cameras[0])) {
    const auto seen_by = std::count_if(rig.cameras.begin(), rig.cameras.end(), [&](const RigCamera& c) {
      const auto pixel = project(c.model, c.cam_from_world * x);
      return pixel && inside(c.model, *pixel);
    });
    if (seen_by < 2) continue;  // COLMAP knows no others
    std::string track;
    ++id;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
      const auto pixel = project(rig.cameras[c].model, rig.cameras[c].cam_from_world * x);
      if (!pixel || !inside(rig.cameras[c].model, *pixel)) continue;
      sights[c] +=
          text(sights[c].empty() ? "" : " ", std::setprecision(17), pixel->x(), ' ', pixel->y(), ' ', id);
      track += text(' ', c + 1, ' ', counts[c]++);
    }
    points += text(id, std::setprecision(17), ' ', x.x(), ' ', x.y(), ' ', x.z(), " 0 0 0 0", track, '\n');
  }
  std::string out, line;
  std::size_t camera = 0;
  std::istringstream in(*images);
  while (std::getline(in, line)) {
    if (line.empty() || line[0] == '#') continue;
    out += line + '\n' + sights[camera++] + '\n';
  }
  // Where there are both, COLMAP reads the binary files.
  for (const char* file : {"cameras.bin", "images.bin", "points3D.bin"})
    std::filesystem::remove(folder / file);
  EXPECT_THAT(write_file(folder / "images.txt", out), IsOk());
  EXPECT_THAT(write_file(folder / "points3D.txt", points), IsOk());
  return (folder / "log.txt").string();
}

TEST(ExportedRig, IsSeenByColmapWhereWeSeeIt) {
  int asked = 0;
  for (const auto& [what, rig] : default_rigs()) {
    const TempFolder folder;
    const std::filesystem::path model = folder / "model", out = folder / "out";
    std::vector<std::string> pictures;
    for (const RigCamera& c : rig.cameras) pictures.push_back(c.serial + ".png");
    ASSERT_THAT(write_colmap(rig, pictures, model), IsOk());
    ASSERT_THAT(make_folder(out), IsOk());
    const std::string log = points_model(rig, model);
    const Result<ProgramEnd> end = run_program(
        {"colmap", "bundle_adjuster", "--input_path", model.string(), "--output_path", out.string(),
         "--BundleAdjustment.max_num_iterations", "1", "--BundleAdjustment.refine_focal_length", "0",
         "--BundleAdjustment.refine_extra_params", "0", "--BundleAdjustment.refine_extrinsics", "0"},
        log, 60, nullptr);
    if (!end) GTEST_SKIP() << "colmap is not installed";
    const std::string said = read_file(log).value();
    std::smatch found;
    ASSERT_TRUE(std::regex_search(said, found, std::regex("Initial cost : ([0-9.e+-]+) \\[px\\]"))) << said;
    EXPECT_LE(std::stod(found[1]), kSame) << what;
    ++asked;
  }
  EXPECT_EQ(asked, 4);
}

}  // namespace
}  // namespace floatstage::calib
