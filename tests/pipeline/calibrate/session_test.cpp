#include "pipeline/calibrate/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/rig_io.h"
#include "pipeline/calibrate/session_observations.h"
#include "tests/core/rigs.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string kWhole =
    R"(target = "charuco columns=4 rows=5 square=54mm marker=40.5mm dictionary=4x4_1000 inverted"
frame_rate = 30
first_frame = 2
every = 3
end_frame = 100
[floor]
frame = 12
height_mm = 3
[known]
file = "yesterday.json"
intrinsics = "fixed"
poses = "start"
[options]
time_offsets = true
holdout_every = 7
[bars]
rms_px = 0.35
[[cameras]]
serial = "left"
video = "left.mp4"
lens = "kannala-brandt"
[[cameras]]
serial = "right"
images = ["a.png", "b.png"]
alone = "intrinsics"
)";

Result<Session> parse(const std::string& toml) { return parse_session(toml, "s.toml"); }

Result<Session> with(std::string from, const std::string& to) {
  std::string toml = kWhole;
  const std::size_t at = toml.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return parse(toml.replace(at, from.size(), to));
}

TEST(CalibrationSession, HoldsAllThatIsKnown) {
  const Result<Session> s = parse(kWhole);
  ASSERT_THAT(s, IsOk());
  EXPECT_TRUE(std::holds_alternative<calib::CharucoBoard>(*s->target));
  EXPECT_EQ(s->frame_rate, 30);
  EXPECT_EQ(s->first_frame, 2);
  EXPECT_EQ(s->every, 3);
  EXPECT_EQ(s->end_frame, 100);
  EXPECT_EQ(s->floor->frame, 12);
  EXPECT_DOUBLE_EQ(s->floor->height, 0.003);
  EXPECT_EQ(s->known->intrinsics, calib::Prior::Fixed);
  EXPECT_EQ(s->known->poses, calib::Prior::Start);
  EXPECT_TRUE(s->options.time_offsets);
  EXPECT_EQ(s->options.holdout_every, 7);
  EXPECT_EQ(s->bars.rms_px, 0.35);
  EXPECT_EQ(s->bars.holdout_ratio, CalibrationBars{}.holdout_ratio)
      << "bars that are not given keep their defaults";
  ASSERT_EQ(s->cameras.size(), 2u);
  EXPECT_EQ(s->cameras[0].lens, calib::LensKind::KannalaBrandt);
  EXPECT_EQ(s->cameras[0].video, "left.mp4");
  EXPECT_THAT(s->cameras[1].images, ElementsAre("a.png", "b.png"));
  EXPECT_THAT(s->cameras[1].alone, ElementsAre("intrinsics"));
}

TEST(CalibrationSession, HoldsPointsToCheckBy) {
  const std::string point = "[[points]]\nname = \"corner\"\nseen = { left = [1.5, 2], right = [3, 4] }\n";
  const Result<Session> s = parse(kWhole + point);
  ASSERT_THAT(s, IsOk());
  ASSERT_EQ(s->points.size(), 1u);
  EXPECT_EQ(s->points[0].seen[0].serial, "left");
  EXPECT_EQ(s->points[0].seen[0].pixel, Eigen::Vector2d(1.5, 2));
  EXPECT_THAT(parse(kWhole + "[[points]]\nname = \"corner\"\nseen = { left = [1, 2] }\n"),
              FailsWith(ErrorCode::BadData, "'corner' is not seen by two cameras"));
  EXPECT_THAT(parse(kWhole + "[[points]]\nseen = { left = [1, 2, 3], right = [1, 2] }\n"),
              FailsWith(ErrorCode::BadData, "[x, y]"));
  EXPECT_THAT(parse(kWhole + "[[points]]\nseen = { left = [nan, 2], right = [1, 2] }\n"),
              FailsWith(ErrorCode::BadData, "'left'"));
}

TEST(CalibrationSession, FindsItsFilesBesideItself) {
  const TempFolder folder;
  const Result<Session> s = load_session(folder.write("s.toml", kWhole));
  ASSERT_THAT(s, IsOk());
  EXPECT_EQ(s->cameras[0].video, folder / "left.mp4");
  EXPECT_EQ(s->cameras[1].alone[0], folder / "intrinsics");
  EXPECT_EQ(s->known->file, folder / "yesterday.json");
}

