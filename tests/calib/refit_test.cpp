// What others' programs make of an exported rig, against our own projection.

#include "calib/formats/refit.h"

#include <algorithm>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "calib/formats/format_files.h"
#include "core/file.h"
#include "core/text.h"
#include "tests/calib/action_lens.h"
#include "tests/calib/foreign_views.h"
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
  Rig wide = ring_rig(4);  // an action camera's: a denominator that counts
  for (RigCamera& c : wide.cameras) {
    c.model.fx = c.model.fy = 760;
    c.model.lens = kActionLens;
  }
  out.emplace_back("rational lenses", wide);
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
  EXPECT_GE(written, 14) << "of twenty";
}

TEST(ExportedRig, OfADefaultSessionGoesToKalibr) {
  Rig rig = ring_rig(4);
  for (RigCamera& c : rig.cameras) std::get<BrownConrady>(c.model.lens).k3 = 0;  // as sessions leave it out
  const Result<FittedRig> fitted = fit_to_format(rig, format("kalibr").holds, "kalibr", kSame);
  ASSERT_THAT(fitted, IsOk());
  for (const Measured& r : fitted->residual_px) EXPECT_FALSE(r) << "held bit by bit";
}

// Its denominator is never left out without a word.
TEST(ExportedRig, WithARationalLensIsHeldFittedAgainOrRefused) {
  const Rig rig = default_rigs().back().second;
  for (const char* name : {"colmap", "opencv"}) {
    const Result<FittedRig> held = fit_to_format(rig, format(name).holds, name, kSame);
    ASSERT_THAT(held, IsOk()) << name;
    for (std::size_t c = 0; c < rig.cameras.size(); ++c)
      EXPECT_EQ(held->rig.cameras[c].model, rig.cameras[c].model) << "bit by bit";
  }
  for (const char* name : {"kalibr", "qualisys"}) {
    const Result<FittedRig> refused = fit_to_format(rig, format(name).holds, name, kSame);
    EXPECT_THAT(refused, FailsWith(ErrorCode::Unsupported, "has a rational lens (k4 to k6)")) << name;
    EXPECT_THAT(refused, FailsWith(ErrorCode::Unsupported, "write colmap or opencv, which hold it")) << name;
    const Result<FittedRig> near = fit_to_format(rig, format(name).holds, name, 20);
    ASSERT_THAT(near, IsOk()) << name;
    for (const Measured& r : near->residual_px) {
      ASSERT_TRUE(r);
      std::printf("a rational lens as %s: %.4f px\n", name, *r);
      EXPECT_GT(*r, kSame);
    }
  }
  const TempFolder folder;
  EXPECT_THAT(write_qualisys(rig, folder / "out.qca.txt"), FailsWith(ErrorCode::Unsupported, "rational"));
  EXPECT_THAT(write_kalibr(rig, folder / "out.yaml"), FailsWith(ErrorCode::Unsupported, "a rational lens"));
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
  for (const auto& [what, rig] : default_rigs()) EXPECT_LE(furthest_by_opencv(rig, rig), kSame) << what;
}

TEST(ExportedRig, IsReadByOpenCvWhereWeSeeIt) {
  for (const auto& [what, rig] : default_rigs()) {
    if (!fit_to_format(rig, format("opencv").holds, "opencv", kSame)) continue;  // fisheyes
    const TempFolder folder;
    ASSERT_THAT(write_easymocap(rig, folder / "out"), IsOk());
    EXPECT_LE(furthest_by_opencv(rig, read_by_opencv(folder / "out", rig)), kSame) << what;
  }
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
    const std::optional<double> cost = first_cost_of_colmap(rig, model, out);
    if (!cost) GTEST_SKIP() << "colmap is not installed";
    EXPECT_LE(*cost, kSame) << what;
    ++asked;
  }
  EXPECT_EQ(asked, 5);
}

}  // namespace
}  // namespace floatstage::calib
