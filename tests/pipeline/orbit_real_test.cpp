#include <algorithm>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/mesh_io.h"
#include "pipeline/import/import.h"
#include "pipeline/orbit.h"
#include "pipeline/process/process.h"
#include "recon/mesh/mesh_mask.h"
#include "tests/support/matchers.h"
#include "tests/support/real_data.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// What the pictures of an orbit show of the subject: the hull's mask from every view of the walk.
class AnOrbitOf : public testing::Test {
 protected:
  void process(const std::string& matte) {
    recon::HullOptions hull;
    hull.method = recon::HullMethod::Octree;
    ASSERT_THAT(process_take({.take = folder_ / "take", .matte = matte, .hull = hull}), IsOk());
  }
  void import(const std::string& format, const fs::path& data, const std::string& matte,
              const std::string& mattes = "") {
    ImportOptions options;
    options.calibration = {.format = format, .path = data};
    if (!mattes.empty()) {
      options.calibration.metres_per_unit = 1;
      options.mattes = data / mattes;
      options.frames = {.first = 12, .end = 37, .step = 12};
    }
    options.out = folder_ / "take";
    ASSERT_THAT(import_take(options), IsOk());
    process(matte);
  }

  /// Upright is what nobody can measure on a mask: the axis is told by the caller.
  void holds_the_subject(const Eigen::Vector3d& up) {
    constexpr int kWidth = 320, kHeight = 240, kViews = 24;
    const auto take = std::move(*capture::TakeReader::open(folder_ / "take"));
    const Result<Subject> subject = find_subject(*take);
    ASSERT_THAT(subject, IsOk());
    const Orbit orbit = orbit_around(take->rig(), *subject, {});
    EXPECT_GT(orbit.axis.dot(up), std::cos(5 * std::numbers::pi / 180)) << orbit.axis.transpose();
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (int i = 0; i < kViews; ++i) {
      const int frame = i * take->frame_count() / kViews;
      const double time = orbit.path.duration() * i / kViews;
      const View view = view_of(sample(orbit.path, time), kWidth, kHeight, subject->box);
      const Matte mask = recon::mesh_mask({"view", view.model, view.view_from_world, {}},
                                          *load_ply(take->layout().mesh(frame)));
      int top = kHeight, bottom = -1, left = kWidth, right = -1;
      Eigen::Vector2d sum = Eigen::Vector2d::Zero();
      double count = 0;
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x)
          if (mask.row(y)[x] >= 128) {
            top = std::min(top, y), bottom = std::max(bottom, y);
            left = std::min(left, x), right = std::max(right, x);
            sum += Eigen::Vector2d(x + 0.5, y + 0.5), ++count;
          }
      ASSERT_GT(count, 0) << "view " << i << " shows nothing";
      middle += sum / count / kViews;
      EXPECT_GE(top, 0.08 * kHeight) << "view " << i;
      EXPECT_LE(bottom, 0.92 * kHeight) << "view " << i;
      EXPECT_GE(left, 0.08 * kWidth) << "view " << i;
      EXPECT_LE(right, 0.92 * kWidth) << "view " << i;
    }
    EXPECT_NEAR(middle.x() / kWidth, 0.5, 0.05);
    EXPECT_NEAR(middle.y() / kHeight, 0.5, 0.05);
  }

  TempFolder folder_;
};

TEST_F(AnOrbitOf, TheTempleRingStandsUprightThoughItsPicturesLieOnTheirSide) {
  const fs::path data = real_data("middlebury-temple-ring");
  FLOATSTAGE_NEEDS_DATA(data);
  import("middlebury", data, "luminance:12");
  holds_the_subject(Eigen::Vector3d::UnitY());
}

TEST_F(AnOrbitOf, TheTempleSparseRingStandsUpright) {
  const fs::path data = real_data("middlebury-temple-sparse-ring");
  FLOATSTAGE_NEEDS_DATA(data);
  import("middlebury", data, "luminance:12");
  holds_the_subject(Eigen::Vector3d::UnitY());
}

TEST_F(AnOrbitOf, TheGreenDomeStandsUpright) {
  const fs::path data = real_data("green-dome");
  FLOATSTAGE_NEEDS_DATA(data);
  import("dome", data, "chroma");
  holds_the_subject(mean_up(std::move(*capture::TakeReader::open(folder_ / "take"))->rig()));
}

TEST_F(AnOrbitOf, TwoPlayersAndABallStandUprightThroughTheThrow) {
  const fs::path data = real_data("dynamic-basketball");
  FLOATSTAGE_NEEDS_DATA(data);
  import("dome", data, "given", "masks");
  holds_the_subject(-Eigen::Vector3d::UnitY());
}

TEST_F(AnOrbitOf, TheStudioOfTheDemoStandsUpright) {
  small_take(folder_);
  process("chroma");
  holds_the_subject(Eigen::Vector3d::UnitZ());
}

}  // namespace
}  // namespace floatstage::pipeline
