// Somebody behind something that stands on the stage: two balls of one size beside one another, one of which
// is nobody.
#include "pipeline/occluders.h"

#include <cmath>
#include <optional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/camera.h"
#include "core/file.h"
#include "core/png.h"
#include "pipeline/process/process.h"
#include "recon/visual_hull.h"
#include "tests/support/small_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr int kWidth = 160, kHeight = 120;
constexpr double kRadius = 0.25;
const Vector3d kSomebody(0, 0, 0), kProp(0.55, 0, 0);

Rig ring(int cameras) {
  Rig rig;
  for (int k = 0; k < cameras; ++k) {
    const double turn = 2 * M_PI * k / cameras;
    RigCamera camera;
    camera.serial = "cam0" + std::to_string(k);
    camera.model.width = kWidth, camera.model.height = kHeight;
    camera.model.fx = camera.model.fy = kWidth;
    camera.model.cx = 0.5 * kWidth, camera.model.cy = 0.5 * kHeight;
    camera.cam_from_world = look_at({2.5 * std::cos(turn), 2.5 * std::sin(turn), 0.5 + 0.3 * (k % 2)},
                                    {0.2, 0, 0}, Vector3d::UnitZ());
    rig.cameras.push_back(camera);
  }
  return rig;
}

/// Metres along a pixel's ray to a ball.
std::optional<double> meets(const RigCamera& camera, int x, int y, const Vector3d& ball) {
  const Vector3d eye = camera.cam_from_world.center(),
                 ray = (camera.cam_from_world.rotation.inverse() *
                        unproject(camera.model, {x + 0.5, y + 0.5})->normalized())
                           .normalized();
  const double along = ray.dot(ball - eye), off = (ball - eye).squaredNorm() - along * along;
  if (off > kRadius * kRadius) return std::nullopt;
  return along - std::sqrt(kRadius * kRadius - off);
}

/// What of a ball a camera sees, with the other one before it or not.
Image picture_of(const RigCamera& camera, const Vector3d& ball, const std::optional<Vector3d>& other) {
  Image picture(kWidth, kHeight, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const auto here = meets(camera, x, y, ball);
      const auto before = other ? meets(camera, x, y, *other) : std::nullopt;
      *picture.at(x, y) = here && !(before && *before < *here) ? 255 : 0;
    }
  return picture;
}

class BehindAProp : public testing::Test {
 protected:
  std::vector<Matte> mattes(bool hidden) const {
    std::vector<Matte> all;
    for (const RigCamera& camera : rig_.cameras)
      all.push_back(
          make_matte({}, picture_of(camera, kSomebody, hidden ? std::optional(kProp) : std::nullopt)));
    return all;
  }
  /// Of so many cameras, from the first on.
  void draw_masks(std::size_t count) const {
    fs::create_directories(folder_ / "occluders");
    for (std::size_t c = 0; c < count; ++c)
      ASSERT_THAT(save_png(picture_of(rig_.cameras[c], kProp, {}), mask(c)), IsOk());
  }
  fs::path mask(std::size_t camera) const {
    return folder_ / "occluders" / (rig_.cameras[camera].serial + ".png");
  }
  Result<Occluders> load() const { return load_occluders(TakeLayout(folder_.path()), rig_); }
  std::vector<Matte> silhouettes(recon::Props::Within* within = nullptr) const {
    return *load()->props.silhouettes(rig_, mattes(true), 2, within);
  }
  double hull_of(const std::vector<Matte>& mattes) const {
    recon::HullOptions options;
    options.voting = recon::HullVoting::Strict;
    return recon::visual_hull(rig_, mattes, options)->volume;
  }

  TempFolder folder_;
  Rig rig_ = ring(8);
};

TEST_F(BehindAProp, NothingOfSomebodyIsLost) {
  const double whole = hull_of(mattes(false));
  EXPECT_LT(hull_of(mattes(true)), 0.9 * whole) << "the prop hides nothing that matters";
  draw_masks(8);
  EXPECT_NEAR(hull_of(silhouettes()), whole, 0.08 * whole);
}

TEST_F(BehindAProp, OneCamerasMaskIsEnoughWhereThatCameraIsTheOneThatLacks) {
  std::vector<Matte> lacking = mattes(false);
  lacking[0] = mattes(true)[0];
  const double whole = hull_of(mattes(false));
  EXPECT_LT(hull_of(lacking), 0.95 * whole);
  draw_masks(1);
  EXPECT_NEAR(hull_of(*load()->props.silhouettes(rig_, lacking, 2)), whole, 0.03 * whole);
}

TEST_F(BehindAProp, WhoStandsBeforeItGrowsByNothing) {
  draw_masks(8);
  // From the far side somebody covers the prop's middle; what is seen of it there is seen, and denies.
  const Image alone = to_image(mattes(false)[4]);
  const Image seen = to_image(silhouettes()[4]);
  int surplus = 0, subject = 0;
  for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
    subject += alone.pixels[i] != 0;
    surplus += seen.pixels[i] != 0 && alone.pixels[i] == 0;
  }
  EXPECT_LT(surplus, 0.1 * subject) << "more than an outline of a pixel";
}

