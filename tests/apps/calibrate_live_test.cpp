#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "apps/calibrate/calibrate_verbs.h"
#include "apps/viewer/calibration/calibration_run.h"
#include "apps/viewer/calibration/calibration_view.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/random.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "tests/support/board_picture.h"
#include "tests/support/matchers.h"
#include "tests/support/run_command.h"
#include "tests/support/temp_folder.h"
#include "tests/support/under_display.h"

namespace floatstage::apps {
namespace {

const char* const kTarget = "charuco columns=5 rows=4 square=150mm marker=112mm dictionary=4x4_50";
constexpr int kFrames = 48;

Rig arc_rig() {
  Rig rig;
  for (int i = 0; i < 3; ++i) {
    const double angle = (35 * i - 35) * std::numbers::pi / 180;
    CameraModel model = test::simple_camera(640, 480, 56 + 3 * i, BrownConrady{.k1 = -0.1 + 0.03 * i});
    model.cx += 4 - 3 * i;
    rig.cameras.push_back(
        {.serial = text("cam", i),
         .model = model,
         .cam_from_world =
             look_at({2.6 * std::sin(angle), -2.6 * std::cos(angle), 1.2 + 0.15 * i}, {0, 0, 1}, {0, 0, 1}),
         .color = {}});
  }
  return rig;
}

// A take of somebody who waves the board before the arc: ten pictures a second.
const std::filesystem::path& waved_take() {
  static const TempFolder folder;
  static const std::filesystem::path take = [] {
    const calib::TargetDesign design = *calib::parse_target(kTarget);
    const Rig rig = arc_rig();
    Random random(11);
    std::vector<Rigid3> places;
    for (int frame = 0; frame < kFrames; ++frame) {
      const auto tilt = [&](double most) { return random.uniform(-most, most) * std::numbers::pi / 180; };
      const Eigen::Vector3d center(random.uniform(-0.7, 0.7), random.uniform(-0.8, 0.8),
                                   random.uniform(0.55, 1.55));
      const Eigen::Quaterniond turned =
          Eigen::AngleAxisd(tilt(45), Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(tilt(40), Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(tilt(30), Eigen::Vector3d::UnitY()) *
          Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 2, Eigen::Vector3d::UnitX()));
      const std::vector<Eigen::Vector3d> points = calib::target_points(design);
      places.push_back({turned, center - turned * (0.5 * (points.front() + points.back()))});
    }
    std::vector<Image> pictures(3 * kFrames);
    parallel_for(pictures.size(), 0, [&](std::size_t i) {
      const RigCamera& c = rig.cameras[i % 3];
      pictures[i] = test::board_picture(design, c.model, c.cam_from_world * places[i / 3],
                                        {.samples = 3, .blur = 0.7, .noise = 2, .seed = i});
    });
    const auto writer =
        capture::TakeWriter::create(folder / "take", rig, {.frame_rate = 10, .label = {}, .created = {}});
    EXPECT_THAT(writer, IsOk());
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      FrameInfo info;
      info.camera = static_cast<int>(i % 3), info.sequence = i / 3,
      info.exposure_start = Timestamp{static_cast<std::int64_t>(i / 3) * 100'000'000};
      EXPECT_THAT((*writer)->write(make_frame(info, pictures[i])), IsOk());
    }
    EXPECT_THAT((*writer)->finish(), IsOk());
    return folder / "take";
  }();
  return take;
}

studio::CaptureConfig replayed() {
  studio::CaptureConfig config;
  config.frame_rate = 10;
  for (const char* serial : {"cam0", "cam1", "cam2"})
    config.cameras.push_back({serial, text("take:", waved_take().string(), "#", serial)});
  return config;
}

LiveOptions options() {
  LiveOptions o;
  o.target.design = *calib::parse_target(kTarget);
  o.solve_every = 15;
  return o;
}

void nothing_known(calib::Observations&) {}

// What the take shows when its sets are read one after the other.
std::vector<calib::TargetView> looked_at_one_by_one(int frames) {
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(waved_take());
  std::vector<calib::CalibrationCamera> cameras;
  for (const RigCamera& c : (*take)->rig().cameras)
    cameras.push_back({.serial = c.serial, .width = 640, .height = 480, .model = {}, .cam_from_world = {}});
  calib::LiveCalibration live(options().target, cameras);
  for (int i = 0; i < frames; ++i) {
    const FrameSet set = *(*take)->frame_set(i);
    calib::LiveInstant instant = *live.look(set);
    live.keep(set, instant);
  }
  return live.observations().views;
}

std::string read(const std::filesystem::path& file) { return *read_file(file); }

Result<void> run(const std::string& arguments) {
  CLI::App app;
  Chosen chosen;
  add_calibrate_live(app, chosen);
  add_calibrate_session(app, chosen);
  app.parse(arguments);
  return chosen.run();
}

TEST(LiveRun, SeesEveryInstantOfAReplayAndSolvesWhileItRuns) {
  const Result<std::unique_ptr<LiveRun>> live = LiveRun::start(replayed(), options(), nothing_known);
  ASSERT_THAT(live, IsOk());
  (*live)->wait();
  const LiveStatus status = (*live)->status();
  EXPECT_EQ(status.sets, kFrames);
  EXPECT_EQ(status.passed_over, 0u) << "of a recording nothing is passed over";
  EXPECT_GE(status.counted, kFrames - 3);
  EXPECT_GT(status.completeness, 0.8);
  ASSERT_TRUE(status.solution) << status.trouble;
  EXPECT_EQ(status.solution_sets, status.counted);
  for (const calib::CameraQuality& q : status.solution->cameras) EXPECT_LT(q.rms_px, 0.4) << q.serial;
  EXPECT_THAT(describe_live(status), testing::HasSubstr("cam2: "));
  EXPECT_THAT(describe_live(status), testing::HasSubstr("focal ± "));
  (*live)->stop();
  EXPECT_THAT((*live)->outcome(), IsOk());
  EXPECT_EQ((*live)->observations().views, looked_at_one_by_one(kFrames)) << "however busy the machine is";
}

TEST(LiveCalibrationObject, AdviceChangesAsCoverageGrows) {
  const Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(waved_take());
  ASSERT_THAT(take, IsOk());
  std::vector<calib::CalibrationCamera> cameras;
  for (const RigCamera& c : (*take)->rig().cameras)
    cameras.push_back({.serial = c.serial, .width = 640, .height = 480, .model = {}, .cam_from_world = {}});
  calib::LiveCalibration live(options().target, cameras);
  std::vector<std::string> advice;
  double before = calib::completeness(calib::coverage_of(live.observations()));
  for (int i = 0; i < kFrames; ++i) {
    const FrameSet set = *(*take)->frame_set(i);
    Result<calib::LiveInstant> instant = live.look(set);
    ASSERT_THAT(instant, IsOk());
    live.keep(set, *instant);
    const calib::Coverage coverage = calib::coverage_of(live.observations());
    const double now = calib::completeness(coverage);
    EXPECT_GE(now, before) << "instant " << i;
    before = now;
    const std::vector<calib::Advice> list = calib::advise(coverage);
    const std::string next = list.empty() ? "enough" : list.front().sentence;
    if (advice.empty() || advice.back() != next) advice.push_back(next);
  }
  EXPECT_GE(advice.size(), 4u);
  EXPECT_THAT(advice.back(), testing::Not(testing::HasSubstr("has not seen it")));
  EXPECT_THAT(live.observations().views.size(), testing::Gt(2u * kFrames));

  // Held still, nothing is added.
  const FrameSet still = *(*take)->frame_set(kFrames - 1);
  Result<calib::LiveInstant> again = live.look(still);
  const int counted = live.counted();
  live.keep(still, *again);
  EXPECT_FALSE(again->counted);
  EXPECT_EQ(live.counted(), counted);
  EXPECT_EQ(live.sets(), kFrames + 1);
}

TEST(CalibrateLive, GivesTheRigThatTheSessionGives) {
  const TempFolder folder;
  std::string toml = "[studio]\nframe_rate = 10\n[recording]\nfolder = \"takes\"\n",
              session = text("target = \"", kTarget, "\"\nframe_rate = 10\n");
  for (const studio::CaptureConfig::Camera& c : replayed().cameras) {
    toml += text("[[camera]]\nserial = \"", c.serial, "\"\nsource = \"", c.source, "\"\n");
    session += text("[[cameras]]\nserial = \"", c.serial, "\"\nvideo = \"",
                    (waved_take() / (c.serial + ".mkv")).string(), "\"\n");
  }
  const auto at = [&](const char* name) { return (folder / name).string(); };
  folder.write("studio.toml", toml);
  folder.write("session.toml", session);
  folder.write("again.toml", "observations = \"live.json\"\n");
  (void)run(text("live ", at("studio.toml"), " --headless --least-move 0 --target '", kTarget,
                 "' --observations ", at("live.json"), " --out ", at("live-rig.json"), " --json ",
                 at("live-report.json"), " --keep-failed"));
  (void)run(text(at("again.toml"), " --out ", at("again-rig.json"), " --keep-failed"));
  (void)run(text(at("session.toml"), " --out ", at("session-rig.json"), " --keep-failed"));
  EXPECT_EQ(read(at("live-rig.json")), read(at("again-rig.json")))
      << "the same observations, the same rig, byte for byte";
  const Result<Rig> live = load_rig(at("live-rig.json")), offline = load_rig(at("session-rig.json"));
  ASSERT_THAT(live, IsOk());
  ASSERT_THAT(offline, IsOk());
  ASSERT_EQ(live->cameras.size(), 3u);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(live->cameras[c].model.fx, offline->cameras[c].model.fx, 1e-3)
        << "from the same pictures, but for the order of sums";
    EXPECT_LT((live->cameras[c].cam_from_world.center() - offline->cameras[c].cam_from_world.center()).norm(),
              1e-5);
    EXPECT_NEAR(live->cameras[c].model.fx, arc_rig().cameras[c].model.fx,
                0.01 * arc_rig().cameras[c].model.fx);
  }
  EXPECT_EQ(nlohmann::json::parse(read(at("live-report.json")))["cameras"].size(), 3u);
}

