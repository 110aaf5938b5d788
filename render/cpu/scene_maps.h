#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/cpu/raster.h"
#include "render/scene_impl.h"

namespace floatstage::render::cpu {

/// What the CPU keeps of a Scene beside it: the proxy's depth from each photograph's camera, drawn when first
/// needed, as 1/z with 0 for nothing.
struct SceneMaps {
  /// This scene's; emptied when the scene was set anew. Lives as long as the scene.
  static SceneMaps& of(const Scene::Impl& scene);

  struct Map {
    std::vector<float> inverse_z;
    bool drawn = false;
  };
  std::uint64_t version = 0;
  bool closed = false;    ///< the mesh: back faces need not be drawn
  std::vector<Map> maps;  ///< of Scene::Impl::cameras
};

/// Draws a scene's mesh for a view and the depth maps of `wanted` cameras that are not there yet, all at
/// once.
class ProxyRaster {
 public:
  /// `inverse_z` and `triangle` get the view's picture, view.width x view.height.
  void run(const Scene::Impl& scene, const RasterCamera& view, std::span<const int> wanted, int threads,
           float* inverse_z, std::uint32_t* triangle);

  /// The mesh as the view of the last run() sees it, as long as its scene stays.
  const ScreenMesh& seen() const { return targets_[0].mesh; }

 private:
  struct Target {
    ScreenMesh mesh;
    int height = 0;
    float* inverse_z = nullptr;
    std::uint32_t* triangle = nullptr;
  };
  std::vector<Target> targets_;  // kept for their storage
};

}  // namespace floatstage::render::cpu
