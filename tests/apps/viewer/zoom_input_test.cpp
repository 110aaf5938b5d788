#include "apps/viewer/detail/zoom_input.h"

#include <gtest/gtest.h>

#include "tests/apps/viewer/hands.h"

namespace floatstage::apps {
namespace {

using Kind = InputEvent::Kind;

// A root of 1000x500 px on a stage of 1000x500 px at (270, 0).
ZoomState state() {
  ZoomState s{.fit = PictureFit(1000, 500, 400)};
  s.fit.set_area(270, 0, 1000, 500);
  s.stage_x = 270, s.stage_width = 1000;
  return s;
}

TEST(ZoomInput, ZoomsToThePixelUnderTheCursor) {
  ZoomState s = state();
  const Eigen::Vector2d before = s.fit.to_photograph(900, 120);
  InputEvent wheel = at(Kind::Wheel, 900, 120);
  wheel.wheel = 3;
  for (int i = 0; i < 5; ++i) {
    take_zoom_input({&wheel, 1}, s);
    EXPECT_NEAR((s.fit.to_photograph(900, 120) - before).norm(), 0, 1e-9);
  }
  EXPECT_NEAR(s.fit.scale(), std::pow(1.15, 15), 1e-9);
  wheel.x = 100;  // over the panel
  const double scale = s.fit.scale();
  take_zoom_input({&wheel, 1}, s);
  EXPECT_EQ(s.fit.scale(), scale);
}

TEST(ZoomInput, PansByADragThatBeganOnTheStage) {
  ZoomState s = state();
  s.fit.look_at({500, 250}, 4);
  const std::vector<InputEvent> drag = {at(Kind::Press, 600, 300), at(Kind::Move, 640, 300),
                                        at(Kind::Release, 640, 320), at(Kind::Move, 900, 400)};
  take_zoom_input(drag, s);
  EXPECT_NEAR((s.fit.middle() - Eigen::Vector2d(490, 245)).norm(), 0, 1e-9);
  const std::vector<InputEvent> beside = {at(Kind::Press, 60, 300), at(Kind::Move, 640, 300)};
  take_zoom_input(beside, s);
  EXPECT_NEAR(s.fit.middle().x(), 490, 1e-9);
}

TEST(ZoomInput, MovesTheSplitWithControlAndTogglesWhatIsShownByKeys) {
  ZoomState s = state();
  const std::vector<InputEvent> keys = {key('X'), key('P'), key('G'), key('G'), key('P', true)};
  EXPECT_FALSE(take_zoom_input(keys, s).screenshot);
  EXPECT_TRUE(s.split);
  EXPECT_TRUE(s.provenance) << "a key that is held counts once";
  EXPECT_FALSE(s.graph);
  InputEvent press = at(Kind::Press, 770, 200);
  press.control = true;
  const std::vector<InputEvent> drag = {press, at(Kind::Move, 870, 200), at(Kind::Release, 870, 200)};
  take_zoom_input(drag, s);
  EXPECT_NEAR(s.split_at, 0.6, 1e-9);
  EXPECT_NEAR(s.fit.middle().x(), 500, 1e-9) << "the picture stays";
  const std::vector<InputEvent> more = {key('='), key('='), key(kKeyF12)};
  EXPECT_TRUE(take_zoom_input(more, s).screenshot);
  EXPECT_GT(s.fit.scale(), 1.5);
  const InputEvent home = key('H');
  take_zoom_input({&home, 1}, s);
  EXPECT_EQ(s.fit.scale(), 1);
}

}  // namespace
}  // namespace floatstage::apps
