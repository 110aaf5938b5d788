// A program of its own: it replaces operator new to count.

#include <gtest/gtest.h>

#include "matting/keyers/live_key.h"
#include "matting/keyers/plate_corrected_keyer.h"
#include "tests/matting/pictures.h"
#include "tests/support/counted_new.h"

namespace floatstage::matting {
namespace {

void expect_no_allocations_once_warm(const std::string& spec, bool corrected = false,
                                     const CastShade* shade = nullptr) {
  Scene large, small;
  large.radius = 50;
  large.noise = small.noise = 6;
  const std::vector<Image> plates = {empty_stage(large), empty_stage(large, 7)};
  auto keyer = std::move(*make_keyer(spec, plates));
  if (corrected) keyer = std::move(*corrected_by_plate(std::move(keyer), plates));
  LiveKey live(*keyer);
  ASSERT_TRUE(live.fast());
  const Frame frames[] = {make_frame({}, photograph(large)), make_frame({}, photograph(small))};
  Matte held;  // one picture is on its way while the next is keyed
  for (int round = 0; round < 6; ++round) {
    const long before = test::allocations;
    held = *live.key(frames[round % 2], shade);
    const long during = test::allocations - before;
    if (round == 0) {
      EXPECT_GT(during, 0) << "the counter counts";
    }
    if (round >= 3) {
      EXPECT_EQ(during, 0) << spec << ", round " << round;
    }
  }
}

TEST(LiveKey, AllocatesNothingOnceItHasSeenItsSubjectAndGotItsMattesBack) {
  for (const char* spec : {"chroma:#28783c", "plate", "difference"}) expect_no_allocations_once_warm(spec);
  expect_no_allocations_once_warm("chroma:#28783c", true);
  CastShade shade{.width = 40, .height = 30, .mask = {}, .left = {}, .shadows = 200};
  shade.left.assign(1200, {0.5F, 0.6F, 0.7F});
  shade.mask.assign(1200, 0);
  std::fill_n(shade.mask.begin() + 1000, 200, 255);
  expect_no_allocations_once_warm("plate", false, &shade);
}

// Three cameras at one place, and half as much light.
TEST(CastShadows, AllocateNothingOnceTheyHaveSeenAsMuch) {
  const Image stage = empty_stage({});
  Image picture = stage;
  for (std::uint8_t& v : picture.pixels) v /= 2;
  Rig rig;
  for (int i = 0; i < 3; ++i) {
    RigCamera camera;
    camera.serial = std::string(1, static_cast<char>('a' + i));
    camera.model = {.width = 160, .height = 120, .fx = 100, .fy = 100, .cx = 80, .cy = 60, .lens = {}};
    camera.cam_from_world = look_at({2, 0.01 * i, 1.5}, {0, 0, 0.5}, Eigen::Vector3d::UnitZ());
    rig.cameras.push_back(camera);
  }
  CastShadows shadows(rig);
  const std::vector<BeforeStage> before(3, BeforeStage{&picture, &stage});
  for (int round = 0; round < 3; ++round) {
    const long so_far = test::allocations;
    const bool any = shadows.find(before, 1)[0].any();
    const long during = test::allocations - so_far;
    EXPECT_TRUE(any) << "else nothing was looked for";
    if (round == 0) {
      EXPECT_GT(during, 0) << "the counter counts";
    } else {
      EXPECT_EQ(during, 0);
    }
  }
}

}  // namespace
}  // namespace floatstage::matting