TEST(CalibrateLive, ShowsCoverageAndAdviceInAWindow) {
  const TempFolder folder;
  std::string toml = "[studio]\nframe_rate = 10\n";
  for (const studio::CaptureConfig::Camera& c : replayed().cameras)
    toml += text("[[camera]]\nserial = \"", c.serial, "\"\nsource = \"", c.source, "\"\n");
  folder.write("studio.toml", toml);
  const std::filesystem::path file = folder / "live.png";
  const Ended ended = run_command(
      under_display(text(FLOATSTAGE_PROGRAM, " calibrate live ", (folder / "studio.toml").string(),
                         " --target '", kTarget, "' --size 1100x700 --screenshot ", file.string())));
  ASSERT_EQ(ended.code, 0) << ended.output;
  EXPECT_THAT(ended.output, testing::HasSubstr("PASS"));
  const Result<Image> window = load_png(file);
  ASSERT_THAT(window, IsOk());
  EXPECT_EQ(window->width, 1100);
  // Cells of the pictures that were covered are green, the rest is dark.
  int green = 0, dark = 0;
  for (std::size_t i = 0; i < window->pixels.size(); i += 3) {
    const int r = window->pixels[i], g = window->pixels[i + 1], b = window->pixels[i + 2];
    green += g > r + 25 && g > b + 15;
    dark += r < 60 && g < 60 && b < 60;
  }
  EXPECT_GT(green, 15000);
  EXPECT_GT(dark, 200000);
}

