// Nothing of the backdrop is to be seen in views: the performer of the synthetic studio before a cloth whose
// colour nothing else has, drawn on the hull of true and of faulty mattes from between the cameras.
#include <algorithm>

#include <gtest/gtest.h>

#include "core/synthetic/synthetic_studio.h"
#include "recon/visual_hull.h"
#include "render/renderer.h"
#include "tests/support/matchers.h"

namespace floatstage {
namespace {

constexpr int kLargestPatch = 8;  // px²

struct Instant {
  Rig rig;
  SceneFrame scene;
};

/// The performer before plain magenta.
Instant before_magenta(int cameras, std::uint64_t seed) {
  Instant made;
  made.rig = synthetic_rig({.cameras = cameras, .width = 320, .height = 240});
  const SyntheticStudio studio = std::move(*SyntheticStudio::create(made.rig, {.seed = seed, .samples = 9}));
  for (int c = 0; c < cameras; ++c) {
    SyntheticShot shot = studio.shoot(c, 0);
    const Image plate = studio.plate(c), alpha = to_image(shot.matte);
    Image rgb = *to_rgb(shot.frame);
    for (int y = 0; y < rgb.height; ++y)
      for (int x = 0; x < rgb.width; ++x)
        for (int k = 0; k < 3; ++k) {
          const int cloth = k == 1 ? 0 : 255, share = 255 - *alpha.at(x, y);
          rgb.at(x, y)[k] = static_cast<std::uint8_t>(
              std::clamp(rgb.at(x, y)[k] + (cloth - plate.at(x, y)[k]) * share / 255, 0, 255));
        }
    made.scene.images.frames.push_back(make_frame(shot.frame.info, rgb));
    made.scene.mattes.push_back(std::move(shot.matte));
  }
  return made;
}

/// Mattes that take two pixels of cloth along the outline for the performer, as keys of soft edges do.
Matte fat(const Matte& matte) {
  const Image from = to_image(matte);
  Image to = from;
  for (int y = 0; y < from.height; ++y)
    for (int x = 0; x < from.width; ++x)
      for (int v = std::max(y - 2, 0); v <= std::min(y + 2, from.height - 1); ++v)
        for (int u = std::max(x - 2, 0); u <= std::min(x + 2, from.width - 1); ++u)
          *to.at(x, y) = std::max(*to.at(x, y), *from.at(u, v));
  return make_matte({}, to);
}

/// The largest patch of pixels that show more cloth than anything else.
int largest_patch(const Image& rgba) {
  const int width = rgba.width;
  std::vector<char> loud(static_cast<std::size_t>(width * rgba.height));
  for (int y = 0; y < rgba.height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::uint8_t* p = rgba.at(x, y);
      loud[static_cast<std::size_t>(y * width + x)] = (std::min(p[0], p[2]) - p[1]) * p[3] > 128 * 255;
    }
  int largest = 0;
  for (std::size_t start = 0; start < loud.size(); ++start) {
    if (loud[start] == 0) continue;
    std::vector<std::size_t> todo = {start};
    loud[start] = 0;
    int size = 0;
    while (!todo.empty()) {
      const int x = static_cast<int>(todo.back()) % width, y = static_cast<int>(todo.back()) / width;
      todo.pop_back();
      ++size;
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, rgba.height - 1); ++v)
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) {
          const auto next = static_cast<std::size_t>(v * width + u);
          if (loud[next] == 0) continue;
          loud[next] = 0;
          todo.push_back(next);
        }
    }
    largest = std::max(largest, size);
  }
  return largest;
}

/// A view between two neighbouring cameras of the ring.
View between(const Rig& rig, int camera) {
  const RigCamera& one = rig.cameras[static_cast<std::size_t>(camera)];
  const Eigen::Vector3d target = focus_point(rig), eye = one.cam_from_world.center();
  const Eigen::AngleAxisd turn(M_PI / static_cast<double>(rig.cameras.size()), Eigen::Vector3d::UnitZ());
  View view{.model = pinhole(one.model), .view_from_world = {}};
  view.view_from_world = look_at(target + turn * (eye - target), target, Eigen::Vector3d::UnitZ());
  return view;
}

int worst_patch(const Instant& instant, const std::string& method, bool soft) {
  render::Scene scene;
  EXPECT_THAT(scene.set(instant.rig, instant.scene), IsOk());
  const auto renderer = std::move(*render::make_renderer(method, render::BackEnd::Cpu));
  render::RendererOptions options;
  options.soft_outlines = soft;
  int worst = 0;
  for (int c = 0; c < static_cast<int>(instant.rig.cameras.size()); ++c) {
    const auto picture = renderer->render(scene, between(instant.rig, c), options);
    EXPECT_THAT(picture, IsOk());
    if (picture) worst = std::max(worst, largest_patch(render::download(*picture)));
  }
  return worst;
}

void put_on_hull(Instant& instant, const std::vector<Matte>& mattes) {
  recon::HullOptions options;
  options.quality = false;
  Result<recon::HullReport> hull = recon::visual_hull(instant.rig, mattes, options);
  ASSERT_THAT(hull, IsOk());
  instant.scene.mesh = std::move(hull->mesh);
  ASSERT_FALSE(instant.scene.mesh.triangles.empty());
}

TEST(MagentaCloth, IsNotSeenOnTheHullOfTrueMattes) {
  for (const std::uint64_t seed : {1, 2}) {
    Instant instant = before_magenta(8, seed);
    put_on_hull(instant, instant.scene.mattes);
    for (const char* method : {"linear", "floating"})
      EXPECT_LE(worst_patch(instant, method, true), kLargestPatch) << method << ", seed " << seed;
  }
}

TEST(MagentaCloth, IsNotSeenOnAHullThatIsTooLarge) {
  Instant instant = before_magenta(8, 1);
  std::vector<Matte> wide;
  for (const Matte& matte : instant.scene.mattes) wide.push_back(fat(matte));
  put_on_hull(instant, wide);
  for (const char* method : {"linear", "floating"}) {
    EXPECT_GT(worst_patch(instant, method, false), 3 * kLargestPatch) << method << ": nothing is tested";
    EXPECT_LE(worst_patch(instant, method, true), kLargestPatch) << method;
  }
}

}  // namespace
}  // namespace floatstage
