#include "pipeline/evaluate/evaluate.h"

#include <algorithm>
#include <map>

#include "capture/added_file.h"
#include "core/text.h"
#include "pipeline/balance.h"
#include "pipeline/evaluate/class_shares.h"
#include "pipeline/evaluate/ghosting.h"
#include "pipeline/evaluate/held_out_scene.h"
#include "pipeline/film.h"
#include "pipeline/progress.h"
#include "pipeline/undistort.h"
#include "recon/mesh/mesh_mask.h"

namespace floatstage::pipeline {
namespace {

constexpr int kErode = 2;                 // px: mixed pixels at the outline are not the renderer's fault
constexpr int kBand = 6, kMidGray = 128;  // px, level: of psnr_edge
constexpr int kBorderShare = 12;  // of a light field's width: beyond, its cameras do not all see the plane

Image cut_out(const Image& rgb, const Image& silhouette, int under) {
  Image cut = rgb;
  for (int y = 0; y < cut.height; ++y)
    for (int x = 0; x < cut.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const int a = silhouette.at(x, y)[0];
        cut.at(x, y)[c] = static_cast<std::uint8_t>((rgb.at(x, y)[c] * a + under * (255 - a) + 127) / 255);
      }
  return cut;
}

Image all_of(const Image& silhouette, const Image& rgba, const Image& seen, int border) {
  Image mask(silhouette.width, silhouette.height, 1);
  for (int y = border; y < mask.height - border; ++y)
    for (int x = border; x < mask.width - border; ++x)
      mask.at(x, y)[0] =
          silhouette.at(x, y)[0] >= 128 && rgba.at(x, y)[3] >= 128 && seen.at(x, y)[0] == 255 ? 255 : 0;
  return mask;
}

// The mean of every N by N pixels; what is over at the right and the bottom is cut off.
Image shrunk(const Image& image, int n) {
  if (n == 1) return image;
  Image small(image.width / n, image.height / n, image.channels);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x)
      for (int c = 0; c < small.channels; ++c) {
        int sum = 0;
        for (int v = 0; v < n; ++v)
          for (int u = 0; u < n; ++u) sum += image.at(x * n + u, y * n + v)[c];
        small.at(x, y)[c] = static_cast<std::uint8_t>((sum + n * n / 2) / (n * n));
      }
  return small;
}

CameraModel shrunk(CameraModel m, int n) {
  m.width /= n, m.height /= n;
  m.fx /= n, m.fy /= n, m.cx /= n, m.cy /= n, m.skew /= n;
  return m;
}

struct Methods {
  std::vector<std::string> names;
  std::vector<std::unique_ptr<render::ViewRenderer>> renderers;
  render::Scene scene;
};

// Where the scores are taken. An intermediate is opaque wherever the proxy is: the view itself is not, and
// the mask must not shrink with its opacity.
Image scored_mask(const Image& opaque, const EvaluateOptions& options, const HeldOutView& view) {
  const int border = options.border >= 0   ? options.border
                     : view.whole_pictures ? view.truth.width / kBorderShare
                                           : 0;
  return erode_mask(all_of(view.silhouette, opaque, view.seen, border), kErode);
}

// The pixels about the outline, where the lens has seen.
Image seen_band(const HeldOutView& view) {
  Image band = outline_band(view.silhouette, kBand);
  for (std::size_t i = 0; i < band.pixels.size(); ++i)
    if (view.seen.pixels[i] < 255) band.pixels[i] = 0;
  return band;
}

void score_method(const std::string& name, const Image& rgba, HeldOutView& view) {
  const Image rgb = over(rgba, {0, 0, 0});
  const Image black = cut_out(view.truth, view.silhouette, 0);
  Scores& s = view.scores[name] = score(rgb, black, view.mask, view.silhouette);
  s.psnr_color = psnr_color(rgb, black, view.mask);
  if (view.has_matte)
    s.psnr_edge = psnr(over(rgba, {kMidGray / 255.F, kMidGray / 255.F, kMidGray / 255.F}),
                       cut_out(view.truth, view.silhouette, kMidGray), seen_band(view));
  view.rendered[name] = rgb;
}

// What the method's own picture of its pixels' classes says; NaN where it has none to show.
Result<ClassShares> shares_of(render::ViewRenderer& renderer, const std::string& name, const Methods& methods,
                              const View& from, render::RendererOptions options, render::RenderOutput output,
                              const Image& mask) {
  if (!render::can_show(name, output)) return class_shares({}, {});
  options.output = output;
  const Result<render::RenderedView> rendered = renderer.render(methods.scene, from, options);
  if (!rendered) return forward(rendered);
  return class_shares(render::download(*rendered), mask);
}

Result<void> score_classes(std::size_t method, const Methods& methods, const View& from,
                           const EvaluateOptions& options, HeldOutView& view) {
  const std::string& name = methods.names[method];
  Scores& scores = view.scores[name];
  struct Kind {
    render::RenderOutput output;
    double Scores::*blurred;
    double Scores::*ghost;
  };
  for (const Kind& kind :
       {Kind{render::RenderOutput::Predicted, &Scores::predicted_blurred, &Scores::predicted_ghost},
        Kind{render::RenderOutput::Measured, &Scores::measured_blurred, &Scores::measured_ghost}}) {
    const Result<ClassShares> shares =
        shares_of(*methods.renderers[method], name, methods, from, options.renderer, kind.output, view.mask);
    if (!shares) return forward(shares);
    scores.*kind.blurred = shares->blurred;
    scores.*kind.ghost = shares->ghost;
  }
  return {};
}

Result<void> draw_methods(const View& from, Methods& methods, const EvaluateOptions& options,
                          HeldOutView& view) {
  for (std::size_t m = 0; m < methods.names.size(); ++m) {
    methods.renderers[m]->reset_history();  // what another camera saw has no part in this view
    render::RendererOptions alone = options.renderer;  // nor has its own picture in another
    alone.field_memory = 0;
    render::RendererOptions apart = alone;
    apart.output = render::RenderOutput::Ghosting;
    Result<render::RenderedView> rendered = methods.renderers[m]->render(methods.scene, from, apart);
    if (!rendered) return forward(rendered);
    const Image heat = render::download(*rendered);
    if (view.mask.empty()) view.mask = scored_mask(heat, options, view);
    rendered = methods.renderers[m]->render(methods.scene, from, alone);
    if (!rendered) return forward(rendered);
    score_method(methods.names[m], render::download(*rendered), view);
    view.scores[methods.names[m]].ghosting = ghosting_of(heat, view.mask);
    if (!options.classes) continue;
    if (Result<void> ok = score_classes(m, methods, from, options, view); !ok) return ok;
  }
  return {};
}

// What the frame before missed, by method: for flicker.
struct FrameBefore {
  int frame = -1;
  std::map<std::string, PictureError> errors;
};

void score_flicker(HeldOutView& view, FrameBefore& before) {
  const Image black = cut_out(view.truth, view.silhouette, 0);
  FrameBefore now{view.frame, {}};
  for (auto& [method, scores] : view.scores) {
    PictureError& error = now.errors[method] = picture_error(view.rendered.at(method), black, view.mask);
    if (before.frame >= 0 && before.frame + 1 == view.frame)
      scores.flicker = flicker(error, before.errors.at(method));
  }
  before = std::move(now);
}

Result<HeldOutView> evaluate_view(const capture::TakeReader& take, Instant& instant, int held,
                                  const Inputs& inputs, Methods& methods, const EvaluateOptions& options) {
  const Rig& rig = take.rig();
  const std::size_t h = static_cast<std::size_t>(held);
  const RigCamera& camera = rig.cameras[h];
  HeldOutView view{.serial = camera.serial,
                   .truth = {},
                   .silhouette = {},
                   .seen = {},
                   .mask = {},
                   .rendered = {},
                   .scores = {}};
  Result<Image> photograph = to_rgb(instant.images.frames[h]);
  if (!photograph)
    return fail(ErrorCode::NotFound,
                text("camera '", camera.serial, "' has no photograph to compare with at this instant"));
  view.truth = shrunk(undistorted(*photograph, camera.model), options.scale);
  if (view.truth.empty())
    return fail(ErrorCode::InvalidArgument,
                text("--scale 1/", options.scale, " leaves nothing of camera '", camera.serial, "'"));
  const Result<capture::AddedFile> added = capture::load_added(take.layout());
  if (!added) return forward(added);
  view.seen =
      shrunk(undistorted(seen_by_lens(added->of(camera.serial), photograph->width, photograph->height),
                         camera.model),
             options.scale);
  view.has_matte = !instant.mattes[h].empty();
  view.whole_pictures = !instant.any_matte;

  // From here the held-out view does not exist: neither its silhouette nor its picture.
  const Result<Mesh> drawn_on = proxy_without(take, instant, held, inputs.input, options.proxy);
  if (!drawn_on) return forward(drawn_on);
  if (Result<void> ok = set_scene(rig, instant, *drawn_on, held, inputs, options.balance, methods.scene); !ok)
    return forward(ok);
  RigCamera ideal = camera;
  ideal.model = shrunk(pinhole(camera.model), options.scale);
  view.silhouette = view.has_matte
                        ? shrunk(undistorted(to_image(instant.mattes[h]), camera.model), options.scale)
                        : to_image(recon::mesh_mask(ideal, *drawn_on));
  if (Result<void> ok = draw_methods(view_of_camera(ideal, *drawn_on), methods, options, view); !ok)
    return forward(ok);
  return view;
}

}  // namespace

