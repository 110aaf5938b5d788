#pragma once

#include <array>
#include <optional>
#include <vector>

#include "render/camera_choice.h"
#include "render/gl/kernel.h"
#include "render/gl/outline.h"
#include "render/gl/scene_textures.h"
#include "render/gl/unseen.h"
#include "render/renderer.h"
#include "render/view_window.h"

namespace floatstage::render {

/// Uniforms of every pass (std140; shaders/view.glsl has the twin).
struct ViewBlock {
  std::array<float, 16> clip_from_world, world_from_view;
  std::array<float, 4> view_center, view_k, window, settings, background;
  std::array<int, 4> counts;
  std::array<std::array<int, 4>, 2> camera_list;
  std::array<std::array<float, 4>, kMostListed> camera_fade;
};
static_assert(sizeof(ViewBlock) == 128 + 5 * 16 + 3 * 16 + kMostListed * 16);

class ViewTarget;

/// The first half of every renderer: the proxy from the view, who sees what (depth maps, frame, matte), soft
/// visibility (Eq. 11.5), and the cameras' weights, all as textures over a window of the view.
class Projection {
 public:
  static Result<Projection> create();

  /// Runs the passes. `one_camera` gives all weight to the best visible camera of each pixel, `levels` fills
  /// the levels of all listed photographs, whatever the footprints are, `unreached` is the opacity of what no
  /// picture of the list reaches. After it the uniforms, the camera
  /// buffer and the photographs stay bound for passes that go on from here.
  void run(const SceneTextures& scene, const View& view, const RendererOptions& options, int margin,
           bool one_camera, bool levels = false, float unreached = 0);

  const Window& window() const { return window_; }
  int margin() const { return margin_; }  ///< px of it on each side, beyond what the proxy covers
  const CameraChoice& choice() const { return choice_; }
  const gl::Texture& surface() const { return surface_; }          ///< RGBA32F: normal, z
  const gl::Texture& visibility() const { return visibility_; }    ///< RG32UI: bits, proxy
  const gl::Texture& weights(int i) const { return weights_[i]; }  ///< RGBA16F, i = 0, 1: slots 0-3, 4-7
  const gl::Texture& soft(int i) const { return soft_[i]; }
  const gl::Texture& angular(int i) const { return angular_[i]; }
  const gl::Texture& mattes() const {
    return mattes_;
  }  ///< RG8: mean and largest of what they say at the surface

  /// A buffer with the SeenPixels of the last soften(); 0 where it did not ask.
  unsigned seen() const { return counts_seen_ ? unseen_->seen().id() : 0; }

  /// Runs a kernel on every pixel of the window (shaders/window.glsl).
  void on_window(const gl::Kernel& kernel, gl::Kernel::Textures read, gl::Kernel::Textures written) const;
  /// Runs one that draws on every pixel of `target` (shaders/picture.glsl).
  void draw(gl::Kernel& kernel, gl::Kernel::Textures read, const ViewTarget& target) const;

  /// Draws the proxy's triangles with the bound program and framebuffer: the back faces, too, unless others
  /// hide them.
  void draw_proxy(const SceneTextures& scene) const;

  /// Once the view is drawn into `target`: continues its surroundings where no camera sees it, and gives it
  /// its opacity, where the options want that. `sees`: the colours are those of cameras that see what they
  /// show.
  void soften(const SceneTextures& scene, const RendererOptions& options, ViewTarget& target,
              bool sees = true) {
    counts_seen_ = sees && has_soft_outline(options) && options.output == RenderOutput::Color;
    if (counts_seen_) unseen_->run(*this, target);
    outline_->soften(*this, scene, options, target);
  }

 private:
  Projection() = default;
  void reserve();
  void find_row_distances();
  void find_deepest(const SceneTextures& scene, const View& view, bool levels);
  void write_uniforms(const SceneTextures& scene, const View& view, const RendererOptions& options,
                      bool one_camera);

  gl::Program depth_map_, proxy_;
  gl::Kernel visibility_pass_, soft_rows_, weights_pass_;
  gl::Buffer uniforms_;
  std::size_t uniform_capacity_ = 0;
  std::optional<Unseen> unseen_;  // made by create(), as the next one
  std::optional<Outline> outline_;
  gl::Texture surface_, z_buffer_, visibility_, row_distances_, mattes_;
  std::array<gl::Texture, 2> angular_, weights_, soft_;
  gl::Framebuffer surface_target_;
  Window window_;
  int margin_ = 0;
  bool counts_seen_ = false;
  bool hides_backs_ = false;  // the proxy, in this view
  CameraChoice choice_;
  std::array<int, kMostListed> deepest_{};  // of the listed: the last level that any pixel reads
};

/// The picture a renderer hands out: RGBA8 of the view's size. Kernels that draw write all of it, the
/// background with alpha 0 where nothing is (Projection::draw()).
class ViewTarget {
 public:
  void begin(int width, int height);
  /// Begins another picture from the last one: that, to be read while drawing.
  const gl::Texture& begin_again();
  /// Makes it the background alone.
  void clear(const std::array<float, 3>& background);
  const gl::Texture& texture() const { return colors_[last_]; }

 private:
  std::array<gl::Texture, 2> colors_;
  std::size_t last_ = 0;
};

}  // namespace floatstage::render
