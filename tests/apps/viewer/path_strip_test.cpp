#include "apps/viewer/play/path_strip.h"

#include <gtest/gtest.h>

#include "tests/apps/viewer/hands.h"

namespace floatstage::apps {
namespace {

using Kind = InputEvent::Kind;

// A path of 10 s with keys at 0, 5 and 10 s on a take of 101 frames, 25 a second; 1150 px for 11.5 s of film,
// and for the take's 4 s.
class PathStripOfThreeKeys : public testing::Test {
 protected:
  PathStripOfThreeKeys() : state_{TimeLine(101, 25), ViewerCamera(home())} {
    state_.path.set({{key_at(0), key_at(5), key_at(10)}});
    strip_.set_area(100, 500, 1200, 52);
  }

  static pipeline::PathKey home() {
    pipeline::PathKey key;
    key.eye = {0, -4, 1}, key.target = {0, 0, 1};
    return key;
  }
  static pipeline::PathKey key_at(double time) {
    pipeline::PathKey key = home();
    key.time = time;
    return key;
  }
  double film_x(double seconds) const { return 140 + 100 * seconds; }
  double take_x(double seconds) const { return 140 + 1150 * seconds / 4; }
  void drag(double from, double to, double y) {
    strip_.take({{at(Kind::Press, from, y), at(Kind::Move, (from + to) / 2, y), at(Kind::Move, to, y),
                  at(Kind::Release, to, y)}},
                state_);
  }
  const std::vector<pipeline::PathKey>& keys() const { return state_.path.path().keys; }

  PlayerState state_;
  PathStrip strip_;
};

constexpr double kFilm = 513, kTake = 539;  // px

TEST_F(PathStripOfThreeKeys, MovesAKeyInTheFilmsTime) {
  drag(film_x(5), film_x(6.5), kFilm);
  EXPECT_NEAR(keys()[1].time, 6.5, 1e-9);
  EXPECT_FALSE(keys()[1].take_time);
  EXPECT_EQ(state_.path.selected(), 1u);
  state_.path.undo();
  EXPECT_EQ(keys()[1].time, 5) << "a drag is one step";
}

TEST_F(PathStripOfThreeKeys, MovesTheLastKeyAsFarAsTheHandHoweverLongThePathBecomes) {
  drag(film_x(10), film_x(11), kFilm);
  EXPECT_NEAR(keys()[2].time, 11, 1e-9);
}

TEST_F(PathStripOfThreeKeys, MovesAKeyInTheTakesTimeByWholeFramesAndShowsIt) {
  drag(take_x(0), take_x(2.03), kTake);
  EXPECT_EQ(keys()[0].take_time, 2.04);
  EXPECT_EQ(state_.time.frame(), 51);
  drag(take_x(2.04), take_x(99), kTake);
  EXPECT_EQ(keys()[0].take_time, 4) << "no further than the take goes";
}

TEST_F(PathStripOfThreeKeys, RidesThePathWhereNoKeyIs) {
  drag(film_x(2), film_x(3), kFilm);
  EXPECT_TRUE(state_.follow_path);
  EXPECT_NEAR(state_.path_time, 3, 1e-9);
  EXPECT_EQ(state_.time.frame(), 75);
  EXPECT_EQ(state_.path.path(), pipeline::CameraPath({key_at(0), key_at(5), key_at(10)}));
}

TEST_F(PathStripOfThreeKeys, LeavesDragsAloneThatBeganElsewhere) {
  drag(film_x(5), film_x(6), 400);
  EXPECT_EQ(keys()[1].time, 5);
}

TEST_F(PathStripOfThreeKeys, UndoesByControlZAndRemovesByDelete) {
  drag(film_x(5), film_x(6), kFilm);
  strip_.take({{key(kKeyDelete)}}, state_);
  ASSERT_EQ(keys().size(), 2u);
  InputEvent undo = key('Z'), redo = key('Y');
  undo.control = redo.control = true;
  strip_.take({{undo, undo}}, state_);
  ASSERT_EQ(keys().size(), 3u);
  EXPECT_EQ(keys()[1].time, 5);
  strip_.take({{redo}}, state_);
  EXPECT_NEAR(keys()[1].time, 6, 1e-9);
}

TEST_F(PathStripOfThreeKeys, NewKeysHoldTheTakeWhereTheyShall) {
  state_.time.seek(50);
  state_.keys_hold_take = true;
  state_.add_key();
  state_.add_key();
  EXPECT_EQ(keys()[3].take_time, 2);
  EXPECT_EQ(keys()[4].take_time, 2);
  EXPECT_EQ(keys()[4].time, 12) << "frozen for a second";
}

}  // namespace
}  // namespace floatstage::apps
