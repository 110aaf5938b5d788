#include "calib/observations.h"

#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/file.h"
#include "tests/calib/format_support.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::calib {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Observations sample() {
  Observations o;
  CalibrationCamera left{.serial = "left", .width = 640, .height = 480, .model = {}, .cam_from_world = {}};
  CalibrationCamera right = left;
  right.serial = "right";
  right.lens = LensKind::KannalaBrandt;
  right.intrinsics = Prior::Start;
  right.pose = Prior::Fixed;
  right.model = {.width = 640,
                 .height = 480,
                 .fx = 500.1,
                 .fy = 501,
                 .cx = 320,
                 .cy = 240,
                 .lens = KannalaBrandt{0.1, 0.2, 0.3, 0.4}};
  right.cam_from_world = {Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {0.1, 0.2, 1.0 / 3}};
  o.cameras = {left, right};
  Target board;
  board.name = "board";
  for (int i = 0; i < 6; ++i) board.points.push_back({i, {0.1 * (i % 3), 0.1 * (i / 3), 0}, {0, 0, -1}});
  board.grid = TargetGrid{3, 2, 0.1};
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  Target wand, markers;
  wand.name = "wand";
  wand.kind = TargetKind::Wand;
  wand.points = {{7, none, none}, {9, none, none}};
  wand.lengths = {{7, 9, 0.5, 1e-4}};
  markers.name = "markers";
  markers.kind = TargetKind::Markers;
  markers.points = {{0, {1, 2, 3}, none}};
  markers.positions_sigma = 0.002;
  o.targets = {board, wand, markers};
  o.views = {{0, 0, 5, {123456789012345}, {{0, {10.25, 20.5}, 0.1}, {4, {1.0 / 3, 7}, 0.2}}},
             {1, 0, 5, {123456789012346}, {{1, {600, 400}, 0.1}}},
             {1, 1, 5, {0}, {{9, {100, 100}, 0.1}}}};
  o.cameras[0].found = Rigid3{Eigen::Quaterniond(0.5, 0.5, 0.5, 0.5), {0.7, 0.1, 1.0 / 7}};
  o.distances = {{0, 1, 4.0 / 3, 0.002}};
  o.gauge = FloorBoard{0, 5, 0.003};
  return o;
}

Result<void> check_after(const std::function<void(Observations&)>& change) {
  Observations o = sample();
  change(o);
  return check(o);
}

TEST(Observations, SurviveARoundTripBitByBit) {
  const Result<Observations> back = parse_observations(to_json(sample()), "o.json");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->targets, sample().targets);
  EXPECT_EQ(back->distances, sample().distances);
  ASSERT_TRUE(back->cameras[0].found);
  EXPECT_EQ(back->cameras[0].found->translation, sample().cameras[0].found->translation);
  EXPECT_FALSE(back->cameras[1].found);
  EXPECT_EQ(back->views, sample().views);
  ASSERT_EQ(back->cameras.size(), 2u);
  EXPECT_EQ(back->cameras[1].model, sample().cameras[1].model);
  EXPECT_EQ(back->cameras[1].pose, Prior::Fixed);
  EXPECT_EQ(back->cameras[1].cam_from_world.translation, sample().cameras[1].cam_from_world.translation);
  EXPECT_EQ(back->cameras[0].intrinsics, Prior::Unknown);
  EXPECT_EQ(to_json(*back), to_json(sample()));
}

TEST(Observations, OfCamerasOfWhichNothingIsKnownSurviveToo) {
  Observations o = sample();
  for (CalibrationCamera& c : o.cameras) c.intrinsics = c.pose = Prior::Unknown;
  const Result<Observations> back = parse_observations(to_json(o), "o.json");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->views, o.views);
}

TEST(Observations, KeepEveryKindOfGauge) {
  Observations o = sample();
  o.gauge = HandSet{1, {Eigen::Quaterniond(0, 1, 0, 0), {1, 2, 3}}};
  const Result<Observations> hand = parse_observations(to_json(o), "o.json");
  ASSERT_THAT(hand, IsOk());
  ASSERT_TRUE(std::holds_alternative<HandSet>(hand->gauge));
  EXPECT_EQ(std::get<HandSet>(hand->gauge).cam_from_world.translation, Eigen::Vector3d(1, 2, 3));
  o.gauge = OwnGauge{};
  EXPECT_TRUE(std::holds_alternative<OwnGauge>(parse_observations(to_json(o), "o.json")->gauge));
}

TEST(Observations, AreSavedAndLoaded) {
  const TempFolder folder;
  ASSERT_THAT(save_observations(sample(), folder / "o.json"), IsOk());
  const Result<Observations> back = load_observations(folder / "o.json");
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->views, sample().views);
}

TEST(Observations, ThatAreUnsoundAreNeverWrittenOverAFile) {
  const TempFolder folder;
  const std::filesystem::path file = folder.write("o.json", "kept");
  Observations o = sample();
  o.views[0].points[0].pixel.x() = kNan;
  EXPECT_THAT(save_observations(o, file), FailsWith(ErrorCode::BadData, "not written"));
  EXPECT_EQ(*read_file(file), "kept");
}

TEST(Observations, CutOffAnywhereAreRefused) {
  const std::string whole = to_json(sample());
  for (std::size_t length = 0; length + 2 < whole.size(); ++length)
    EXPECT_FALSE(parse_observations(whole.substr(0, length), "o.json")) << length;
}

