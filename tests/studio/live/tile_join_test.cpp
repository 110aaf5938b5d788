#include "studio/live/tile_join.h"

#include <gtest/gtest.h>

namespace floatstage::studio {
namespace {

constexpr Timestamp at_ms(std::int64_t ms) { return Timestamp{} + milliseconds(ms); }

std::shared_ptr<const CameraView> tile(const std::string& serial, std::int64_t exposed_ms) {
  auto view = std::make_shared<CameraView>();
  view->serial = serial;
  view->instant = view->exposed = at_ms(exposed_ms);
  view->known = true;
  view->tile = std::make_shared<const ForegroundTile>();
  return view;
}

std::shared_ptr<const StudioScene> scene(std::int64_t instant_ms, const std::string& serials = "abcd") {
  auto s = std::make_shared<StudioScene>();
  s->instant = at_ms(instant_ms);
  for (char serial : serials) s->cameras.push_back({std::string(1, serial), at_ms(instant_ms)});
  return s;
}

// A viewer that wants the cameras b and c and has had their tiles.
struct Viewer {
  TileJoin join{{"a", "b", "c", "d"}, {}};
  Viewer() {
    join.want({1, 2});
    for (const char* serial : {"b", "c"}) join.push(tile(serial, 960));
  }
};

TEST(TileJoin, WaitsUntilEveryWantedTextureOfASceneIsHere) {
  Viewer v;
  v.join.push(scene(1000), at_ms(1020));
  EXPECT_EQ(v.join.newest(at_ms(1020)), nullptr);
  v.join.push(tile("b", 1000));
  EXPECT_EQ(v.join.newest(at_ms(1021)), nullptr);
  v.join.push(tile("c", 1000));
  const auto live = v.join.newest(at_ms(1022));
  ASSERT_NE(live, nullptr);
  EXPECT_EQ(live->scene.instant, at_ms(1000));
  EXPECT_EQ(live->ready, at_ms(1022));
  EXPECT_EQ(live->views[0], nullptr);
  EXPECT_EQ(live->views[1]->exposed, at_ms(1000));
  EXPECT_EQ(live->views[2]->exposed, at_ms(1000));
  EXPECT_EQ(v.join.newest(at_ms(1023)), nullptr) << "each once";
}

TEST(TileJoin, TakesTilesThatCameBeforeTheirScene) {
  Viewer v;
  for (const char* serial : {"b", "c"}) v.join.push(tile(serial, 1000));
  v.join.push(scene(1000), at_ms(1020));
  EXPECT_NE(v.join.newest(at_ms(1020)), nullptr);
}

TEST(TileJoin, ShowsTheNewestSceneThatIsComplete) {
  Viewer v;
  for (std::int64_t instant : {1000, 1040, 1080}) v.join.push(scene(instant), at_ms(instant + 10));
  for (std::int64_t instant : {1000, 1040})
    for (const char* serial : {"b", "c"}) v.join.push(tile(serial, instant));
  EXPECT_EQ(v.join.newest(at_ms(1090))->scene.instant, at_ms(1040));
  EXPECT_EQ(v.join.counters().overtaken, 1u);
  for (const char* serial : {"b", "c"}) v.join.push(tile(serial, 1080));
  EXPECT_EQ(v.join.newest(at_ms(1091))->scene.instant, at_ms(1080));
}

TEST(TileJoin, ShowsWhatThereIsWhenATileWasLost) {
  Viewer v;
  v.join.push(scene(1000), at_ms(1020));
  v.join.push(tile("b", 1000));
  EXPECT_EQ(v.join.newest(at_ms(1169)), nullptr);
  const auto live = v.join.newest(at_ms(1170));
  ASSERT_NE(live, nullptr);
  EXPECT_NE(live->views[1], nullptr);
  EXPECT_EQ(live->views[2], nullptr);
  EXPECT_EQ(v.join.counters().incomplete, 1u);
}

TEST(TileJoin, DoesNotWaitForACameraThatWasOnlyJustAskedFor) {
  Viewer v;
  v.join.want({1, 2, 3});
  for (const char* serial : {"b", "c"}) v.join.push(tile(serial, 1000));
  v.join.push(scene(1000), at_ms(1020));
  EXPECT_NE(v.join.newest(at_ms(1020)), nullptr) << "nothing of d has ever come";
  v.join.push(tile("d", 1080));  // its first: the scene before never gets one
  v.join.push(scene(1040), at_ms(1060));
  for (const char* serial : {"b", "c"}) v.join.push(tile(serial, 1040));
  EXPECT_NE(v.join.newest(at_ms(1060)), nullptr);
}

TEST(TileJoin, DoesNotWaitForACameraThatMissedTheInstantOrFellSilent) {
  Viewer v;
  v.join.push(scene(1000, "ab"), at_ms(1020));
  v.join.push(tile("b", 1000));
  EXPECT_NE(v.join.newest(at_ms(1020)), nullptr) << "c did not see this instant";
  v.join.push(scene(1460), at_ms(1480));
  v.join.push(tile("b", 1460));
  EXPECT_NE(v.join.newest(at_ms(1480)), nullptr) << "c has been silent for half a second";
}

TEST(TileJoin, GoesOnWithAReconstructionThatWasStartedAgain) {
  Viewer v;
  v.join.push(scene(5000), at_ms(5010));
  v.join.push(scene(1000), at_ms(5020));
  for (const char* serial : {"b", "c"}) v.join.push(tile(serial, 1000));
  EXPECT_EQ(v.join.newest(at_ms(5020))->scene.instant, at_ms(1000));
}

}  // namespace
}  // namespace floatstage::studio
