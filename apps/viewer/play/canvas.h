#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "apps/viewer/play/camera_frusta.h"
#include "apps/viewer/play/player_state.h"
#include "apps/viewer/play/shown_texture.h"
#include "core/rig.h"
#include "render/method_renderers.h"
#include "studio/live/live_scene.h"

namespace floatstage::apps {

/// The picture in the middle of the player: draws the scene with one method or two side by side, and takes
/// the mouse. A picture is rendered only when the scene, the camera or an option has changed. GL thread only.
class Canvas {
 public:
  Canvas(const Rig& rig, const Eigen::AlignedBox3d& subject) : rig_(rig), subject_(subject) {}

  /// A new instant to show; null shows the last one on.
  Result<void> show(const std::shared_ptr<const SceneFrame>& scene);
  /// The same of a live studio. One without a subject leaves the stage empty.
  Result<void> show(const studio::LiveScene& scene);
  /// Draws into the present ImGui window's whole content, and moves state.camera by mouse and keys.
  Result<void> draw(PlayerState& state);

  double render_milliseconds() const { return render_milliseconds_; }
  bool has_picture() const { return left_.texture != 0; }
  /// Where the last picture was drawn from; absent before the first.
  const std::optional<View>& view() const { return view_; }

 private:
  struct Side {
    render::RenderedView view;
    ShownTexture copy;     // of a picture that is not on the GPU
    unsigned texture = 0;  // what is shown; 0: nothing yet
  };
  // What the last pictures were made of; any difference makes new ones.
  struct Made {
    int width = 0, height = 0, left = -1, right = -1;
    std::uint64_t scene = 0;
    pipeline::PathKey key;
    render::RendererOptions renderer;
  };

  bool stale(const PlayerState& state, const pipeline::PathKey& key, int width, int height) const;
  Result<void> render(const PlayerState& state, const pipeline::PathKey& key, int width, int height);
  Result<void> render_side(Side& side, int method, const PlayerState& state, const View& view);
  void take_mouse(PlayerState& state, float width, float height);

  const Rig rig_;
  const Eigen::AlignedBox3d subject_;
  std::shared_ptr<const SceneFrame> scene_;
  std::uint64_t shown_ = 0;  // scenes so far
  bool drawable_ = false;
  std::optional<View> view_;
  render::Scene drawn_;
  render::MethodRenderers renderers_;
  Side left_, right_;
  std::optional<Made> made_;
  CameraFrusta frusta_;
  double render_milliseconds_ = 0;
};

}  // namespace floatstage::apps
