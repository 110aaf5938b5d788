// Are stated sigmas true of captures that people made?

#include <cmath>
#include <cstdio>

#include <gtest/gtest.h>

#include "core/text.h"
#include "pipeline/calibrate/session_observations.h"
#include "tests/calib/halves.h"
#include "tests/support/matchers.h"
#include "tests/support/places.h"
#include "tests/support/real_data.h"

namespace floatstage::pipeline {
namespace {

using calib::HalvesRatio;
using calib::Observations;

Result<Observations> observations_of(const char* name) {
  const Result<Session> session = load_session(source_folder() / "config/calibration" / name);
  if (!session) return forward(session);
  Result<SessionObservations> seen = collect(*session, "", 0);
  if (!seen) return forward(seen);
  return std::move(seen->observations);
}

// Over several captures, as over several splits of one: root of the mean square.
struct Together {
  double apart = 0, stated = 0;
  void add(const char* name, const HalvesRatio& r) {
    std::printf("%s: %.3f (%.3f px apart, %.3f px stated, %d splits)\n", name, r.ratio, r.apart_px,
                r.stated_px, r.splits);
    apart += r.apart_px * r.apart_px;
    stated += r.stated_px * r.stated_px;
  }
  void expect_as_stated() const {
    const double ratio = std::sqrt(apart / stated);
    std::printf("together %.3f\n", ratio);
    EXPECT_GE(ratio, 0.8);
    EXPECT_LE(ratio, 1.25);
  }
};

TEST(HalvesOfRealCaptures, OfAStereoPairsPhotographsAreApartAsStated) {
  const Result<Observations> all =
      calib::load_observations(source_folder() / "tests/pipeline/calibrate/stereo-corners.json");
  ASSERT_THAT(all, IsOk());
  Together t;
  t.add("stereo", calib::halves_ratio(*all, 12, 13, 1));
  t.expect_as_stated();
}

TEST(HalvesOfRealCaptures, OfAWavedBoardsVideosAreApartAsStated) {
  FLOATSTAGE_NEEDS_DATA(real_data("caliscope-4cam"));
  const Result<Observations> all = observations_of("caliscope-4cam.toml");
  ASSERT_THAT(all, IsOk());
  Together t;
  t.add("caliscope", calib::halves_ratio(*all, 6, 8, 1, true));
  t.expect_as_stated();
}

// Six or seven photographs a camera: one camera's ratio alone is chance (0.7 to 1.5), four together are not.
TEST(HalvesOfRealCaptures, OfEachCamerasOwnPhotographsAreApartAsStated) {
  FLOATSTAGE_NEEDS_DATA(real_data("pose2sim-balancing"));
  const Result<Observations> all = observations_of("pose2sim-balancing.toml");
  ASSERT_THAT(all, IsOk());
  Together t;
  for (int c = 0; c < static_cast<int>(all->cameras.size()); ++c) {
    Observations own = calib::only_camera(*all, c);
    own.cameras[0].pose = calib::Prior::Unknown;
    const int photographs = static_cast<int>(calib::frames_of(own).size());
    t.add(all->cameras[static_cast<std::size_t>(c)].serial.c_str(),
          calib::halves_ratio(own, 12, photographs, 1));
  }
  t.expect_as_stated();
}

}  // namespace
}  // namespace floatstage::pipeline
