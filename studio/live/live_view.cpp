#include "studio/live/live_view.h"

namespace floatstage::studio {

Result<bool> set_scene(const LiveScene& scene, const Rig& rig, render::Scene& to) {
  std::vector<render::PictureTile> tiles;
  for (const std::shared_ptr<const CameraView>& view : scene.views) {
    if (!view || !view->tile) continue;
    const int camera = camera_index(rig, view->serial);
    if (camera >= 0)
      tiles.push_back({camera, view->tile->x, view->tile->y, &view->tile->picture, &view->tile->matte});
  }
  if (tiles.empty() || scene.scene.mesh.empty()) return false;
  if (Result<void> ok = to.set(rig, scene.scene.mesh, tiles); !ok) return forward(ok);
  return true;
}

Result<void> LiveView::show(const std::shared_ptr<const LiveScene>& scene) {
  scene_ = scene;
  const Result<bool> uploaded = set_scene(*scene, rig_, drawn_);
  drawable_ = uploaded && *uploaded;
  return uploaded ? Result<void>() : forward(uploaded);
}

Result<std::optional<render::RenderedView>> LiveView::render(const View& view, const LiveQuality& quality,
                                                             render::RendererOptions options) {
  if (!drawable_) return std::optional<render::RenderedView>();
  options.flow = quality.flow;
  options.sharp = quality.sharp;
  Result<render::RenderedView> picture = renderers_.render(quality.method, drawn_, view, options);
  if (!picture) return forward(picture);
  return std::optional<render::RenderedView>(*picture);
}

}  // namespace floatstage::studio
