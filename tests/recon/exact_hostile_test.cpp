// Mattes and rigs that no studio should produce: the exact method must return a closed mesh or a clear
// sentence, soon.

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/random.h"
#include "recon/mesh/mesh_check.h"
#include "recon/visual_hull.h"
#include "tests/support/analytic_shapes.h"
#include "tests/support/matchers.h"

namespace floatstage::recon {
namespace {

using Eigen::Vector3d;

constexpr int kWidth = 72, kHeight = 54;

Rig small_ring(int cameras, double height = 0.6) {
  return shapes::ring_rig({.cameras = cameras, .width = kWidth, .height = kHeight, .focal = 70}, height);
}

Matte drawn(const auto& alpha) {
  Image image(kWidth, kHeight, 1);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) *image.at(x, y) = static_cast<std::uint8_t>(alpha(x, y));
  }
  return make_matte({}, image);
}

HullOptions within_two_metres(double tolerance = 0.5) {
  HullOptions options;
  options.contour_tolerance = tolerance;
  options.volume = Eigen::AlignedBox3d(Vector3d(-1, -1, -1), Vector3d(1, 1, 1));
  return options;
}

/// Closed, or an error that is about the input. The octree may not have helped.
void expect_sound(const Rig& rig, const std::vector<Matte>& mattes, const HullOptions& options,
                  const std::string& what) {
  const Result<HullReport> hull = visual_hull(rig, mattes, options);
  if (!hull) {
    EXPECT_EQ(hull.error().code, ErrorCode::BadData) << what << ": " << hull.error().message;
    return;
  }
  EXPECT_EQ(hull->voxel, 0) << what << ": the octree had to help";
  const MeshCheck check = check_mesh(hull->mesh);
  EXPECT_TRUE(check.watertight && check.manifold && check.oriented) << what << ": " << check.summary();
}

TEST(HostileMattes, OfNoiseGiveClosedHulls) {
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    Random random(seed);
    const double density = 0.3 + 0.06 * static_cast<double>(seed);
    std::vector<Matte> mattes;
    for (int c = 0; c < 3; ++c) {
      mattes.push_back(drawn([&](int x, int y) {
        const bool coarse = ((x / 6) * 7919 + (y / 6) * 104729 + c) % 5 != 0;
        return coarse && random.uniform() < density ? 128 + random.next() % 128 : random.next() % 128;
      }));
    }
    expect_sound(small_ring(3), mattes, within_two_metres(1), "seed " + std::to_string(seed));
  }
}

TEST(HostileMattes, OfNoiseInEveryPixelOfEveryCameraCostABoundedAmountOfWork) {
  const Rig rig = shapes::ring_rig({.cameras = 8, .width = 1024, .height = 768, .focal = 900}, 0.6);
  for (const double density : {0.5, 0.62, 0.97}) {
    std::vector<Matte> mattes;
    Random random(3);
    for (int c = 0; c < 8; ++c) {
      Image image(1024, 768, 1);
      for (std::uint8_t& alpha : image.pixels) alpha = random.uniform() < density ? 255 : 0;
      mattes.push_back(make_matte({}, image));
    }
    HullOptions options = within_two_metres();
    options.quality = false;
    const Result<HullReport> hull = visual_hull(rig, mattes, options);
    if (!hull) {
      EXPECT_EQ(hull.error().code, ErrorCode::BadData);
      EXPECT_THAT(hull.error().message, testing::HasSubstr("noise"));
      continue;
    }
    EXPECT_EQ(hull->voxel, 0) << "the octree had to help";
    EXPECT_LE(hull->work.points, 8 * 20000);
    EXPECT_LE(hull->work.hits, 8'000'000);
    EXPECT_LE(hull->work.lines, 60'000'000);
    EXPECT_LE(hull->work.relations, 400'000'000);
    EXPECT_THAT(hull->remarks, testing::Contains(testing::HasSubstr("its matte is"))) << density;
  }
}

