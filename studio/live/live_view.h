#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/rig.h"
#include "render/method_renderers.h"
#include "render/scene.h"
#include "studio/live/live_quality.h"
#include "studio/live/live_scene.h"

namespace floatstage::studio {

/// Prepares a scene's surface and textures for drawing. False when there is nothing to draw: no subject, or
/// no texture of it. `tiles` is room for a list of them, which callers keep.
Result<bool> set_scene(const LiveScene& scene, const Rig& rig, std::vector<render::PictureTile>& tiles,
                       render::Scene& to);

/// Draws live scenes with options.back_end, which must be open. One thread, with GL the GL thread.
class LiveView {
 public:
  explicit LiveView(Rig rig) : rig_(std::move(rig)) {}

  /// From now on this scene is drawn.
  Result<void> show(const std::shared_ptr<const LiveScene>& scene);
  /// The scene from a view; nothing when there is nothing to draw. `options` but for method and flow, which
  /// are the quality's. Valid until the next one.
  Result<std::optional<render::RenderedView>> render(const View& view, const LiveQuality& quality,
                                                     render::RendererOptions options);

  const LiveScene* scene() const { return scene_.get(); }
  bool has_subject() const { return drawable_; }
  const Rig& rig() const { return rig_; }

 private:
  const Rig rig_;
  std::shared_ptr<const LiveScene> scene_;
  std::vector<render::PictureTile> tiles_;
  render::Scene drawn_;
  render::MethodRenderers renderers_;
  Image small_, enlarged_;  // of a quality that draws smaller pictures
  bool drawable_ = false;
};

}  // namespace floatstage::studio
