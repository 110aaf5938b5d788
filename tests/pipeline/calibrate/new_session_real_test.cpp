// `calibrate new` on every set that lies beside the checkout: what it writes is read again and runs unedited.

#include <cstdio>

#include <gtest/gtest.h>

#include "core/file.h"
#include "pipeline/calibrate/new_session.h"
#include "pipeline/calibrate/scene.h"
#include "pipeline/calibrate/session_observations.h"
#include "tests/support/long_tests.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/temp_folder.h"

namespace floatstage::pipeline {
namespace {

struct GivenSet {
  const char* name;
  std::size_t cameras;
  bool quick;  ///< in the short form, too
};

void PrintTo(const GivenSet& set, std::ostream* out) { *out << set.name; }

class NewSessionOfASet : public testing::TestWithParam<GivenSet> {};
INSTANTIATE_TEST_SUITE_P(
    Sets, NewSessionOfASet,
    testing::Values(GivenSet{"middlebury-temple-sparse-ring", 16, true},
                    GivenSet{"pose2sim-balancing", 4, true}, GivenSet{"middlebury-temple-ring", 19, false},
                    GivenSet{"middlebury-dino-sparse-ring", 16, true}, GivenSet{"lightfield-shop", 81, false},
                    GivenSet{"caliscope-4cam", 4, false}, GivenSet{"green-dome", 20, false},
                    GivenSet{"green-dome-wd", 20, false}, GivenSet{"dynamic-basketball", 31, false}),
    [](const auto& given) {
      std::string name = given.param.name;
      std::erase(name, '-');
      return name;
    });

TEST_P(NewSessionOfASet, RunsUnedited) {
  const GivenSet set = GetParam();
  FLOATSTAGE_LONG_FORM(!set.quick);
  FLOATSTAGE_NEEDS_DATA(real_data(set.name));
  const TempFolder folder;
  const Result<NewSession> drafted = draft_session(real_data(set.name), folder.path(), {});
  ASSERT_THAT(drafted, IsOk());
  EXPECT_EQ(drafted->cameras, set.cameras);
  ASSERT_THAT(write_file(folder / "session.toml", drafted->toml), IsOk());
  const Result<Session> session = load_session(folder / "session.toml");
  ASSERT_THAT(session, IsOk());
  EXPECT_EQ(session->cameras.size(), set.cameras);
  Result<SessionObservations> seen = collect(*session, "", 0);
  ASSERT_THAT(seen, IsOk());
  if (session->markerless) {
    ASSERT_THAT(add_scene(*session, folder / "colmap", 0, nullptr, *seen), IsOk());
  }
  const Result<calib::Calibration> solved = calib::calibrate(seen->observations, session->options);
  ASSERT_THAT(solved, IsOk());
  EXPECT_EQ(solved->rig.cameras.size(), set.cameras);
  for (const calib::CameraQuality& c : solved->cameras)
    std::printf("%s: %d points, %s px\n", c.serial.c_str(), c.points, to_words(c.rms_px, 2).c_str());
}

TEST(NewSessionOfARealClip, WhoseCameraStaysSaysSo) {
  FLOATSTAGE_NEEDS_DATA(real_data("clip-two-persons"));
  const TempFolder folder;
  EXPECT_THAT(draft_session(real_data("clip-two-persons"), folder.path(), {}),
              FailsWith(ErrorCode::BadData, "its camera hardly left its place"));
}

TEST(NewSessionOfPicturesOfNothingInCommon, IsRefused) {
  for (const char* set : {"detail", "flow", "lemur-pymatting", "levin-dandelion", "stills-composition"}) {
    FLOATSTAGE_NEEDS_DATA(real_data(set));
    const TempFolder folder;
    EXPECT_THAT(draft_session(real_data(set), folder.path(), {}),
                FailsWith(ErrorCode::BadData, "show no common scene"))
        << set;
  }
}

TEST(NewSessionOfMattesAlone, IsRefusedAndSaysWhatWasLeftOut) {
  FLOATSTAGE_NEEDS_DATA(real_data("vacancy-bunny"));
  const TempFolder folder;
  EXPECT_THAT(draft_session(real_data("vacancy-bunny"), folder.path(), {}),
              FailsWith(ErrorCode::NotFound, "6 pictures in " + real_data("vacancy-bunny").string() +
                                                 "/data are mattes, by their names"));
}

}  // namespace
}  // namespace floatstage::pipeline
