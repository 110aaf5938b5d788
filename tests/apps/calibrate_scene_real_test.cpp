// The verb on real pictures, as people run it.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "core/file.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

const std::filesystem::path kSessions = source_folder() / "config" / "calibration";

Result<void> run(const std::string& arguments) {
  CLI::App app;
  Chosen chosen;
  add_calibrate(app, chosen);
  app.parse("calibrate " + arguments);
  return chosen.run();
}

TEST(CalibrateTemple, RingIsPlacedWithoutATargetAndAgainFromYesterday) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-ring"));
  const TempFolder folder;
  const std::string session = (kSessions / "temple-ring.toml").string();
  ASSERT_THAT(
      run(text(session, " --out ", (folder / "rig.json").string(), " --json ", (folder / "r.json").string())),
      IsOk());
  const nlohmann::json report = nlohmann::json::parse(*read_file(folder / "r.json"));
  EXPECT_EQ(report["pass"], true);
  double worst = 1e9;
  for (const nlohmann::json& bar : report["bars"])
    if (bar["what"] == "known_center_percent") worst = bar["value"];
  std::printf("worst camera centre: %.3f %% of the radius\n", worst);
  EXPECT_LE(worst, 0.3);

  // The same pictures the next day; somebody has written down a wrong pose of one camera.
  Result<Rig> yesterday = load_rig(folder / "rig.json");
  ASSERT_THAT(yesterday, IsOk());
  const Rigid3 turn{Eigen::Quaterniond(Eigen::AngleAxisd(0.002, Eigen::Vector3d::UnitY())), {0, 0, 0}};
  yesterday->cameras[5].cam_from_world = turn * yesterday->cameras[5].cam_from_world;
  ASSERT_THAT(save_rig(*yesterday, folder / "yesterday.json"), IsOk());
  ASSERT_THAT(run(text(session, " --from ", (folder / "yesterday.json").string(), " --out ",
                       (folder / "again.json").string(), " --json ", (folder / "again-r.json").string())),
              IsOk());
  const nlohmann::json again = nlohmann::json::parse(*read_file(folder / "again-r.json"));
  EXPECT_NEAR(again["cameras"][5]["moved"]["degrees"].get<double>(), 0.1146, 0.03);
  for (const std::size_t c : {std::size_t{0}, std::size_t{10}, std::size_t{18}})
    EXPECT_LT(again["cameras"][c]["moved"]["degrees"].get<double>(), 0.03) << c;
}

TEST(CalibrateTemple, SparseRingIsRefusedWithAReasonAndNothingIsWritten) {
  FLOATSTAGE_NEEDS_DATA(real_data("middlebury-temple-sparse-ring"));
  const TempFolder folder;
  EXPECT_THAT(
      run(text((kSessions / "temple-sparse-ring.toml").string(), " --out ", (folder / "rig.json").string())),
      FailsWith(ErrorCode::BadData, "too little is seen by neighbouring cameras together"));
  EXPECT_FALSE(std::filesystem::exists(folder / "rig.json"));
}

}  // namespace
}  // namespace floatstage::apps