TEST(HostileMattes, WithPinchesHolesAtTheOutlineAndBorderCutsGiveClosedHulls) {
  const auto disc = [](double x, double y, double r) {
    return std::hypot(x - kWidth / 2.0, y - kHeight / 2.0) < r;
  };
  const std::vector<std::pair<const char*, Matte>> kinds = {
      {"checkerboard",
       drawn([&](int x, int y) { return disc(x, y, 20) && ((x / 4 + y / 4) % 2 == 0) ? 255 : 0; })},
      {"single pixels", drawn([&](int x, int y) { return x % 9 == 4 && y % 9 == 4 ? 255 : 0; })},
      {"one pixel", drawn([&](int x, int y) { return x == 36 && y == 27 ? 255 : 0; })},
      {"pinched", drawn([&](int x, int y) { return (x < 36) == (y < 27) && disc(x, y, 20) ? 255 : 0; })},
      {"hole at the outline", drawn([&](int x, int y) {
         return disc(x, y, 20) && !(x > 50 && x < 55 && y == 27) && !(x == 40 && y > 9 && y < 30) ? 255 : 0;
       })},
      {"one-pixel ring", drawn([&](int x, int y) { return disc(x, y, 20) && !disc(x, y, 19) ? 255 : 0; })},
      {"comb", drawn([&](int x, int y) { return disc(x, y, 22) && x % 2 == 0 ? 255 : 0; })},
      {"left cut", drawn([&](int x, int y) { return x < 40 && y > 10 && y < 40 ? 255 : 0; })},
      {"all but a pixel", drawn([&](int x, int y) { return x == 30 && y == 20 ? 0 : 255; })},
      {"frame", drawn([&](int x, int y) {
         return x == 0 || y == 0 || x == kWidth - 1 || y == kHeight - 1 ? 255 : 0;
       })},
      {"faint edge", drawn([&](int x, int y) { return disc(x, y, 20) ? 128 : 127; })},
      {"nothing", drawn([](int, int) { return 0; })},
      {"everything", drawn([](int, int) { return 255; })},
  };
  const Rig rig = small_ring(4);
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    for (const double tolerance : {0.0, 0.5, 2.0}) {
      const std::vector<Matte> same(4, kinds[k].second);
      expect_sound(rig, same, within_two_metres(tolerance), kinds[k].first);
      std::vector<Matte> mixed;
      for (std::size_t c = 0; c < 4; ++c) mixed.push_back(kinds[(k + c) % kinds.size()].second);
      expect_sound(rig, mixed, within_two_metres(tolerance), std::string(kinds[k].first) + " and others");
      HullOptions unbounded;
      unbounded.contour_tolerance = tolerance;
      expect_sound(rig, mixed, unbounded, std::string(kinds[k].first) + " and others, without a volume");
    }
  }
}

TEST(HostileRigs, WithCamerasInOnePlaceOrOnOneLineGiveClosedHulls) {
  const auto shape =
      shapes::both(shapes::sphere({0, 0, 0}, 0.4), shapes::box({0.2, 0.1, 0.3}, {0.3, 0.3, 0.3}));
  Rig twice = small_ring(3);
  twice.cameras.push_back(twice.cameras[0]);
  twice.cameras.back().serial = "again";
  expect_sound(twice, shapes::render_mattes(twice, shape), within_two_metres(), "a camera twice");

  for (const double height : {0.0, 1e-9}) {
    const Rig plane = small_ring(8, height);
    expect_sound(plane, shapes::render_mattes(plane, shape), within_two_metres(), "a coplanar ring");
    const Rig opposite = small_ring(2, height);
    expect_sound(opposite, shapes::render_mattes(opposite, shape), within_two_metres(),
                 "two opposite cameras");
  }
  Rig line = small_ring(3);
  for (std::size_t c = 0; c < 3; ++c) {
    line.cameras[c].cam_from_world =
        look_at({static_cast<double>(c) - 1, -3, 0.0}, {0, 0, 0}, Vector3d::UnitZ());
  }
  expect_sound(line, shapes::render_mattes(line, shape), within_two_metres(), "three cameras on a line");
}

TEST(HostileRigs, OfAnyKindGiveClosedHulls) {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    Random random(seed);
    Rig rig = small_ring(2 + static_cast<int>(seed % 5));
    const auto shape =
        shapes::both(shapes::torus({0, 0, 0}, 0.4, 0.12), shapes::box({0, 0, 0.2}, {0.2, 0.2, 0.7}));
    for (RigCamera& camera : rig.cameras) {
      const Vector3d eye(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-2, 2));
      const Vector3d target(random.normal() * 0.3, random.normal() * 0.3, random.normal() * 0.3);
      camera.cam_from_world = look_at(eye, target, Vector3d(0.1, 0.2, 1));
      camera.model.fx *= random.uniform(0.4, 2);
      if (seed % 3 == 0) camera.model.lens = BrownConrady{random.uniform(-0.2, 0.1), 0, 0, 0, 0};
    }
    expect_sound(rig, shapes::render_mattes(rig, shape), within_two_metres(), "seed " + std::to_string(seed));
  }
}

