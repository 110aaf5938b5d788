#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "tests/synthetic/studios.h"

namespace floatstage {
namespace {

// Depth of the mesh's surface along the ray through a pixel's centre, by testing every triangle (Möller and
// Trumbore, 1997).
double mesh_depth(const Mesh& mesh, const RigCamera& camera, int x, int y) {
  const Eigen::Vector3d ray = *unproject(camera.model, {x + 0.5, y + 0.5});
  const Eigen::Vector3d d = camera.cam_from_world.rotation.conjugate() * ray,
                        o = camera.cam_from_world.center();
  double nearest = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    const Eigen::Vector3d a = mesh.positions[mesh.triangles[t]].cast<double>(),
                          e1 = mesh.positions[mesh.triangles[t + 1]].cast<double>() - a,
                          e2 = mesh.positions[mesh.triangles[t + 2]].cast<double>() - a, p = d.cross(e2);
    const double det = e1.dot(p);
    if (std::abs(det) < 1e-14) continue;
    const double u = (o - a).dot(p) / det, v = d.dot((o - a).cross(e1)) / det,
                 s = e2.dot((o - a).cross(e1)) / det;
    if (u >= 0 && v >= 0 && u + v <= 1 && s > 0) nearest = std::min(nearest, s);
  }
  return nearest;
}

TEST(SyntheticTruth, DepthIsTheMeshesOwn) {
  const SyntheticStudio studio = studio_with(small_rig(), quick_options({.lens_k1 = -0.15}));
  const SyntheticShot shot = studio.shoot(1, 4);
  const Mesh mesh = studio.performer(4);
  const RigCamera& camera = studio.true_rig().cameras[1];
  int compared = 0, strands = 0;
  for (int y = 1; y < 120; y += 4) {
    for (int x = 2; x < 160; x += 3) {
      const double truth = mesh_depth(mesh, camera, x, y),
                   depth = shot.depth[static_cast<std::size_t>(y * 160 + x)];
      if (std::isfinite(truth) && std::abs(truth - depth) < 1e-3)
        ++compared;
      else if (!std::isfinite(truth) && !std::isfinite(depth))
        continue;
      else if (depth < truth)
        ++strands;  // a loose strand, which is not in the mesh
      else if (shot.matte.row(y)[x] == 255)
        ADD_FAILURE() << x << ", " << y << ": " << depth << " instead of " << truth;
    }
  }
  EXPECT_GT(compared, 50);
  EXPECT_LT(strands, compared / 4);
}

TEST(SyntheticTruth, MatteIsFullInsidePartialAtEdgesAndEmptyOutside) {
  const SyntheticShot shot = studio_with(small_rig(), quick_options()).shoot(0, 0);
  int full = 0, partial = 0, empty = 0;
  for (int y = 1; y + 1 < 120; ++y) {
    for (int x = 1; x + 1 < 160; ++x) {
      const int alpha = shot.matte.row(y)[x];
      (alpha == 255 ? full : alpha == 0 ? empty : partial) += 1;
      int surrounded = 0;  // a part-covered pixel has an edge through it, so it never lies deep inside
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) surrounded += shot.matte.row(y + dy)[x + dx] == 255;
      if (surrounded == 8) {
        EXPECT_EQ(alpha, 255) << "a hole at " << x << ", " << y;
      }
    }
  }
  EXPECT_GT(full, 700);
  EXPECT_GT(partial, 200);
  EXPECT_GT(empty, 10000);
}

TEST(SyntheticTruth, StrandsCoverPixelsOnlyPartly) {
  // Pixels that the closed shells do not touch but the matte knows: strands, thinner than a pixel here.
  const Rig rig = small_rig();
  const SyntheticStudio studio = studio_with(rig, quick_options());
  const SyntheticShot shot = studio.shoot(1, 2);
  const Mesh mesh = studio.performer(2);
  std::vector<char> shell(160 * 120, 0);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    Eigen::AlignedBox2d box;
    for (std::size_t k = 0; k < 3; ++k)
      box.extend(*project(rig.cameras[1].model, rig.cameras[1].cam_from_world *
                                                    mesh.positions[mesh.triangles[t + k]].cast<double>()));
    for (int y = static_cast<int>(box.min().y()); y <= static_cast<int>(box.max().y()); ++y)
      for (int x = static_cast<int>(box.min().x()); x <= static_cast<int>(box.max().x()); ++x)
        shell[static_cast<std::size_t>(y * 160 + x)] = 1;
  }
  int strand_pixels = 0, opaque = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      if (shell[static_cast<std::size_t>(y * 160 + x)] || shot.matte.row(y)[x] == 0) continue;
      ++strand_pixels;
      opaque += shot.matte.row(y)[x] > 230;
    }
  }
  EXPECT_GT(strand_pixels, 60);
  EXPECT_LT(opaque, strand_pixels / 5) << "only the middle of the hair's tail is dense";
}

TEST(SyntheticTruth, PhotographIsThePlateWhereThePerformerIsNot) {
  const SyntheticStudio studio =
      studio_with(small_rig(), quick_options({.color_gain = 0.1, .green_spill = 1}));
  for (int camera = 0; camera < 4; ++camera) {
    const SyntheticShot shot = studio.shoot(camera, 3);
    const Image picture = rgb_of(shot), plate = studio.plate(camera);
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x)
        if (shot.matte.row(y)[x] == 0) {
          ASSERT_TRUE(std::equal(picture.at(x, y), picture.at(x, y) + 3, plate.at(x, y))) << x << ", " << y;
        }
  }
}

