#include "render/renderer_checks.h"

#include "render/scene_impl.h"
#include "render/view_window.h"

namespace floatstage::render {

Result<void> check_render(const Scene& scene, const View& view, const RendererOptions& options) {
  if (Result<void> ok = check(options); !ok) return ok;
  if (Result<void> ok = check(view); !ok) return ok;
  if (scene.impl().cameras.empty())
    return fail(ErrorCode::InvalidArgument, "the scene has no usable camera: set pictures before rendering");
  return {};
}

bool finds_depth(const RendererOptions& options, bool on_gpu) {
  const bool wanted =
      options.alignment == Alignment::Depth || (options.alignment == Alignment::Auto && !on_gpu);
  return wanted && options.positions == Positions::Parallax && options.flow.backend == "variational";
}

ShortList<int, kMostListed> cameras_of(const Scene& scene, const CameraChoice& choice) {
  ShortList<int, kMostListed> cameras;
  for (std::size_t i = 0; i < choice.chosen; ++i)
    cameras.push_back(scene.impl().rig_index[static_cast<std::size_t>(choice.listed[i])]);
  return cameras;
}

}  // namespace floatstage::render