TEST(CalibrateLive, SaysWhatIsWrongBeforeAnythingRuns) {
  const TempFolder folder;
  folder.write("studio.toml",
               "[studio]\nframe_rate = 10\n[[camera]]\nserial = \"a\"\nsource = \"take:/no/such#a\"\n");
  const std::string config = (folder / "studio.toml").string();
  EXPECT_THAT(run(text("live ", config, " --headless --target 'charuco colums=3'")),
              FailsWith(ErrorCode::BadData, "colums"));
  EXPECT_THAT(run(text("live ", config, " --headless --target '", kTarget, "'")),
              FailsWith(ErrorCode::NotFound, "/no/such"));
  EXPECT_THAT(run(text("live ", config, " --headless --lens zoom --target '", kTarget, "'")),
              FailsWith(ErrorCode::InvalidArgument, "'zoom'"));
}

TEST(Thinned, KeepsFramesThatJoinCameras) {
  calib::Observations o;
  for (const char* serial : {"a", "b"})
    o.cameras.push_back({.serial = serial, .width = 640, .height = 480, .model = {}, .cam_from_world = {}});
  for (int frame = 0; frame < 100; ++frame)
    for (int camera = 0; camera < 2; ++camera)
      if (camera == 0 || frame % 10 == 0)
        o.views.push_back({.camera = camera, .target = 0, .frame = frame, .time = {}, .points = {}});
  const calib::Observations thin = calib::thinned(o, 30);
  int joined = 0;
  for (const calib::TargetView& v : thin.views) joined += v.camera == 1;
  EXPECT_EQ(joined, 10);
  EXPECT_EQ(thin.views.size(), 40u);
  EXPECT_EQ(calib::thinned(o, 100).views.size(), o.views.size());
}

}  // namespace
}  // namespace floatstage::apps