Result<void> set_scene(const Rig& rig, const Instant& instant, const Mesh& proxy, int held,
                       const Inputs& inputs, bool balance, render::Scene& out) {
  SceneFrame scene{instant.images, instant.mattes, proxy};
  std::vector<bool> usable = inputs.input;
  for (std::size_t c = 0; c < usable.size(); ++c) {
    const bool knows = !instant.any_matte || !instant.mattes[c].empty();
    usable[c] = usable[c] && static_cast<int>(c) != held && knows;
    if (usable[c]) continue;
    scene.mattes[c] = {};
    scene.images.frames[c] = {};
  }
  const Result<Rig> drawn = balance ? balanced(rig, scene) : rig;
  if (!drawn) return forward(drawn);
  return out.set(*drawn, scene, usable);
}

View view_of_camera(const RigCamera& camera, const Mesh& mesh) {
  View view{.model = pinhole(camera.model), .view_from_world = camera.cam_from_world};
  const Eigen::AlignedBox3d box = bounding_box(mesh).cast<double>();
  const double distance = (box.center() - camera.cam_from_world.center()).norm(),
               radius = box.diagonal().norm() / 2;
  view.far_plane = distance + 1.5 * radius;
  view.near_plane = std::max(distance - 1.5 * radius, view.far_plane * 1e-3);
  return view;
}