TEST_F(BehindAProp, ItIsSaidWhereSomebodyIsWithinIt) {
  draw_masks(8);
  recon::Props::Within within;
  silhouettes(&within);
  EXPECT_LT(within.share, 0.01);
  // A shadow on the prop that five cameras took for somebody.
  std::vector<Matte> shadowed;
  for (std::size_t c = 0; c < rig_.cameras.size(); ++c) {
    Image all = to_image(mattes(true)[c]);
    const Image prop = picture_of(rig_.cameras[c], kProp, kSomebody);
    for (std::size_t i = 0; c >= 3 && i < all.pixels.size(); ++i)
      all.pixels[i] = std::max(all.pixels[i], prop.pixels[i]);
    shadowed.push_back(make_matte({}, all));
  }
  ASSERT_THAT(load()->props.silhouettes(rig_, shadowed, 2, &within), IsOk());
  EXPECT_GT(within.share, 0.1);
  EXPECT_GE(within.camera, 3);
}

TEST_F(BehindAProp, WithoutMasksMattesStayAsTheyAre) {
  const std::vector<Matte> given = mattes(true);
  for (const bool empty_folder : {false, true}) {
    if (empty_folder) fs::create_directories(folder_ / "occluders");
    const Result<Occluders> none = load();
    ASSERT_THAT(none, IsOk());
    EXPECT_FALSE(none->props.any());
    EXPECT_EQ(none->hash, "");
    const std::vector<Matte> same = *none->props.silhouettes(rig_, given, 2);
    for (std::size_t c = 0; c < given.size(); ++c) EXPECT_EQ(same[c].alpha, given[c].alpha);
  }
}

TEST_F(BehindAProp, WhoIsNotThereIsNotBehindIt) {
  draw_masks(8);
  std::vector<Matte> nobody(8, make_matte({}, Image(kWidth, kHeight, 1)));
  nobody[3] = {};
  const std::vector<Matte> seen = *load()->props.silhouettes(rig_, nobody, 2);
  for (std::size_t c = 0; c < 8; ++c) EXPECT_EQ(coverage(seen[c]), 0) << c;
  EXPECT_TRUE(seen[3].empty());
}

TEST_F(BehindAProp, TheSameAtAnyNumberOfThreads) {
  draw_masks(8);
  const std::vector<Matte> one = *load()->props.silhouettes(rig_, mattes(true), 1),
                           three = *load()->props.silhouettes(rig_, mattes(true), 3);
  for (std::size_t c = 0; c < 8; ++c) EXPECT_EQ(to_image(one[c]), to_image(three[c]));
}

TEST_F(BehindAProp, OpacityOfAPaintedPictureIsAMask) {
  const Image mask = picture_of(rig_.cameras[0], kProp, {});
  Image painted(kWidth, kHeight, 4);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) painted.at(x, y)[3] = *mask.at(x, y);
  draw_masks(1);
  const Image grey = to_image(silhouettes()[0]);
  ASSERT_THAT(save_png(painted, this->mask(0)), IsOk());
  EXPECT_EQ(to_image(silhouettes()[0]), grey);
}

TEST_F(BehindAProp, MasksOfNothingAreRefused) {
  draw_masks(2);
  ASSERT_THAT(save_png(Image(80, 60, 1), mask(1)), IsOk());
  EXPECT_THAT(load(), FailsWith(ErrorCode::BadData, "camera 'cam01' has pictures of 160x120"));
  fs::remove(mask(1));
  folder_.write("occluders/cam77.png", "");
  EXPECT_THAT(load(), FailsWith(ErrorCode::BadData, "cam77.png is of no camera of this take"));
  fs::remove(folder_ / "occluders/cam77.png");
  folder_.write("occluders/cam01.png", "no picture");
  EXPECT_THAT(load(), FailsWith(ErrorCode::BadData, "cam01.png"));
}

TEST(ProcessBehindProps, MakesMeshesAnewWhereMasksHaveChanged) {
  TempFolder folder;
  ProcessOptions options{.take = small_take(folder, 1), .matte = "chroma", .hull = recon::HullOptions{}};
  ASSERT_THAT(process_take(options), IsOk());
  EXPECT_EQ(process_take(options)->meshes.kept, 1);
  fs::create_directories(options.take / "occluders");
  Image mask(160, 120, 1);
  std::fill(mask.pixels.begin(), mask.pixels.begin() + 160 * 40, std::uint8_t{255});
  ASSERT_THAT(save_png(mask, options.take / "occluders/cam02.png"), IsOk());
  EXPECT_EQ(process_take(options)->meshes.made, 1);
  EXPECT_EQ(process_take(options)->meshes.kept, 1);
  fs::remove_all(options.take / "occluders");
  EXPECT_EQ(process_take(options)->meshes.made, 1);
}

}  // namespace
}  // namespace floatstage::pipeline
