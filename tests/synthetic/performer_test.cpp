#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "tests/synthetic/studios.h"

namespace floatstage {
namespace {

// Connected components by union of triangle corners.
std::vector<Mesh> shells_of(const Mesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  auto root = [&](std::uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    for (std::size_t k = 1; k < 3; ++k) parent[root(mesh.triangles[t + k])] = root(mesh.triangles[t]);
  std::map<std::uint32_t, Mesh> shells;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    Mesh& shell = shells[root(mesh.triangles[t])];
    shell.triangles.insert(shell.triangles.end(), mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t),
                           mesh.triangles.begin() + static_cast<std::ptrdiff_t>(t + 3));
  }
  std::vector<Mesh> result;
  for (auto& [id, shell] : shells) {
    shell.positions = mesh.positions;
    result.push_back(std::move(shell));
  }
  return result;
}

TEST(SyntheticPerformer, IsMadeOfClosedManifoldShells) {
  const SyntheticStudio studio = studio_with(small_rig(1), quick_options());
  const Mesh mesh = studio.performer(3);
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> half_edges;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3)
    for (std::size_t k = 0; k < 3; ++k)
      ++half_edges[{mesh.triangles[t + k], mesh.triangles[t + (k + 1) % 3]}];
  for (const auto& [edge, count] : half_edges) {
    ASSERT_EQ(count, 1) << "an edge runs twice in one direction";
    ASSERT_EQ(half_edges.count({edge.second, edge.first}), 1u) << "an open edge";
  }
  std::set<std::uint32_t> used(mesh.triangles.begin(), mesh.triangles.end());
  EXPECT_EQ(used.size(), mesh.positions.size()) << "every vertex belongs to a triangle";
  for (const Mesh& shell : shells_of(mesh)) {  // each is a sphere: V - E + F = 2
    const std::set<std::uint32_t> corners(shell.triangles.begin(), shell.triangles.end());
    EXPECT_EQ(static_cast<long>(corners.size()) - static_cast<long>(shell.triangle_count()) / 2, 2);
  }
}

TEST(SyntheticPerformer, TurnsEveryShellOutwardsInEveryPose) {
  const SyntheticStudio studio = studio_with(small_rig(1), quick_options());
  for (int frame : {0, 11, 29}) {
    const auto shells = shells_of(studio.performer(frame));
    EXPECT_EQ(shells.size(), 23u) << "torso, hips, neck, head, hair; arms, palms, ten fingers; legs, shoes";
    for (const Mesh& shell : shells) EXPECT_GT(signed_volume(shell), 5e-6);
  }
}

TEST(SyntheticPerformer, HasTheSizeOfAPersonAndStandsOnTheFloor) {
  for (std::uint64_t seed : {1, 2, 3, 4, 5}) {
    SyntheticStudioOptions options = quick_options();
    options.seed = seed;
    const SyntheticStudio studio = studio_with(small_rig(1), options);
    for (int frame = 0; frame < 40; frame += 8) {
      const Eigen::AlignedBox3f box = bounding_box(studio.performer(frame));
      EXPECT_NEAR(box.min().z(), 0, 0.004) << "seed " << seed << " frame " << frame;
      EXPECT_GT(box.max().z(), 1.6);
      EXPECT_LT(box.max().z(), 2.15);
      EXPECT_LT(std::max(box.sizes().x(), box.sizes().y()), 1.7);
    }
  }
}

TEST(SyntheticPerformer, FacesTheFirstCamera) {
  const Mesh mesh = studio_with(small_rig(1), quick_options()).performer(0);
  // The toes of both shoes: of everything below the ankle, the front reaches further than the back.
  float front = 0, back = 0;
  for (const Eigen::Vector3f& p : mesh.positions) {
    if (p.z() > 0.07f) continue;
    front = std::max(front, p.y());
    back = std::min(back, p.y());
  }
  EXPECT_GT(front, -back + 0.05f);
}

TEST(SyntheticPerformer, MovesBetweenFramesButNeverJumps) {
  const SyntheticStudio studio = studio_with(small_rig(1), quick_options());
  Mesh before = studio.performer(0);
  for (int frame = 1; frame < 30; ++frame) {
    const Mesh now = studio.performer(frame);
    ASSERT_EQ(now.triangles, before.triangles) << "the topology never changes";
    float furthest = 0;
    for (std::size_t i = 0; i < now.positions.size(); ++i)
      furthest = std::max(furthest, (now.positions[i] - before.positions[i]).norm());
    EXPECT_GT(furthest, 0.005f) << frame;
    EXPECT_LT(furthest, 0.15f) << frame;
    before = now;
  }
}

TEST(SyntheticPerformer, HidesPartsOfItselfFromMostCameras) {
  // A ray that meets the performer and leaves again has crossed one part only; more crossings are
  // self-occlusion.
  const Rig rig = small_rig(8);
  const Mesh mesh = studio_with(rig, quick_options()).performer(5);
  int cameras_with_hidden_limbs = 0;
  for (const RigCamera& c : rig.cameras) {
    // Depth of every front-facing triangle's middle, by pixel: two that are 12 cm apart are different limbs.
    std::map<std::pair<int, int>, std::pair<double, double>> range;
    for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
      const Eigen::Vector3f &p = mesh.positions[mesh.triangles[t]],
                            &q = mesh.positions[mesh.triangles[t + 1]],
                            &r = mesh.positions[mesh.triangles[t + 2]];
      const Eigen::Vector3d middle = ((p + q + r) / 3).cast<double>(),
                            normal = (q - p).cross(r - p).cast<double>();
      if (normal.dot(c.cam_from_world.center() - middle) <= 0) continue;
      const Eigen::Vector3d in_camera = c.cam_from_world * middle;
      const auto pixel = project(c.model, in_camera);
      auto [it, fresh] = range.try_emplace({static_cast<int>(pixel->x()), static_cast<int>(pixel->y())},
                                           in_camera.z(), in_camera.z());
      it->second = {std::min(it->second.first, in_camera.z()), std::max(it->second.second, in_camera.z())};
    }
    const auto hidden = std::count_if(range.begin(), range.end(),
                                      [](const auto& r) { return r.second.second - r.second.first > 0.12; });
    cameras_with_hidden_limbs += hidden > 20;
  }
  EXPECT_GE(cameras_with_hidden_limbs, 5);
}

}  // namespace
}  // namespace floatstage
