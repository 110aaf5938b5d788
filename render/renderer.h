#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "core/view.h"
#include "render/back_end.h"
#include "render/camera_choice.h"
#include "render/flow.h"
#include "render/scene.h"
#include "render/seen_pixels.h"

namespace floatstage::render {

/// Which picture a renderer hands out: the final one, or an intermediate of the chain in false colour.
enum class RenderOutput {
  Color,           ///< the view
  Weights,         ///< final blending weights, one colour a chosen camera
  Visibility,      ///< binary visibility per chosen camera
  SoftVisibility,  ///< Eq. 11.5
  Flow,  ///< the combined warp, hue = direction: of the strongest camera, "floating" of the shown one if one
         ///< is (floating, floating-static)
  Ghosting,  ///< per-pixel disagreement of the projections that are about to be blended
  Depth,
  Opacity,    ///< the view's alpha as grey
  Projected,  ///< the shown camera's photograph on the proxy (I_i^v), black where it does not see it
  Aliasing,   ///< how large the photographs' pixels are in the view's (Eq. 9.7): spacing_color()
  Predicted,  ///< what plain blending does to a proxy that is off by `uncertainty` (Eq. 9.9-9.12): green
              ///< sharp, blue blurred, red ghosts
  // floating only:
  Warped,  ///< the shown camera's photograph where its warp puts it (Eq. 11.2), black where it does not count
  PositionWeights,  ///< how much each camera's idea of a position counts, one colour a camera
  ColorWeights,     ///< how much each camera's colour counts in the end, one colour a camera
  Field,            ///< the flow from the shown camera's projected image to another's, hue = direction
  Confidence,       ///< how far that flow is believed, as grey; what is not is filled in from around
  Measured,         ///< as Predicted, by how far the flow finds the projected images apart
};
const std::vector<std::string>& render_output_names();  ///< "color", "weights", … in the enum's order

/// Where "floating" puts what its photographs show at different places.
enum class Positions {
  Parallax,  ///< where it is whatever depth the proxy misses there: the photographs' parallaxes cancel
  Mean,      ///< in the angular mean of the places (Eq. 11.3, as published)
};
const std::vector<std::string>& position_names();  ///< "parallax", "mean": in the enum's order

/// What "floating" finds between photographs to bring them together in the view.
enum class Alignment {
  Flow,   ///< fields between each two of them, two numbers a pixel (Eq. 11.1-11.3)
  Depth,  ///< one depth a pixel for all of them at once: how far the surface lies off the proxy
  Auto,   ///< the faster: Depth, but Flow where a GPU finds it
};
const std::vector<std::string>& alignment_names();  ///< "flow", "depth", "auto": in the enum's order

struct RendererOptions {
  int cameras = 3;                            ///< k: photographs blended per view; more if as near
  double soft_radius = 8;                     ///< px: r of Eq. 11.5
  FlowOptions flow;                           ///< floating only
  Positions positions = Positions::Parallax;  ///< floating only
  /// floating only. Depth is found on the CPU, by the variational flow's energy, and needs
  /// Positions::Parallax: with others, fields are found.
  Alignment alignment = Alignment::Flow;
  double band_limit = 0;  ///< band-limited: px of the photographs, how wide its filter is; 0: as wide as
                          ///< the depth range asks for (Eq. 9.13)
  double nearest = 0, farthest = 0;  ///< band-limited: metres before the cameras; 0: the proxy's depth, give
                                     ///< or take `uncertainty`
  double uncertainty = 0.0063;  ///< band-limited, filtered: how far the surface may lie before or behind the
                                ///< proxy, as a share of the diagonal of the proxy's box
  double motion_blur = 0;  ///< filtered: share of the pictures before that stays in each, 0: none; while the
                           ///< view rests the picture tends to the one without
  double field_memory =
      0;  ///< floating: share of the fields, or depths, of the picture before that stays in
          ///< each picture's, 0: none; while the scene is the same, as they are the surface's
  bool fill_hidden = true;  ///< floating: what a photograph does not see of the proxy shows the strongest of
                            ///< those that do while flow is sought; false: what it shows there instead
                            ///< (thesis Fig. 58b: for comparison)
  bool sharp = true;  ///< photographs are read by a spline in nine reads; false: by one bilinear read, softer
                      ///< and much faster without a GPU
  bool soft_outlines = true;  ///< the view is as opaque at its outline as its pixels are covered and mattes
                              ///< say; false: opaque where the proxy covers a pixel's centre
  int threads = 0;            ///< CPU threads; 0: one per core. The picture does not depend on it
  BackEnd back_end = BackEnd::Auto;  ///< what callers ask make_renderer() for
  std::array<float, 3> background = {0, 0, 0};
  RenderOutput output = RenderOutput::Color;
  int shown_camera = -1;    ///< whose photograph an output shows that shows one: an index into rig.cameras;
                            ///< black where the view is not drawn from it. -1: the view's first
  int towards_camera = -1;  ///< Field, Confidence: the other camera. -1: the first that is not the shown one
  /// Cpu: asked on the calling thread now and then while a picture is drawn; true gives it up, as Cancelled,
  /// and the next picture is as if this one had not been asked for. Empty: nobody gives up.
  std::function<bool()> given_up = {};
};
Result<void> check(const RendererOptions& options);

/// Whether a picture with these options has a soft outline: the view, or its opacity.
inline bool has_soft_outline(const RendererOptions& o) {
  return o.output == RenderOutput::Opacity || (o.output == RenderOutput::Color && o.soft_outlines);
}

/// A rendered picture, which belongs to the renderer and is valid until its next render(): RGBA8, straight
/// alpha. The view's alpha is its opacity (RendererOptions::soft_outlines), that of intermediates 255 where
/// the proxy covers a pixel's centre.
struct RenderedView {
  unsigned texture = 0;            ///< GL back-end: a GL_TEXTURE_2D; 0 otherwise
  const Image* picture = nullptr;  ///< CPU back-end: rows top first; null otherwise
  int width = 0, height = 0;
  SeenPixels seen = {};                 ///< CPU back-end; see seen_pixels()
  unsigned seen_buffer = 0;             ///< GL back-end: the same, in a buffer; 0 otherwise
  ShortList<int, kMostListed> cameras;  ///< the photographs used, strongest first
};

/// Draws a Scene from a View. One thread at a time, with GL the GL thread. Same inputs, same bytes.
class ViewRenderer {
 public:
  virtual ~ViewRenderer() = default;
  /// InvalidArgument for a view with a lens, an empty size or no usable camera (the sentence says which).
  virtual Result<RenderedView> render(const Scene& scene, const View& view,
                                      const RendererOptions& options) = 0;
  /// Forgets the pictures before (RendererOptions::motion_blur, field_memory): the next is as the first. With
  /// them, it is the same sequence of calls that gives the same bytes.
  virtual void reset_history() {}
};

/// "nearest": the best camera per pixel. "linear": Unstructured Lumigraph (Buehler et al. 2001) angular
/// weights. "band-limited": the same from photographs filtered beforehand (thesis §9.3.5). "floating":
/// Floating Textures (thesis ch. 11). Auto makes one for the CPU, which always works; open_back_end() says
/// what is best. For Gl a context must be current.
Result<std::unique_ptr<ViewRenderer>> make_renderer(std::string_view name, BackEnd back_end);
struct RendererInfo {
  std::string name, help;
  bool needs_grid = false;  ///< draws only cameras on a camera_grid()
};
std::vector<RendererInfo> renderers();

/// Whether a renderer has an output to show: with "floating" all, others none of what only flow knows.
bool can_show(std::string_view renderer, RenderOutput output);

/// Whether a picture is black, or has nothing to show, because its view is not drawn from a camera that
/// `options` name.
bool lacks_shown_camera(const RenderedView& view, const RendererOptions& options);

/// The photographs that a view of this scene is drawn from, strongest first: `count` indices into
/// rig.cameras, and at most as many again where more are about as near as the nearest (ADR 315); with those
/// that stand in for them where a hundredth of what it shows lies beyond their pictures (ADR 362). What a
/// viewer asks camera nodes for (thesis §11.5: only these textures travel). Any thread.
std::vector<int> needed_cameras(const Rig& rig, const Mesh& mesh, const View& view, int count);

/// A copy of a rendered view, from wherever it is: RGBA, rows top first.
Image download(const RenderedView& view);

/// How much of a rendered view the photographs that it is drawn from see; the rest continues its surroundings
/// (ADR 363). None shown: it was not asked, of intermediates, without soft outlines and of "light-field".
/// With GL it waits for the picture.
SeenPixels seen_pixels(const RenderedView& view);

}  // namespace floatstage::render
