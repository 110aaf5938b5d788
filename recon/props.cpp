#include "recon/props.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "core/camera.h"
#include "core/parallel.h"
#include "recon/label_volume.h"

namespace floatstage::recon {
namespace {

constexpr std::uint8_t kWithinProps = 2;
constexpr int kRim = 2;           // px around a mask: there mattes and masks share pixels
constexpr int kFewest = 3;        // cameras that see somebody: two bound a place, the third confirms it
constexpr int kMostRounds = 6;    // each leaves less room, and sees that finer
constexpr double kFiner = 0.9;    // of the voxels before: else that was the last
constexpr int kVoxels = 400'000;  // in the box of the hull: what is hidden is as coarse

/// The mask and a rim around it; empty where it has none.
Image grown(const Image& mask) {
  if (std::find(mask.pixels.begin(), mask.pixels.end(), 255) == mask.pixels.end()) return {};
  Image all(mask.width, mask.height, 1);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (*mask.at(x, y) == 0) continue;
      const int left = std::max(0, x - kRim), right = std::min(mask.width, x + kRim + 1);
      for (int v = std::max(0, y - kRim); v < std::min(mask.height, y + kRim + 1); ++v)
        std::fill(all.at(left, v), all.at(left, v) + (right - left), std::uint8_t{255});
    }
  return all;
}

bool hides_any(const Matte& matte, const Props::Mask& mask) { return !matte.empty() && !mask.stands.empty(); }

Matte with(const Matte& matte, const Image& mask) {
  Image all = to_image(matte);
  for (std::size_t i = 0; i < all.pixels.size(); ++i) all.pixels[i] = std::max(all.pixels[i], mask.pixels[i]);
  return make_matte(matte.source, all);
}

Eigen::Vector3d middle_of(const LabelVolume& volume, std::size_t voxel) {
  return volume.voxel() * (volume.places()[voxel].cast<double>() + Eigen::Vector3d::Constant(0.5));
}

/// The pixel in which a camera has a point, and its depth; nothing beside the picture.
struct SeenAt {
  int x = 0, y = 0;
  double depth = 0;
};
std::optional<SeenAt> seen_at(const RigCamera& camera, const Eigen::Vector3d& point) {
  const Eigen::Vector3d there = camera.cam_from_world * point;
  const std::optional<Eigen::Vector2d> p = project(camera.model, there);
  if (!p || !inside(camera.model, *p)) return std::nullopt;
  return SeenAt{static_cast<int>(p->x()), static_cast<int>(p->y()), there.z()};
}

/// Which voxels may be somebody: half of the cameras that look there see somebody, and the others something
/// that stands before it. kWithinProps: they lie within what stands on the stage as well.
std::vector<std::uint8_t> somebody_in(const Rig& rig, const std::vector<Matte>& mattes,
                                      const std::vector<Props::Mask>& masks, const LabelVolume& volume,
                                      int threads) {
  std::vector<std::uint8_t> somebody(volume.size(), 0);
  const auto known = std::count_if(mattes.begin(), mattes.end(), [](const Matte& m) { return !m.empty(); });
  const int fewest = std::max(kFewest, static_cast<int>(known) / 4);
  parallel_for(volume.size(), threads, [&](std::size_t v) {
    const Eigen::Vector3d middle = middle_of(volume, v);
    int looking = 0, seen = 0, on_props = 0;
    for (std::size_t c = 0; c < mattes.size(); ++c) {
      if (mattes[c].empty()) continue;
      const std::optional<SeenAt> at = seen_at(rig.cameras[c], middle);
      if (!at) continue;
      const bool on_somebody = mattes[c].row(at->y)[at->x] >= 128, on_prop = masks[c].stands_at(at->x, at->y);
      if (!on_somebody && on_prop && at->depth < masks[c].depth_at(at->x, at->y)) return;
      ++looking;
      on_props += on_prop;
      seen += on_somebody;
    }
    if (seen >= fewest && 2 * seen >= looking) somebody[v] = on_props == looking ? kWithinProps : 1;
  });
  return somebody;
}

/// How much of them lies within what stands on the stage, and which camera shows most of that as somebody.
Props::Within within_props(const Rig& rig, const std::vector<Matte>& mattes,
                           const std::vector<Props::Mask>& masks, const LabelVolume& volume,
                           const std::vector<std::uint8_t>& somebody) {
  std::vector<int> shown(mattes.size(), 0);
  double all = 0, within = 0;
  for (std::size_t v = 0; v < volume.size(); ++v) {
    all += somebody[v] != 0;
    if (somebody[v] != kWithinProps) continue;
    ++within;
    for (std::size_t c = 0; c < mattes.size(); ++c) {
      const std::optional<SeenAt> at = seen_at(rig.cameras[c], middle_of(volume, v));
      if (mattes[c].empty() || !at) continue;
      shown[c] += masks[c].stands_at(at->x, at->y) && mattes[c].row(at->y)[at->x] >= 128;
    }
  }
  if (within == 0) return {};
  const auto most = std::max_element(shown.begin(), shown.end());
  return {within / all, static_cast<int>(most - shown.begin())};
}

/// Notes how near a voxel of what stands on the stage is, where a mask has it.
void note(const Eigen::Vector3d& middle, double voxel, const RigCamera& camera, Props::Mask& mask) {
  const Eigen::Vector3d there = camera.cam_from_world * middle;
  const std::optional<Eigen::Vector2d> p = project(camera.model, there);
  if (!p || !inside(camera.model, *p)) return;
  const Image& stands = mask.stands;
  const double reach = 1 + 0.5 * voxel / there.z() * std::max(camera.model.fx, camera.model.fy);
  const int left = std::max(0, static_cast<int>(p->x() - reach)),
            right = std::min(stands.width - 1, static_cast<int>(p->x() + reach)),
            top = std::max(0, static_cast<int>(p->y() - reach)),
            bottom = std::min(stands.height - 1, static_cast<int>(p->y() + reach));
  const auto near = static_cast<float>(there.z() - voxel);
  for (int y = top; y <= bottom; ++y)
    for (int x = left; x <= right; ++x) {
      float& depth = mask.depth[static_cast<std::size_t>(y) * static_cast<std::size_t>(stands.width) +
                                static_cast<std::size_t>(x)];
      if (depth == 0 || near < depth) depth = near;
    }
}

}  // namespace

