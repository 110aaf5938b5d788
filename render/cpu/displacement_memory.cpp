#include "render/cpu/displacement_memory.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/parallel.h"
#include "render/cpu/passage.h"
#include "render/flow/gray_samples.h"
#include "render/remembered_fields.h"

namespace floatstage::render::cpu {
namespace {

Eigen::Vector3d eye_of(const ViewRays& rays) { return {rays.eye[0], rays.eye[1], rays.eye[2]}; }

}  // namespace

void DisplacementMemory::mix(const Scene::Impl& scene, const Picture& picture, double share,
                             std::span<float> displacement) const {
  if (picture.shrink != shrink_ || scene_.lock() != picture.maps || version_ != scene.version) return;
  const auto stays = static_cast<float>(
      remembered_share(scene, eye_of(picture.rays), *picture.choice, eye_of(rays_), share));
  if (!(stays > 0)) return;
  const Passage back(picture.rays, rays_);
  const SeenSurface now{picture.inverse_z, picture.width, picture.height},
      before{inverse_z_.data(), width_, height_};
  const int shrink = shrink_, width = (picture.width + shrink - 1) / shrink,
            height = (picture.height + shrink - 1) / shrink, width_before = (width_ + shrink - 1) / shrink,
            height_before = (height_ + shrink - 1) / shrink;
  const auto px = static_cast<float>(shrink);
  const int bands = std::max(1, std::min(height, picture.threads > 0 ? picture.threads : default_threads()));
  parallel_for(static_cast<std::size_t>(bands), picture.threads, [&](std::size_t band) {
    const int at = static_cast<int>(band);
    for (int y = height * at / bands; y < height * (at + 1) / bands; ++y) {
      const std::ptrdiff_t line = static_cast<std::ptrdiff_t>(y) * width;
      float* row = displacement.data() + line;
      const float* offset = picture.parallaxes->offset.data() + line;
      const float py = (static_cast<float>(y) + 0.5F) * px;
      for (int x = 0; x < width; ++x) {
        const float here = (static_cast<float>(x) + 0.5F) * px, z = now.z_at(here, py);
        if (!(z > 0)) continue;
        const Passage::Point there = back.of(here, py, z);
        const float was = there.z > 0 ? before.z_at(there.x, there.y) : 0;
        if (!(was > 0) || std::abs(was - there.z) > picture.tolerance) continue;
        if (!(offset[x] > 0)) continue;
        const float kept = bilinear_sample(offsets_.data(), width_before, height_before, there.x / px - 0.5F,
                                           there.y / px - 0.5F) /
                           offset[x];
        row[x] += stays * (kept - row[x]);
      }
    }
  });
}

void DisplacementMemory::keep(const Scene::Impl& scene, const Picture& picture,
                              std::span<const float> displacement) {
  scene_ = picture.maps;
  version_ = scene.version;
  rays_ = picture.rays;
  width_ = picture.width;
  height_ = picture.height;
  shrink_ = picture.shrink;
  inverse_z_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  offsets_.resize(displacement.size());
  const std::vector<float>& offset = picture.parallaxes->offset;
  const auto parts = static_cast<std::size_t>(picture.threads > 0 ? picture.threads : default_threads());
  parallel_for(parts, picture.threads, [&](std::size_t part) {
    const auto share = [&](std::size_t size) {
      return std::pair(size * part / parts, size * (part + 1) / parts);
    };
    const auto [first, last] = share(inverse_z_.size());
    std::copy(picture.inverse_z + first, picture.inverse_z + last, inverse_z_.data() + first);
    const auto [begin, end] = share(offsets_.size());
    for (std::size_t i = begin; i < end; ++i) offsets_[i] = displacement[i] * offset[i];
  });
}

}  // namespace floatstage::render::cpu