TEST(SyntheticTruth, CamerasAgreeOnTheColourOfASurfacePoint) {
  // Two cameras 12 degrees apart; points that both see, away from edges, found through the depth map.
  const Rig rig = synthetic_rig({.cameras = 30, .width = 640, .height = 480});
  const Rig pair{{rig.cameras[0], rig.cameras[1]}};
  const SyntheticStudio studio = studio_with(pair, {.seed = 7, .samples = 16});
  const SyntheticShot a = studio.shoot(0, 6), b = studio.shoot(1, 6);
  const Image in_a = rgb_of(a), in_b = rgb_of(b);
  const RigCamera &from = pair.cameras[0], &to = pair.cameras[1];
  double sum = 0;
  int count = 0, wild = 0;
  for (int y = 0; y < 480; y += 2) {
    for (int x = 0; x < 640; x += 2) {
      const float depth = a.depth[static_cast<std::size_t>(y * 640 + x)];
      if (!std::isfinite(depth) || a.matte.row(y)[x] < 255) continue;
      const Eigen::Vector3d world =
          from.cam_from_world.inverse() * (*unproject(from.model, {x + 0.5, y + 0.5}) * depth);
      const Eigen::Vector3d there = to.cam_from_world * world;
      const auto pixel = project(to.model, there);
      if (!pixel || !inside(to.model, *pixel - Eigen::Vector2d(1, 1)) ||
          !inside(to.model, *pixel + Eigen::Vector2d(1, 1)))
        continue;
      const double px = pixel->x() - 0.5, py = pixel->y() - 0.5;
      const int ix = static_cast<int>(px), iy = static_cast<int>(py);
      bool seen = true;
      for (int k = 0; k < 4; ++k)
        seen &=
            std::abs(b.depth[static_cast<std::size_t>((iy + k / 2) * 640 + ix + k % 2)] - there.z()) < 0.01;
      if (!seen) continue;
      for (int c = 0; c < 3; ++c) {
        auto at = [&](int dx, int dy) { return static_cast<double>(in_b.at(ix + dx, iy + dy)[c]); };
        const double u = px - ix, v = py - iy;
        const double there_color =
            (1 - v) * ((1 - u) * at(0, 0) + u * at(1, 0)) + v * ((1 - u) * at(0, 1) + u * at(1, 1));
        const double difference = in_a.at(x, y)[c] - there_color;
        sum += difference;
        wild += std::abs(difference) > 60;
        ++count;
      }
    }
  }
  ASSERT_GT(count, 6000);
  EXPECT_LT(std::abs(sum / count), 0.6) << "no camera is brighter than the other";
  EXPECT_LT(wild, count / 50) << "fine print is resampled, so single pixels may differ, but not many by much";
}

TEST(SyntheticTruth, AViewFromACamerasPlaceIsThatCamerasPhotograph) {
  const Rig rig = small_rig();
  const SyntheticStudio studio = studio_with(rig, quick_options());
  const SyntheticShot shot = studio.shoot(2, 5),
                      view = studio.shoot_view({rig.cameras[2].model, rig.cameras[2].cam_from_world}, 5);
  EXPECT_EQ(rgb_of(shot), rgb_of(view));
  EXPECT_EQ(to_image(shot.matte), to_image(view.matte));
  EXPECT_EQ(shot.depth, view.depth);
}

TEST(SyntheticTruth, ACameraBesideThePerformerThatLooksAwaySeesOnlyCloth) {
  const SyntheticStudio studio = studio_with(small_rig(), quick_options());
  const View away{small_rig().cameras[0].model, look_at({0, 2, 1.2}, {0, 4, 1.2}, {0, 0, 1})};
  const SyntheticShot shot = studio.shoot_view(away, 0);
  EXPECT_EQ(coverage(shot.matte), 0);
  EXPECT_FALSE(shot.frame.empty());
}

TEST(SyntheticTruth, ACameraAmongTheLimbsStillPhotographs) {
  const SyntheticStudio studio = studio_with(small_rig(), quick_options());
  const View close{small_rig().cameras[0].model, look_at({0.0, 0.5, 1.2}, {0, 0, 1.2}, {0, 0, 1})};
  const SyntheticShot shot = studio.shoot_view(close, 0);
  EXPECT_GT(coverage(shot.matte), 0.3) << "the chest fills the picture";
}

TEST(SyntheticTruth, TheBlackStageIsDarkEnoughToKeyByLuminance) {
  SyntheticStudioOptions options = quick_options();
  options.stage = SyntheticStage::Black;
  const SyntheticStudio studio = studio_with(small_rig(), options);
  const Image plate = studio.plate(0);
  EXPECT_LT(*std::max_element(plate.pixels.begin(), plate.pixels.end()), 12);
  const SyntheticShot shot = studio.shoot(0, 0);
  const Image picture = rgb_of(shot);
  int subject = 0, dark = 0;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x)
      if (shot.matte.row(y)[x] == 255) {
        ++subject;
        dark += picture.at(x, y)[0] + picture.at(x, y)[1] + picture.at(x, y)[2] < 3 * 12;
      }
  EXPECT_LT(dark, subject / 50);
}

TEST(SyntheticTruth, TheGreenRoomIsGreenAndUneven) {
  const Image plate = studio_with(small_rig(), quick_options()).plate(0);
  int low = 255, high = 0;
  for (std::size_t i = 0; i < plate.pixels.size(); i += 3) {
    const int r = plate.pixels[i], g = plate.pixels[i + 1], b = plate.pixels[i + 2];
    ASSERT_GT(g, std::max(r, b) + 40);
    low = std::min(low, g);
    high = std::max(high, g);
  }
  EXPECT_GT(high - low, 25);
}

}  // namespace
}  // namespace floatstage
