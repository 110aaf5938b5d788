#include "studio/live/live_view.h"

#include "studio/live/enlarged_picture.h"

namespace floatstage::studio {

Result<bool> set_scene(const LiveScene& scene, const Rig& rig, std::vector<render::PictureTile>& tiles,
                       render::Scene& to) {
  tiles.clear();
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

namespace {

View smaller(View view, int factor) {
  CameraModel& model = view.model;
  const double width = model.width, height = model.height;
  model.width = (model.width + factor - 1) / factor;
  model.height = (model.height + factor - 1) / factor;
  for (double* v : {&model.fx, &model.cx, &model.skew}) *v *= model.width / width;
  for (double* v : {&model.fy, &model.cy}) *v *= model.height / height;
  return view;
}

}  // namespace

Result<void> LiveView::show(const std::shared_ptr<const LiveScene>& scene) {
  scene_ = scene;
  const Result<bool> uploaded = set_scene(*scene, rig_, tiles_, drawn_);
  drawable_ = uploaded && *uploaded;
  return uploaded ? Result<void>() : forward(uploaded);
}

Result<std::optional<render::RenderedView>> LiveView::render(const View& view, const LiveQuality& quality,
                                                             render::RendererOptions options) {
  if (!drawable_) return std::optional<render::RenderedView>();
  options.flow = quality.flow;
  options.sharp = quality.sharp;
  const int width = view.model.width, height = view.model.height;
  Result<render::RenderedView> picture =
      renderers_.render(quality.method, drawn_, smaller(view, quality.output), options);
  if (!picture) return forward(picture);
  if (quality.output > 1) {
    if (picture->picture == nullptr) small_ = render::download(*picture);
    if (enlarged_.width != width || enlarged_.height != height) enlarged_ = Image(width, height, 4);
    enlarge(picture->picture != nullptr ? *picture->picture : small_, enlarged_);
    picture->texture = 0;
    picture->picture = &enlarged_;
    picture->width = width;
    picture->height = height;
  }
  return std::optional<render::RenderedView>(*picture);
}

}  // namespace floatstage::studio
