#include "pipeline/calibrate/report.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/calibrate/report_pictures.h"
#include "pipeline/calibrate/scene_points.h"
#include "pipeline/calibrate/session_observations.h"
#include "tests/calib/synthetic_capture.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

using testing::Contains;
using testing::Each;
using testing::Field;
using testing::HasSubstr;
using testing::Not;

const calib::CaptureOptions kCapture{.frames = 40, .frame_seconds = 0.2};

calib::Observations seen() {
  return calib::capture(calib::ring_rig(3), calib::two_sided_board(7, 5, 0.08, 0.005),
                        calib::wandering(kCapture), kCapture);
}

// Three cameras far apart know less of one another than the bars ask for.
const CalibrationBars kBars{.rotation_sigma_degrees = 0.3};

const calib::Calibration& solved() {
  static const Result<calib::Calibration> result = calib::calibrate(seen());
  return *result;
}

TEST(CalibrationVerdict, PassesAGoodCapture) {
  const Verdict v = judge(solved(), kBars);
  EXPECT_TRUE(v.pass) << describe(solved(), v);
  EXPECT_THAT(v.checks, Each(Field(&BarCheck::pass, true)));
  EXPECT_EQ(describe(solved(), v), "PASS");
}

TEST(CalibrationVerdict, FailsAtABarAndNamesTheCamera) {
  const Verdict v = judge(solved(), {.rms_px = 0.01});
  EXPECT_FALSE(v.pass);
  EXPECT_THAT(describe(solved(), v), HasSubstr("rms_px of camera 'cam0'"));
}

TEST(CalibrationVerdict, FailsForANamedFailureAndForNumbersThatAreNone) {
  calib::Calibration c = solved();
  c.failures.push_back({calib::CalibrationFailure::LateCamera, "cam1", "is late"});
  EXPECT_FALSE(judge(c, {}).pass);
  c = solved();
  c.cameras[0].rms_px = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(judge(c, {}).pass);
  EXPECT_FALSE(judge({}, {}).pass) << "nothing was solved";
}

TEST(CalibrationReport, HoldsTheNumbersAsJson) {
  const nlohmann::json j =
      report_json(solved(), judge(solved(), kBars), {"test", {"camera 'cam0': 40 of 40"}, {"a remark"}, 1.5});
  EXPECT_TRUE(j["pass"].get<bool>());
  ASSERT_EQ(j["cameras"].size(), 3u);
  EXPECT_EQ(j["cameras"][1]["serial"], "cam1");
  EXPECT_GT(j["cameras"][1]["rms_px"].get<double>(), 0.1);
  EXPECT_GT(j["cameras"][1]["holdout_px"].get<double>(), 0.1);
  EXPECT_GT(j["cameras"][1]["sigma"]["k1"].get<double>(), 0);
  EXPECT_TRUE(j["cameras"][1]["sigma"]["k3"].is_null()) << "nothing spoke for it, so it was not solved for";
  EXPECT_GT(j["scale"]["count"].get<int>(), 100);
  EXPECT_TRUE(j["failures"].empty());
  EXPECT_EQ(j["remarks"][0], "a remark");
  EXPECT_TRUE(j.contains("seconds"));
}

TEST(CalibrationReport, IsOnePageThatNeedsNothingElse) {
  ReportContext context{"<b>", {"found & lost"}, {}, 0};
  const std::string html = report_html(solved(), judge(solved(), kBars), context);
  EXPECT_THAT(html, HasSubstr("PASS"));
  EXPECT_THAT(html, HasSubstr("&lt;b&gt;"));
  EXPECT_THAT(html, HasSubstr("found &amp; lost"));
  for (const char* elsewhere : {"http://", "https://", "src=", "href=", "<script"})
    EXPECT_THAT(html, Not(HasSubstr(elsewhere)));
  // Three pictures a camera and the graph.
  std::size_t pictures = 0;
  for (std::size_t at = html.find("<svg"); at != std::string::npos; at = html.find("<svg", at + 1))
    ++pictures;
  EXPECT_EQ(pictures, 10u);
}

TEST(CalibrationReport, SaysWhatItsShadesMean) {
  const std::string html = report_html(solved(), judge(solved(), kBars), {});
  for (const char* words : {">0.3 px<", ">≥ 1 px<", ">0 points<"}) EXPECT_THAT(html, HasSubstr(words));
}

