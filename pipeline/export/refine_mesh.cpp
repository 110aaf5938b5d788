#include "pipeline/export/refine_mesh.h"

#include <array>
#include <unordered_map>

#include "core/check.h"

namespace floatstage::pipeline {
namespace {

constexpr std::uint32_t kWhole = 0xffffffff;

// Middles of the sides that are too long, each made once for both triangles.
class Middles {
 public:
  Middles(Mesh& mesh, double longest) : mesh_(mesh), longest2_(static_cast<float>(longest * longest)) {}

  /// The vertex in the middle of a side, or kWhole.
  std::uint32_t of(std::uint32_t a, std::uint32_t b) {
    const Eigen::Vector3f from = mesh_.positions[a], to = mesh_.positions[b];
    if (!((to - from).squaredNorm() > longest2_)) return kWhole;
    const std::uint64_t side = (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
    const auto [found, is_new] = made_.try_emplace(side, static_cast<std::uint32_t>(mesh_.positions.size()));
    if (is_new) mesh_.positions.push_back(0.5F * (from + to));
    return found->second;
  }
  bool any() const { return !made_.empty(); }

 private:
  Mesh& mesh_;
  const float longest2_;
  std::unordered_map<std::uint64_t, std::uint32_t> made_;
};

// A triangle around which `v` walks: corner, middle of the side after it (or kWhole), corner, … Cut into fans
// of triangles whose first corner is one that the most triangles meet at.
void cut(const std::array<std::uint32_t, 3>& corners, const std::array<std::uint32_t, 3>& middles,
         std::vector<std::uint32_t>& out) {
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    out.insert(out.end(), {a, b, c});
  };
  int halved = 0;
  for (const std::uint32_t m : middles) halved += m == kWhole ? 0 : 1;
  if (halved == 0) return add(corners[0], corners[1], corners[2]);
  for (std::size_t k = 0; k < 3; ++k) {  // turned until the halved sides stand first
    const std::uint32_t a = corners[k], b = corners[(k + 1) % 3], c = corners[(k + 2) % 3];
    const std::uint32_t ab = middles[k], bc = middles[(k + 1) % 3], ca = middles[(k + 2) % 3];
    if (ab == kWhole || (halved > 1 && bc == kWhole)) continue;
    if (halved == 1) {
      add(a, ab, c);
      add(ab, b, c);
    } else if (halved == 2) {
      add(ab, b, bc);
      add(a, ab, bc);
      add(a, bc, c);
    } else {
      add(a, ab, ca);
      add(ab, b, bc);
      add(ca, bc, c);
      add(ab, bc, ca);
    }
    return;
  }
}

}  // namespace

Mesh refined(Mesh mesh, double longest) {
  FLOATSTAGE_CHECK(longest > 0, "a mesh is refined to sides of some length");
  for (bool any = true; any;) {
    Middles middles(mesh, longest);
    std::vector<std::uint32_t> triangles;
    triangles.reserve(mesh.triangles.size());
    for (std::size_t t = 0; t + 2 < mesh.triangles.size(); t += 3) {
      const std::array<std::uint32_t, 3> v{mesh.triangles[t], mesh.triangles[t + 1], mesh.triangles[t + 2]};
      cut(v, {middles.of(v[0], v[1]), middles.of(v[1], v[2]), middles.of(v[2], v[0])}, triangles);
    }
    any = middles.any();
    mesh.triangles = std::move(triangles);
  }
  return mesh;
}

}  // namespace floatstage::pipeline
