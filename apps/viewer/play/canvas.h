#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "apps/viewer/play/camera_frusta.h"
#include "apps/viewer/play/picture_pace.h"
#include "apps/viewer/play/player_state.h"
#include "apps/viewer/play/shown_texture.h"
#include "apps/viewer/play/stage_input.h"
#include "core/rig.h"
#include "pipeline/film_sight.h"
#include "render/method_renderers.h"
#include "studio/live/live_scene.h"

namespace floatstage::apps {

/// How long a canvas took for its pictures.
struct CanvasTimes {
  PictureTimes at_rest, moving;
  double moving_seconds = 0;          ///< from moving picture to moving picture, the window's part included
  int moving_steps = 0;               ///< so many times
  double coarsest = 1;                ///< scale of a moving picture
  int given_up = 0;                   ///< full pictures that a hand ended
  bool without_flow = false;          ///< some moving pictures were blended where floating was asked for
  double left_ms = 0, right_ms = 0;   ///< of the last picture, each side
  int width = 0, height = 0;          ///< px drawn of the last picture
  double window_ms = 0, load_ms = 0;  ///< the rest of a frame; the last scene until it was drawable
};

/// The picture in the middle of the player: draws the scene with one method or two side by side, and takes
/// what hands do. A picture is rendered only when the scene, the camera or an option has changed; with
/// PlayerState::quick while something moves it is as fine as time allows, and full once that rests. GL thread
/// only.
class Canvas {
 public:
  Canvas(const Rig& rig, const Eigen::AlignedBox3d& subject) : rig_(rig), subject_(subject) {}

  /// A new instant to show; null shows the last one on.
  Result<void> show(const std::shared_ptr<const SceneFrame>& scene);
  /// The same of a live studio. One without a subject leaves the stage empty.
  Result<void> show(const studio::LiveScene& scene);
  /// What is shown, to be given fields.
  render::Scene& scene() { return drawn_; }
  /// Draws into the present ImGui window's whole content, and moves state.camera by `input`.
  Result<void> draw(PlayerState& state, std::span<const InputEvent> input);
  /// The window's last frame took so long without the picture, if one was drawn.
  void window_took(double seconds) {
    times_.window_ms = 1e3 * (seconds - last_render_seconds_);
    pace_.window_took(seconds - last_render_seconds_);
  }

  /// Asked while a picture is drawn on the CPU with PlayerState::quick, where one is shown already: true
  /// gives a full one up. The next picture is one of those that are drawn while something moves, which none
  /// gives up, and the full one is begun again when nothing does.
  void give_up_when(std::function<bool()> hand_waits) { hand_waits_ = std::move(hand_waits); }
  /// The last draw() gave its picture up.
  bool gave_up() const { return gave_up_; }

  double render_milliseconds() const { return render_milliseconds_; }
  const CanvasTimes& times() const { return times_; }
  /// There is one, and it is not one of those that are drawn while something moves.
  bool has_full_picture() const { return left_.texture != 0 && !made_moving_ && !gave_up_; }
  /// Whether every picture that is drawn is kept for take_picture(), which costs a copy.
  void keep_pictures(bool keep) { keep_pictures_ = keep; }
  /// The left side's last picture, RGBA, once; nothing when none was drawn since.
  std::optional<Image> take_picture() { return std::exchange(kept_, std::nullopt); }
  /// There is something to draw.
  bool has_subject() const { return drawable_; }
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
    render::RenderOutput right_output = render::RenderOutput::Color;  // the left one's is the renderer's
  };

  bool stale(const Made& wanted) const;
  Made wanted(const PlayerState& state, const pipeline::PathKey& key, float width, float height,
              bool moving) const;
  bool judge_motion(const PlayerState& state, const pipeline::PathKey& key, double now);
  Result<void> render(const PlayerState& state, const Made& wanted, bool moving, double now);
  Result<void> render_sides(const PlayerState& state, bool moving);
  Result<double> render_side(Side& side, int method, render::RenderOutput output, const PlayerState& state,
                             bool moving);
  void fly(std::span<const InputEvent> input, PlayerState& state) const;
  void list_times(const PlayerState& state, float x1, float y0) const;
  void list_doubts(float x0, float y1) const;
  void list_pictures(const PlayerState& state, float x0, float y0, float x1, float y1) const;

  const Rig rig_;
  const Eigen::AlignedBox3d subject_;
  std::shared_ptr<const SceneFrame> scene_;
  std::uint64_t shown_ = 0;  // scenes so far
  bool drawable_ = false;
  std::optional<View> view_;
  std::vector<render::PictureTile> tiles_;  // of a live scene
  render::Scene drawn_;
  render::MethodRenderers renderers_;
  Side left_, right_;
  std::optional<pipeline::FilmSight> sight_;  // of the left side's picture; absent until it is asked for
  std::optional<Made> made_;
  CameraFrusta frusta_;
  StageInput hands_;
  PicturePace pace_;
  CanvasTimes times_;
  bool made_moving_ = false, gave_up_ = false, keep_pictures_ = false;
  std::function<bool()> hand_waits_;
  std::optional<Image> kept_;
  double last_moving_ = 0;  ///< when the last moving picture was drawn, ImGui's seconds
  double render_milliseconds_ = 0, last_render_seconds_ = 0;
};

}  // namespace floatstage::apps