TEST(CalibrationSession, KnowsRigsOfEveryFormat) {
  EXPECT_EQ(parse(kWhole)->known->format, calib::kAnyRigFormat);
  for (const calib::RigFormat& f : calib::rig_formats()) {
    const Result<Session> s =
        with("\"yesterday.json\"", text("\"yesterday.json\"\nformat = \"", f.name, "\""));
    ASSERT_THAT(s, IsOk()) << f.name;
    EXPECT_EQ(s->known->format, f.name);
  }
  EXPECT_THAT(
      with("\"yesterday.json\"", "\"yesterday.json\"\nformat = \"blender\""),
      FailsWith(ErrorCode::BadData, "line 11: 'format': 'blender' is no calibration format; there are"));
}

TEST(CalibrationSession, TakesAUnitOnlyForFormatsThatStateNone) {
  const Result<Session> s =
      with("\"yesterday.json\"", "\"calibration.txt\"\nformat = \"dome\"\nmetres_per_unit = 0.2");
  ASSERT_THAT(s, IsOk());
  EXPECT_EQ(s->known->metres_per_unit, 0.2);
  EXPECT_THAT(with("\"yesterday.json\"", "\"r.qca.txt\"\nformat = \"qualisys\"\nmetres_per_unit = 0.2"),
              FailsWith(ErrorCode::BadData, "formats that state no unit, which qualisys does"));
}

TEST(CalibrationSession, NamesTheLineOfAMistake) {
  EXPECT_THAT(with("every = 3", "evry = 3"),
              FailsWith(ErrorCode::BadData, "s.toml: line 4: unknown key 'evry'"));
  EXPECT_THAT(with("every = 3", "every = 0"), FailsWith(ErrorCode::BadData, "line 4"));
  EXPECT_THAT(with("every = 3", "every = \"3\""), FailsWith(ErrorCode::BadData, "whole number"));
  EXPECT_THAT(with("frame_rate = 30", "frame_rate = nan"), FailsWith(ErrorCode::BadData, "line 2"));
  EXPECT_THAT(with("columns=4", "colums=4"), FailsWith(ErrorCode::BadData, "line 1"));
  EXPECT_THAT(with("\"start\"", "\"begin\""),
              FailsWith(ErrorCode::BadData, "\"compare\", \"start\", \"fixed\""));
  EXPECT_THAT(with("\"kannala-brandt\"", "\"fisheye\""), FailsWith(ErrorCode::BadData, "'lens' is one of"));
  EXPECT_THAT(with("time_offsets = true", "time_offsets = 1"),
              FailsWith(ErrorCode::BadData, "true or false"));
  EXPECT_THAT(with("[bars]", "[bar]"), FailsWith(ErrorCode::BadData, "unknown key 'bar'"));
  EXPECT_THAT(with("\"right\"", "\"left\""), FailsWith(ErrorCode::BadData, "'left' stands there twice"));
  EXPECT_THAT(with("\"right\"", "\"../right\""), FailsWith(ErrorCode::BadData, "names a camera"));
  EXPECT_THAT(with("[\"a.png\", \"b.png\"]", "[\"a.png\", 3]"),
              FailsWith(ErrorCode::BadData, "list of strings"));
  EXPECT_THAT(with("end_frame = 100", "end_frame = 2"), FailsWith(ErrorCode::BadData, "not after"));
  EXPECT_THAT(with("\"yesterday.json\"", "\"\""), FailsWith(ErrorCode::BadData, "'file' is missing"));
  EXPECT_THAT(with("[floor]", "[floor"), FailsWith(ErrorCode::BadData, "not TOML"));
  EXPECT_THAT(with("video = \"left.mp4\"\n", ""), FailsWith(ErrorCode::BadData, "'left' has no pictures"));
  EXPECT_THAT(with("video = \"left.mp4\"\n", "video = \"left.mp4\"\nimages = \"x\"\n"),
              FailsWith(ErrorCode::BadData, "give one of them"));
}