Result<void> evaluate_take(capture::TakeReader& take, const EvaluateOptions& options,
                           const std::function<Result<void>(HeldOutView)>& report) {
  if (options.scale < 1)
    return fail(ErrorCode::InvalidArgument, text("a scale of 1/", options.scale, "; 1/1 is the largest"));
  const Result<Inputs> inputs = choose_inputs(take.rig(), options.inputs, options.hold_out);
  if (!inputs) return forward(inputs);
  Methods methods{options.methods, {}, {}};
  for (const std::string& name : options.methods) {
    Result<std::unique_ptr<render::ViewRenderer>> renderer =
        render::make_renderer(name, options.renderer.back_end);
    if (!renderer) return forward(renderer);
    methods.renderers.push_back(std::move(*renderer));
  }
  std::vector<int> frames = options.frames;
  const bool looks_back =
      !frames.empty() && options.frame_before >= 0 && options.frame_before + 1 == frames.front();
  if (looks_back) frames.insert(frames.begin(), options.frame_before);
  std::map<int, FrameBefore> before;  // by camera
  for (std::size_t f = 0; f < frames.size(); ++f) {
    const int frame = frames[f];
    Result<Instant> instant = load_instant(take, frame, options.proxy);
    if (!instant) return forward(instant);
    for (int camera : inputs->held) {
      if (is_cancelled(options.progress)) return cancelled();
      Result<HeldOutView> view = evaluate_view(take, *instant, camera, *inputs, methods, options);
      if (!view) return fail(view.error().code, text("frame ", frame, ": ", view.error().message));
      view->frame = frame;
      score_flicker(*view, before[camera]);
      if (looks_back && f == 0) continue;
      if (Result<void> ok = report(std::move(*view)); !ok) return ok;
    }
  }
  return {};
}

}  // namespace floatstage::pipeline
