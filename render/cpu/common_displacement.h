#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/cpu/displacement_memory.h"
#include "render/cpu/parallax_planes.h"
#include "render/depth_flow.h"
#include "render/renderer.h"

namespace floatstage::render::cpu {

/// The one displacement a pixel that all images of a picture share (Alignment::Depth): their parallaxes, what
/// makes them alike, and what is remembered of the picture before. Both back-ends' way; keeps its memory. One
/// thread at a time.
class CommonDisplacement {
 public:
  /// A picture whose images are projected.
  struct Picture {
    const Scene::Impl* scene;
    std::shared_ptr<void> maps;  ///< what the back-end keeps as long as the scene lives
    ViewRays rays;
    CentersInView centers;
    const CameraChoice* choice;
    const float* inverse_z;  ///< plane of the window, 0 off the proxy
    int width, height;       ///< of the window
    float tolerance;         ///< depths that are one surface
    const ProjectedImages* images;
  };
  Result<void> run(const Picture& picture, const ParallaxPlanes::ReadRow& read,
                   const RendererOptions& options, Interruption* interruption = nullptr);
  /// The picture is drawn: it is the one before the next.
  void remember(const Picture& picture, const RendererOptions& options);
  void forget() { memory_.forget(); }

  /// DepthFlow's: planes of the images' size.
  const std::vector<float>& displacement() const { return depth_.displacement(); }
  const std::vector<std::uint8_t>& believed() const { return depth_.believed(); }
  /// Parallaxes::share: how much each image counted.
  const ShortList<float, kMostListed>& share() const { return parallaxes_.share; }

 private:
  ParallaxPlanes planes_;
  Parallaxes parallaxes_;
  DepthFlow depth_;
  DisplacementMemory memory_;
};

}  // namespace floatstage::render::cpu