TEST(CalibrationVerdict, FailsByANumberOfTheSessionAbove) {
  Verdict v = judge(solved(), kBars);
  add_check(v, solved(), {"points_px", "", 4.9, 5, false});
  EXPECT_TRUE(v.pass);
  add_check(v, solved(), {"points_px", "", std::nan(""), 5, false});
  EXPECT_FALSE(v.pass) << "rays that do not meet";
}

TEST(ScenePoints, MeetInTheRigThatSawThem) {
  Rig rig = calib::ring_rig(3);
  std::vector<SessionPoint> points;
  for (const Eigen::Vector3d& x : {Eigen::Vector3d(0.3, 0.2, 1), Eigen::Vector3d(-0.4, 0.1, 0.6)}) {
    SessionPoint p{text("mark ", points.size()), {}};
    for (const RigCamera& c : rig.cameras)
      p.seen.push_back({c.serial, *project(c.model, c.cam_from_world * x)});
    points.push_back(p);
  }
  const Result<ScenePoints> exact = measure_points(points, rig);
  ASSERT_THAT(exact, IsOk());
  EXPECT_LT(exact->rms_px, 1e-6);
  EXPECT_LT((exact->places[1] - Eigen::Vector3d(-0.4, 0.1, 0.6)).norm(), 1e-9);
  rig.cameras[1].model.cx += 9;  // two thirds of it remain where the rays meet
  const Result<ScenePoints> shifted = measure_points(points, rig);
  ASSERT_THAT(shifted, IsOk());
  EXPECT_GT(shifted->rms_px, 1);
  EXPECT_LT(shifted->rms_px, 9);
  EXPECT_THAT(describe(*shifted, rig, "known"), HasSubstr("2 points of the scene meet within"));
  points[0].seen[0].serial = "nobody";
  EXPECT_THAT(measure_points(points, rig), FailsWith(ErrorCode::NotFound, "'nobody'"));
}

TEST(CalibrationReport, OfACaptureThatCouldNotBeSolvedSaysWhy) {
  calib::Calibration c;
  c.failures.push_back({calib::CalibrationFailure::SwappedRowsColumns, "", "exchange rows and columns"});
  const std::string html = report_html(c, judge(c, {}), {});
  EXPECT_THAT(html, HasSubstr("FAIL"));
  EXPECT_THAT(html, HasSubstr("exchange rows and columns"));
}

TEST(CalibrationReport, IsTwoFilesInAFolder) {
  const TempFolder folder;
  ASSERT_THAT(save_report(solved(), judge(solved(), kBars), {}, folder / "new/report"), IsOk());
  EXPECT_TRUE(std::filesystem::exists(folder / "new/report/calibration.html"));
  EXPECT_TRUE(nlohmann::json::parse(*read_file(folder / "new/report/calibration.json")).contains("pass"));
}

TEST(CalibrationKnown, AppliesWhatIsKnownToTheCamerasOfItsName) {
  calib::Observations o = seen();
  const Rig rig = calib::ring_rig(3);
  ASSERT_THAT(
      apply_known({"rig", "r.json", calib::kMetresPerUnit, calib::Prior::Fixed, calib::Prior::Start}, rig, o),
      IsOk());
  EXPECT_EQ(o.cameras[2].intrinsics, calib::Prior::Fixed);
  EXPECT_EQ(o.cameras[2].model, rig.cameras[2].model);
  EXPECT_EQ(o.cameras[2].pose, calib::Prior::Start);
  EXPECT_THAT(apply_known({"rig", "r.json", calib::kMetresPerUnit, calib::Prior::Fixed, calib::Prior::Start},
                          calib::ring_rig(2), o),
              FailsWith(ErrorCode::NotFound, "'cam2'"));
}

TEST(CalibrationKnown, IsComparedWithWhereItIsNotTaken) {
  Rig known = calib::ring_rig(3);
  for (RigCamera& c : known.cameras) c.model.fx *= 1.01;
  const std::vector<std::string> sentences = compare_to_known({}, known, calib::ring_rig(3));
  ASSERT_EQ(sentences.size(), 3u);
  EXPECT_THAT(sentences[0], HasSubstr("-0.99 %"));
  EXPECT_TRUE(compare_to_known({"rig", "", calib::kMetresPerUnit, calib::Prior::Fixed, calib::Prior::Unknown},
                               known, known)
                  .empty());
}

}  // namespace
}  // namespace floatstage::pipeline