Props::Props(const Rig& rig, std::vector<Image> masks) {
  for (const Image& mask : masks) masks_.push_back({grown(mask), {}});
  if (any()) find_depths(rig);
}

bool Props::any() const {
  return std::any_of(masks_.begin(), masks_.end(), [](const Mask& mask) { return !mask.stands.empty(); });
}

void Props::find_depths(const Rig& rig) {
  std::vector<Matte> silhouettes;
  for (Mask& mask : masks_) {
    silhouettes.push_back(mask.stands.empty() ? Matte() : make_matte({}, mask.stands));
    mask.depth.assign(mask.stands.pixels.size(), 0.F);
  }
  const double edge = LabelVolume::edge_for(rig, silhouettes, kVoxels);
  if (edge == 0) return;
  const Result<LabelVolume> volume = LabelVolume::carve(rig, silhouettes, edge, 1, 0);
  for (std::size_t v = 0; volume && v < volume->size(); ++v)
    for (std::size_t c = 0; c < masks_.size(); ++c)
      if (!masks_[c].stands.empty()) note(middle_of(*volume, v), edge, rig.cameras[c], masks_[c]);
}

Result<std::vector<Matte>> Props::silhouettes(const Rig& rig, std::vector<Matte> mattes, int threads,
                                              Within* within) const {
  const bool nobody =
      std::all_of(mattes.begin(), mattes.end(), [](const Matte& m) { return m.empty() || coverage(m) == 0; });
  if (!any() || nobody) return mattes;
  std::vector<Matte> room = mattes;  // what each camera leaves to the others
  bool hides = false;
  for (std::size_t c = 0; c < mattes.size(); ++c) {
    if (!hides_any(mattes[c], masks_[c])) continue;
    room[c] = with(mattes[c], masks_[c].stands);
    hides = true;
  }
  if (!hides) return mattes;
  double finest = std::numeric_limits<double>::infinity();
  for (int round = 0; round < kMostRounds; ++round) {
    const double edge = LabelVolume::edge_for(rig, room, kVoxels);
    if (edge == 0 || edge > kFiner * finest) break;
    finest = edge;
    const Result<LabelVolume> volume = LabelVolume::carve(rig, room, edge, 1, threads);
    if (!volume) return forward(volume);
    const std::vector<std::uint8_t> somebody = somebody_in(rig, mattes, masks_, *volume, threads);
    if (within != nullptr) *within = within_props(rig, mattes, masks_, *volume, somebody);
    for (std::size_t c = 0; c < mattes.size(); ++c) {
      if (!hides_any(mattes[c], masks_[c])) continue;
      const Image theirs = volume->picture(static_cast<int>(c), somebody), &stands = masks_[c].stands;
      Image behind(stands.width, stands.height, 1);
      for (std::size_t i = 0; i < behind.pixels.size(); ++i)
        if (theirs.pixels[i] != 0) behind.pixels[i] = stands.pixels[i];
      room[c] = with(mattes[c], behind);
    }
  }
  return finest < std::numeric_limits<double>::infinity() ? room : mattes;
}

}  // namespace floatstage::recon