TEST(Observations, SayWhichCameraOrTargetIsWrong) {
  EXPECT_THAT(check_after([](Observations& o) { o.cameras[0].serial = "a/b"; }),
              FailsWith(ErrorCode::BadData, "camera 'a/b'"));
  EXPECT_THAT(check_after([](Observations& o) { o.cameras[0].serial = "right"; }),
              FailsWith(ErrorCode::BadData, "twice"));
  EXPECT_THAT(check_after([](Observations& o) { o.cameras[0].width = 0; }),
              FailsWith(ErrorCode::BadData, "camera 'left'"));
  EXPECT_THAT(check_after([](Observations& o) { o.cameras[1].width = 320; }),
              FailsWith(ErrorCode::BadData, "intrinsics are for"));
  EXPECT_THAT(check_after([](Observations& o) { o.cameras[1].lens = LensKind::BrownConrady; }),
              FailsWith(ErrorCode::BadData, "another kind"));
  EXPECT_THAT(check_after([](Observations& o) { o.cameras[1].cam_from_world.rotation.w() = 3; }),
              FailsWith(ErrorCode::BadData, "pose"));
  EXPECT_THAT(check_after([](Observations& o) { o.targets[0].points.clear(); }),
              FailsWith(ErrorCode::BadData, "'board' has no points"));
  EXPECT_THAT(check_after([](Observations& o) { o.targets[0].points[1].id = 0; }),
              FailsWith(ErrorCode::BadData, "twice"));
  EXPECT_THAT(check_after([](Observations& o) {
                o.targets[0].points[1].normal = {0, 0, 2};
              }),
              FailsWith(ErrorCode::BadData, "point 1"));
  EXPECT_THAT(check_after([](Observations& o) { o.targets[0].grid->pitch = 0; }),
              FailsWith(ErrorCode::BadData, "grid"));
  EXPECT_THAT(check_after([](Observations& o) { o.targets[1].lengths[0].b = 8; }),
              FailsWith(ErrorCode::BadData, "7 and 8"));
  EXPECT_THAT(check_after([](Observations& o) { o.targets[1].lengths[0].sigma = 0; }),
              FailsWith(ErrorCode::BadData, "sigma"));
  EXPECT_THAT(check_after([](Observations& o) { o.targets[1].lengths.clear(); }),
              FailsWith(ErrorCode::BadData, "without lengths"));
  EXPECT_THAT(check_after([](Observations& o) { o.targets[2].positions_sigma = -1; }),
              FailsWith(ErrorCode::BadData, "'markers'"));
  EXPECT_THAT(check_after([](Observations& o) { o.targets[1].name = "board"; }),
              FailsWith(ErrorCode::BadData, "twice"));
}

TEST(Observations, SayWhichViewIsWrong) {
  EXPECT_THAT(check_after([](Observations& o) { o.views[0].camera = 2; }),
              FailsWith(ErrorCode::BadData, "view 0"));
  EXPECT_THAT(check_after([](Observations& o) { o.views[2].target = -1; }),
              FailsWith(ErrorCode::BadData, "view 2"));
  EXPECT_THAT(check_after([](Observations& o) { o.views[1].camera = 0; }),
              FailsWith(ErrorCode::BadData, "frame 5"));
  EXPECT_THAT(check_after([](Observations& o) { o.views[0].points[1].id = 6; }),
              FailsWith(ErrorCode::BadData, "no point 6"));
  EXPECT_THAT(check_after([](Observations& o) { o.views[0].points[1].id = 0; }),
              FailsWith(ErrorCode::BadData, "seen twice"));
  EXPECT_THAT(check_after([](Observations& o) { o.views[0].points[0].pixel.y() = kNan; }),
              FailsWith(ErrorCode::BadData, "camera 'left', frame 5"));
  EXPECT_THAT(check_after([](Observations& o) { o.views[0].points[0].sigma = 0; }),
              FailsWith(ErrorCode::BadData, "sigma"));
  EXPECT_THAT(check_after([](Observations& o) {
                o.gauge = FloorBoard{1, 5, 0};
              }),
              FailsWith(ErrorCode::BadData, "floor"));
  EXPECT_THAT(check_after([](Observations& o) {
                o.gauge = HandSet{2, {}};
              }),
              FailsWith(ErrorCode::BadData, "camera 2"));
}

TEST(Observations, RefuseWhatTheyDoNotKnow) {
  const std::string good = to_json(sample());
  const auto parse = [&](std::string_view from, std::string_view to) {
    return parse_observations(replaced(good, from, to), "o.json");
  };
  EXPECT_THAT(parse("\"floatstage_observations\":1", "\"floatstage_observations\":2"),
              FailsWith(ErrorCode::Unsupported, "format 2"));
  EXPECT_THAT(parse("\"wand\",\"static\"", "\"wand\",\"statik\""), FailsWith(ErrorCode::BadData, "static"));
  EXPECT_THAT(parse("kannala-brandt", "fisheye"), FailsWith(ErrorCode::BadData, "'fisheye'"));
  EXPECT_THAT(parse("[7,9,0.5", "[7.5,9,0.5"), FailsWith(ErrorCode::BadData, "lengths"));
  EXPECT_THAT(parse("floor-board", "ceiling"), FailsWith(ErrorCode::BadData, "ceiling"));
}

TEST(PointIndex, FindsIdsInAnyOrder) {
  EXPECT_EQ(point_index(sample().targets[0], 4), 4);
  EXPECT_EQ(point_index(sample().targets[1], 9), 1);
  EXPECT_EQ(point_index(sample().targets[1], 0), -1);
}

}  // namespace
}  // namespace floatstage::calib
