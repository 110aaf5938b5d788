#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/text.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::apps {
namespace {

// A pattern without repetition; `shift` px to the right is a turn about the vertical.
Image wall(double shift) {
  Image image(320, 240, 1);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const double u = x - shift;
      const double v = std::sin(u * u / 900 + 0.11 * y) + std::sin(0.13 * u - y * y / 700.0) +
                       std::sin(0.31 * u + 0.23 * y);
      *image.at(x, y) = static_cast<std::uint8_t>(std::lround(128 + 30 * v));
    }
  return image;
}

Result<void> run(const std::string& arguments) {
  CLI::App app;
  Chosen chosen;
  add_calibrate_drift(app, chosen);
  app.parse("drift " + arguments);
  return chosen.run();
}

// Two cameras at one frame a second; the second is touched after 20 s.
std::filesystem::path make_take(const TempFolder& folder, const std::string& name, double shift) {
  Rig rig;
  for (const char* serial : {"left", "right"})
    rig.cameras.push_back(
        {.serial = serial,
         .model = {.width = 320, .height = 240, .fx = 300, .fy = 300, .cx = 160, .cy = 120, .lens = {}},
         .cam_from_world = {},
         .color = {}});
  const auto writer =
      capture::TakeWriter::create(folder / name, rig, {.frame_rate = 1, .label = {}, .created = {}});
  EXPECT_THAT(writer, IsOk());
  for (int i = 0; i < 30; ++i)
    for (int camera = 0; camera < 2; ++camera) {
      FrameInfo info;
      info.camera = camera, info.sequence = static_cast<std::uint64_t>(i),
      info.exposure_start = Timestamp{i * 1'000'000'000LL};
      EXPECT_THAT((*writer)->write(make_frame(info, wall(camera == 1 && i >= 20 ? shift : 0))), IsOk());
    }
  EXPECT_THAT((*writer)->finish(), IsOk());
  return folder / name;
}

TEST(CalibrateDrift, WritesTheCameraAndTheAngleIntoQualityJson) {
  const TempFolder folder;
  const std::filesystem::path take = make_take(folder, "take", 300 * std::tan(0.2 * 3.14159265 / 180));
  ASSERT_THAT(write_file(take / "quality.json", "{\"pass\": true}"), IsOk());
  ASSERT_THAT(run(text(take.string(), " --make-reference ", (folder / "drift.json").string())), IsOk());
  ASSERT_THAT(run(text(take.string(), " --reference ", (folder / "drift.json").string())), IsOk());
  const nlohmann::json quality = nlohmann::json::parse(*read_file(take / "quality.json"));
  EXPECT_EQ(quality["pass"], true) << "what the recorder found stays";
  ASSERT_EQ(quality["drift"]["alarms"].size(), 1u);
  const nlohmann::json& alarm = quality["drift"]["alarms"][0];
  EXPECT_EQ(alarm["camera"], "right");
  EXPECT_NEAR(alarm["degrees"].get<double>(), 0.2, 0.04);
  EXPECT_EQ(alarm["moved"], false);
  EXPECT_GE(alarm["seconds"].get<double>(), 20);
  EXPECT_LE(alarm["seconds"].get<double>(), 25);
}

TEST(CalibrateDrift, SaysWhatIsMissing) {
  const TempFolder folder;
  const std::filesystem::path take = make_take(folder, "take", 0);
  EXPECT_THAT(run(take.string()), FailsWith(ErrorCode::InvalidArgument, "--make-reference"));
  EXPECT_THAT(run(text(take.string(), " --reference ", (folder / "none.json").string())),
              FailsWith(ErrorCode::NotFound, "none.json"));
  ASSERT_THAT(run(text(take.string(), " --make-reference ", (folder / "drift.json").string())), IsOk());
  ASSERT_THAT(write_file(take / "quality.json", "[1"), IsOk());
  EXPECT_THAT(run(text(take.string(), " --reference ", (folder / "drift.json").string())),
              FailsWith(ErrorCode::BadData, "quality.json"));
  EXPECT_EQ(*read_file(take / "quality.json"), "[1") << "nothing is overwritten";
}

}  // namespace
}  // namespace floatstage::apps
