// The sessions in config/calibration, run as an operator runs them.

#include <algorithm>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "calib/formats/format_files.h"
#include "core/file.h"
#include "core/rig.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

using testing::HasSubstr;

Result<void> run(const std::string& session, const TempFolder& folder) {
  CLI::App app;
  Chosen chosen;
  add_calibrate_session(app, chosen);
  const auto in = [&](const char* name) { return (folder / name).string(); };
  std::vector<std::string> arguments = {text(source_folder().string(), "/config/calibration/", session),
                                        "--out",
                                        in("rig.json"),
                                        "--report",
                                        in("report"),
                                        "--json",
                                        in("R.json")};
  std::reverse(arguments.begin(), arguments.end());
  app.parse(arguments);
  return chosen.run();
}

nlohmann::json report(const TempFolder& folder) {
  return nlohmann::json::parse(read_file(folder / "R.json").value());
}

TEST(CalibrateReal, CaliscopePassesWithAllFourCamerasTogether) {
  FLOATSTAGE_NEEDS_DATA(real_data("caliscope-4cam"));
  const TempFolder folder;
  ASSERT_THAT(run("caliscope-4cam.toml", folder), IsOk());
  const nlohmann::json r = report(folder);
  EXPECT_TRUE(r["pass"].get<bool>());
  EXPECT_TRUE(r["failures"].empty());
  ASSERT_EQ(r["cameras"].size(), 4u);
  for (const nlohmann::json& c : r["cameras"]) {
    EXPECT_LE(c["rms_px"].get<double>(), 0.35);
    EXPECT_LE(c["rms_px"].get<double>(), 0.12) << "what it was when this was written, with a margin";
    EXPECT_LE(c["holdout_px"].get<double>(), 1.3 * c["rms_px"].get<double>());
    EXPECT_LE(c["outliers"].get<int>(), 0.1 * c["points"].get<int>());
  }
  EXPECT_LE(r["scale"]["rms_mm"].get<double>(), 0.2);
  EXPECT_GE(r["scale"]["count"].get<int>(), 600);
  const Result<Rig> rig = load_rig(folder / "rig.json");
  ASSERT_THAT(rig, IsOk());
  EXPECT_EQ(rig->cameras.size(), 4u);
}

TEST(CalibrateReal, Pose2SimChessboardsAgreeWithItsOwnCalibration) {
  FLOATSTAGE_NEEDS_DATA(real_data("pose2sim-balancing"));
  const TempFolder folder;
  ASSERT_THAT(run("pose2sim-balancing.toml", folder), IsOk());
  const Result<Rig> rig = load_rig(folder / "rig.json");
  ASSERT_THAT(rig, IsOk());
  const Result<calib::ForeignRig> known =
      calib::read_qualisys(real_data("pose2sim-balancing") / "calibration/Calib.qca.txt");
  ASSERT_THAT(known, IsOk());
  for (const RigCamera& c : rig->cameras) {
    const RigCamera& was = known->rig.cameras[static_cast<std::size_t>(camera_index(known->rig, c.serial))];
    EXPECT_NEAR(c.model.fx / was.model.fx, 1, 0.01) << c.serial;
    EXPECT_NEAR(c.model.fy / was.model.fy, 1, 0.01) << c.serial;
    EXPECT_EQ(c.cam_from_world.translation, was.cam_from_world.translation) << "imported as it is";
  }
  const std::string page = read_file(folder / "report/calibration.html").value();
  EXPECT_THAT(page, HasSubstr("from the known"));
  EXPECT_THAT(page, HasSubstr("4 points of the scene meet within 10.7 px in the known rig"));
  EXPECT_THAT(page, HasSubstr("points_px"));
}

}  // namespace
}  // namespace floatstage::apps
