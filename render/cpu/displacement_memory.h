#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/camera_choice.h"
#include "render/cpu/photo_kernels.h"
#include "render/parallaxes.h"
#include "render/scene_impl.h"

namespace floatstage::render::cpu {

/// Keeps how far the surface lies off the proxy (DepthFlow) from one picture to the next of the same scene:
/// noise is what each view finds anew, the surface is not. What is kept belongs to places of the proxy,
/// whoever looks and whichever photographs were asked. docs/adr/0359.
class DisplacementMemory {
 public:
  struct Picture {
    std::shared_ptr<void> maps;  ///< of the scene: what the back-end keeps as long as it lives
    ViewRays rays;
    const CameraChoice* choice;
    const Parallaxes* parallaxes;
    const float* inverse_z;  ///< plane of the window, 0 off the proxy
    int width, height;       ///< of the window
    int shrink;              ///< px of the window, a pixel of the displacements
    float tolerance;         ///< depths that are one surface
    int threads;
  };
  /// Mixes `share` of what is kept (less where the view turned far: remembered_share()) into `offsets`, where
  /// the picture before shows the same surface.
  void mix(const Scene::Impl& scene, const Picture& picture, double share,
           std::span<float> displacement) const;
  void keep(const Scene::Impl& scene, const Picture& picture, std::span<const float> displacement);
  void forget() { scene_.reset(); }

 private:
  std::weak_ptr<void> scene_;  // its maps, which live as long as it does
  std::uint64_t version_ = 0;
  ViewRays rays_{};
  int width_ = 0, height_ = 0, shrink_ = 0;
  std::vector<float> inverse_z_, offsets_;  // as Parallaxes::offset
};

}  // namespace floatstage::render::cpu
