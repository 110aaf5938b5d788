#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "capture/take.h"
#include "core/file.h"
#include "core/synthetic/synthetic_studio.h"
#include "studio/node/pre_roll.h"
#include "studio/node/sync_watch.h"
#include "studio/node/take_list.h"
#include "tests/support/matchers.h"
#include "tests/support/temp_folder.h"

namespace floatstage::studio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Frame grey_frame(int camera, std::uint64_t sequence, std::int64_t ns, int width = 4, int height = 4) {
  Image image(width, height, 1);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<std::uint8_t>(i);
  FrameInfo info;
  info.camera = camera;
  info.sequence = sequence;
  info.exposure_start = {ns};
  return make_frame(info, image);
}

TEST(PreRoll, KeepsTheLastSecondsAndNoMorePicturesThanAgreed) {
  PreRoll ring(milliseconds(100), 5);
  for (std::int64_t i = 0; i < 20; ++i)
    ring.push(grey_frame(0, static_cast<std::uint64_t>(i), i * 40'000'000), 7);
  EXPECT_THAT(ring.times(),
              ElementsAre(Timestamp{680'000'000}, Timestamp{720'000'000}, Timestamp{760'000'000}));
  for (std::int64_t i = 20; i < 40; ++i)
    ring.push(grey_frame(0, static_cast<std::uint64_t>(i), 760'000'000 + i), 7);
  EXPECT_EQ(ring.times().size(), 5u);
  const auto kept = ring.take();
  EXPECT_EQ(kept.back().frame.info.sequence, 39u);
  EXPECT_EQ(kept.back().failed, 7u);
  EXPECT_THAT(ring.times(), IsEmpty());
}

TEST(PreRoll, HoldsNoBufferOfTheDevice) {
  PreRoll ring(milliseconds(100), 5);
  const Frame lent = grey_frame(0, 0, 0);
  ring.push(lent, 0);
  EXPECT_EQ(lent.pixels.use_count(), 1);
}

std::vector<Timestamp> at_ms(std::initializer_list<std::int64_t> times) {
  std::vector<Timestamp> list;
  for (const std::int64_t t : times) list.push_back({t * 1'000'000});
  return list;
}

TEST(CompleteInstant, IsTheFirstOneThatEveryCameraSaw) {
  const std::vector<std::vector<Timestamp>> times = {at_ms({0, 40, 80, 120}), at_ms({1, 81, 121})};
  EXPECT_EQ(complete_instant(times, {0}, milliseconds(40)), Timestamp{});
  EXPECT_EQ(complete_instant(times, {30'000'000}, milliseconds(40)), Timestamp{80'000'000});
  EXPECT_EQ(complete_instant(times, {500'000'000}, milliseconds(40)), Timestamp{120'000'000})
      << "the last one";
}

TEST(CompleteInstant, DoesNotWaitForACameraThatIsGone) {
  EXPECT_EQ(complete_instant({{}, at_ms({0, 40})}, {20'000'000}, milliseconds(40)), Timestamp{40'000'000});
  EXPECT_EQ(complete_instant({{}, {}}, {0}, milliseconds(40)), std::nullopt);
  EXPECT_EQ(complete_instant({at_ms({0}), at_ms({900})}, {0}, milliseconds(40)), std::nullopt);
}

TEST(SyncWatch, ComplainsAboutACameraWhoseClockIsOff) {
  auto watch = SyncWatch::make({"good", "fine", "off"}, 25, {1.0, 0});
  ASSERT_THAT(watch, IsOk());
  EXPECT_FALSE((*watch)->last().any);
  for (std::int64_t i = 0; i < 120; ++i) {
    const std::int64_t t = 1'000'000'000 + i * 40'000'000;
    for (int camera = 0; camera < 3; ++camera)
      (*watch)->push(
          grey_frame(camera, static_cast<std::uint64_t>(i), t + (camera == 2 ? 12'000'000 : 0)).info);
    (*watch)->look({t + 30'000'000});
  }
  const SyncWatch::Seen seen = (*watch)->last();
  EXPECT_TRUE(seen.any);
  EXPECT_THAT(seen.complaints, ElementsAre(HasSubstr("camera 'off'")));
  EXPECT_NEAR(seen.spread_max_ms, 0, 1e-6) << "what is out of tolerance is in no set";
}

TEST(TakeList, NamesTheTakesNewestFirstAndSkipsWhatIsNone) {
  const TempFolder folder;
  std::filesystem::create_directories(folder / "a/not-a-take");
  folder.write("notes.txt", "x");
  for (const char* name : {"20260101T000000Z-old", "20260102T000000Z-new"}) {
    auto writer = capture::TakeWriter::create(folder / name, synthetic_rig({}), {});
    ASSERT_THAT(writer, IsOk());
    if (std::string(name).ends_with("old")) {
      ASSERT_THAT((*writer)->finish(), IsOk());
      ASSERT_THAT(write_file(folder / name / "quality.json", R"({"verdict": "PASS"})"), IsOk());
    }
  }
  const std::vector<NodeTake> takes = list_takes(folder.path(), 10);
  ASSERT_EQ(takes.size(), 2u);
  EXPECT_EQ(takes[0].name, "20260102T000000Z-new");
  EXPECT_FALSE(takes[0].complete);
  EXPECT_EQ(takes[0].verdict, "");
  EXPECT_TRUE(takes[1].complete);
  EXPECT_EQ(takes[1].verdict, "PASS");
  EXPECT_EQ(list_takes(folder.path(), 1).size(), 1u);
  EXPECT_THAT(list_takes(folder / "nowhere", 5), IsEmpty());
}

}  // namespace
}  // namespace floatstage::studio