TEST(HullVoting, OfSomeCamerasIsClosedAndLargerThanOfAll) {
  const Rig rig = small_ring(7);
  const auto mattes = shapes::render_mattes(rig, shapes::torus({0, 0, 0}, 0.4, 0.15));
  double last = 0;
  for (const int votes : {7, 6, 5}) {
    HullOptions options = within_two_metres();
    options.voting = HullVoting::MofN;
    options.votes = votes;
    expect_sound(rig, mattes, options, std::to_string(votes) + " of 7");
    const Result<HullReport> hull = visual_hull(rig, mattes, options);
    ASSERT_THAT(hull, IsOk());
    EXPECT_GT(hull->volume, last);
    last = hull->volume;
  }
}

TEST(HullVoting, LeavesOutAndNamesTheOneMatteThatLacksAPart) {
  const Rig rig = shapes::sphere_rig({.cameras = 10, .focal = 180});
  const auto shape = shapes::both(shapes::sphere({0, 0, 0.3}, 0.25), shapes::sphere({0, 0, -0.2}, 0.35));
  std::vector<Matte> mattes = shapes::render_mattes(rig, shape);
  HullOptions options;
  options.voting = HullVoting::Auto;
  const Result<HullReport> clean = visual_hull(rig, mattes, options);
  ASSERT_THAT(clean, IsOk());
  EXPECT_THAT(clean->voted_down, testing::IsEmpty());
  Image broken = to_image(mattes[4]);
  std::fill(broken.pixels.begin(),
            broken.pixels.begin() + static_cast<std::ptrdiff_t>(broken.pixels.size() / 2), 0);
  mattes[4] = make_matte({}, broken);
  const Result<HullReport> voted = visual_hull(rig, mattes, options);
  ASSERT_THAT(voted, IsOk());
  EXPECT_THAT(voted->voted_down, testing::ElementsAre(4));
  EXPECT_THAT(voted->remarks, testing::Contains(testing::HasSubstr("camera 'c4' was voted down")));
  EXPECT_NEAR(voted->volume / clean->volume, 1, 0.04);
  options.voting = HullVoting::Strict;
  EXPECT_LT(visual_hull(rig, mattes, options)->volume, 0.8 * clean->volume);
}

// Found by fuzzing: the last hull that was tried without a camera was handed out.
TEST(HullVoting, WithoutAGuiltyCameraGivesTheHullOfAll) {
  const Rig rig = shapes::sphere_rig({.cameras = 8, .focal = 180});
  const auto shape = shapes::sphere({0, 0, 0}, 0.4);
  Rig shifted = rig;  // every matte disagrees with the others a little
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    shifted.cameras[c].model.cx += c % 2 ? 4 : -4;
    shifted.cameras[c].model.cy += c % 4 < 2 ? 4 : -4;
  }
  const std::vector<Matte> mattes = shapes::render_mattes(shifted, shape);
  HullOptions options;
  const Result<HullReport> strict = visual_hull(rig, mattes, options);
  options.voting = HullVoting::Auto;
  const Result<HullReport> voted = visual_hull(rig, mattes, options);
  ASSERT_THAT(strict, IsOk());
  ASSERT_THAT(voted, IsOk());
  EXPECT_LT(*std::min_element(strict->silhouette_iou.begin(), strict->silhouette_iou.end()), 0.97)
      << "no doubt";
  EXPECT_THAT(voted->voted_down, testing::IsEmpty());
  EXPECT_EQ(voted->mesh.positions, strict->mesh.positions);
  EXPECT_EQ(voted->sources, strict->sources);
  EXPECT_EQ(voted->volume, strict->volume);
}

TEST(HullWorkspace, DoesNotChangeResults) {
  const Rig rig = small_ring(6);
  HullWorkspace workspace;
  for (int round = 0; round < 3; ++round) {
    const auto mattes = shapes::render_mattes(rig, shapes::sphere({0.1 * round, 0, 0}, 0.3 + 0.1 * round));
    const Result<HullReport> kept = visual_hull(rig, mattes, {}, &workspace),
                             fresh = visual_hull(rig, mattes, {});
    ASSERT_THAT(kept, IsOk());
    ASSERT_THAT(fresh, IsOk());
    EXPECT_EQ(kept->mesh.positions, fresh->mesh.positions);
    EXPECT_EQ(kept->mesh.triangles, fresh->mesh.triangles);
    EXPECT_EQ(kept->sources, fresh->sources);
    EXPECT_EQ(kept->sources.size(), kept->mesh.triangle_count());
  }
}

}  // namespace
}  // namespace floatstage::recon