TEST(CalibrationSession, NeedsATargetAndACameraOrObservations) {
  EXPECT_THAT(parse(""), FailsWith(ErrorCode::BadData, "'target' is missing"));
  EXPECT_THAT(parse("target = \"chessboard columns=8 rows=5 square=30mm\""),
              FailsWith(ErrorCode::BadData, "no camera"));
  EXPECT_THAT(parse("observations = \"o.json\""), IsOk());
  EXPECT_THAT(parse("observations = \"o.json\"\n" + kWhole), FailsWith(ErrorCode::BadData, "leave 'target'"));
}

const std::string kScene = R"([markerless]
between = ["a", "b"]
distance = 1.5
sigma_mm = 2
least_points = 40
[known]
file = "lenses.json"
intrinsics = "fixed"
[[cameras]]
serial = "a"
scene = "a.png"
[[cameras]]
serial = "b"
scene = "b.png"
[[cameras]]
serial = "handy"
scene = "walk"
carried = true
)";

TEST(CalibrationSession, OfASceneNeedsNoTarget) {
  const Result<Session> s = parse(kScene);
  ASSERT_THAT(s, IsOk());
  EXPECT_EQ(s->markerless->a, "a");
  EXPECT_EQ(s->markerless->distance, 1.5);
  EXPECT_DOUBLE_EQ(s->markerless->sigma, 0.002);
  EXPECT_EQ(s->markerless->least_points, 40);
  EXPECT_THAT(s->cameras[0].scene, ElementsAre("a.png"));
  EXPECT_TRUE(s->cameras[2].carried);
  const auto changed = [](const std::string& from, const std::string& to) {
    std::string toml = kScene;
    return parse(toml.replace(toml.find(from), from.size(), to));
  };
  EXPECT_EQ(s->options.ring, 0) << "nobody says that the cameras stand on one";
  const Result<Session> ring = changed("least_points = 40", "ring_percent = 0.5");
  ASSERT_THAT(ring, IsOk());
  EXPECT_DOUBLE_EQ(ring->markerless->ring, 0.005);
  EXPECT_DOUBLE_EQ(ring->options.ring, 0.005);
  EXPECT_THAT(changed("least_points = 40", "ring_percent = 90"),
              FailsWith(ErrorCode::BadData, "ring_percent"));
  EXPECT_THAT(changed("distance = 1.5\n", ""), FailsWith(ErrorCode::BadData, "belong together"));
  EXPECT_THAT(changed("[\"a\", \"b\"]", "[\"a\", \"x\"]"),
              FailsWith(ErrorCode::BadData, "'between' names camera 'x'"));
  EXPECT_THAT(changed("[\"a\", \"b\"]", "[\"a\"]"), FailsWith(ErrorCode::BadData, "two cameras"));
  EXPECT_THAT(changed("scene = \"a.png\"", "video = \"a.mp4\""),
              FailsWith(ErrorCode::BadData, "'a', which has no picture"));
  EXPECT_THAT(changed("scene = \"walk\"", "video = \"a.mp4\""),
              FailsWith(ErrorCode::BadData, "carried about"));
  EXPECT_THAT(changed(kScene.substr(0, kScene.find("[known]")), ""),
              FailsWith(ErrorCode::BadData, "need a table [markerless]"));
}

TEST(CalibrationSession, CutOffAnywhereNeverCrashes) {
  for (std::size_t length = 0; length < kWhole.size(); ++length) {
    const Result<Session> s = parse(kWhole.substr(0, length));
    EXPECT_TRUE(!s.has_value() || !s->cameras.empty()) << length;
  }
}

TEST(CalibrationSession, ThatIsNotThereIsNamed) {
  EXPECT_THAT(load_session("/no/such/session.toml"), FailsWith(ErrorCode::NotFound, "session.toml"));
}

TEST(KnownRig, KeepsARationalLens) {
  const TempFolder folder;
  Rig rig = ring(3);
  rig.cameras[1].model.lens = BrownConrady{.k1 = 0.1, .k5 = 0.02};
  ASSERT_THAT(save_rig(rig, folder / "rig.json"), IsOk());
  const Result<Rig> known = load_known({.format = "rig", .file = folder / "rig.json"});
  ASSERT_THAT(known, IsOk());
  EXPECT_EQ(known->cameras[1].model.lens, rig.cameras[1].model.lens);
}

}  // namespace
}  // namespace floatstage::pipeline
