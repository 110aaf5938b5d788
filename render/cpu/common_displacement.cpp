#include "render/cpu/common_displacement.h"

namespace floatstage::render::cpu {
namespace {

DisplacementMemory::Picture remembered(const CommonDisplacement::Picture& p, const Parallaxes& parallaxes,
                                       const RendererOptions& options) {
  return {p.maps,      p.rays,         p.choice, &parallaxes,
          p.inverse_z, p.width,        p.height, options.flow.shrink,
          p.tolerance, options.threads};
}

}  // namespace

Result<void> CommonDisplacement::run(const Picture& picture, const ParallaxPlanes::ReadRow& read,
                                     const RendererOptions& options, Interruption* interruption) {
  ParallaxPlanes::Task task{picture.rays,        picture.centers, {}, picture.width, picture.height,
                            options.flow.shrink, options.threads};
  for (std::size_t i = 0; i < picture.choice->chosen; ++i) task.fade.push_back(picture.choice->fade[i]);
  planes_.run(task, read, parallaxes_);
  if (Result<void> ok =
          depth_.estimate(*picture.images, parallaxes_, options.flow, options.threads, interruption);
      !ok)
    return ok;
  if (options.field_memory > 0)
    memory_.mix(*picture.scene, remembered(picture, parallaxes_, options), options.field_memory,
                depth_.displacement());
  return {};
}

void CommonDisplacement::remember(const Picture& picture, const RendererOptions& options) {
  memory_.keep(*picture.scene, remembered(picture, parallaxes_, options), depth_.displacement());
}

}  // namespace floatstage::render::cpu
