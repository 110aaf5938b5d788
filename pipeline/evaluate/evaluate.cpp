#include "pipeline/evaluate/evaluate.h"

#include <algorithm>
#include <optional>

#include "core/text.h"
#include "pipeline/balance.h"
#include "pipeline/evaluate/undistort.h"
#include "pipeline/film.h"
#include "pipeline/progress.h"
#include "pipeline/scene_loader.h"
#include "recon/mesh/mesh_mask.h"

namespace floatstage::pipeline {
namespace {

constexpr int kErode = 2;  // px: mixed pixels at the outline are not the renderer's fault

Result<int> find_camera(const Rig& rig, const std::string& name) {
  if (const int i = camera_index(rig, name); i >= 0) return i;
  for (std::size_t i = 0; i < rig.cameras.size(); ++i)
    if (std::filesystem::path(rig.cameras[i].serial).stem() == name) return static_cast<int>(i);
  std::string known;
  for (const RigCamera& c : rig.cameras) known += (known.empty() ? "" : ", ") + c.serial;
  return fail(ErrorCode::NotFound, text("the take has no camera '", name, "' to hold out; it has ", known));
}

Result<std::vector<int>> cameras_to_hold_out(const Rig& rig, const std::vector<std::string>& names) {
  std::vector<int> cameras;
  for (const std::string& name : names) {
    Result<int> camera = find_camera(rig, name);
    if (!camera) return forward(camera);
    cameras.push_back(*camera);
  }
  if (names.empty())
    for (std::size_t i = 0; i < rig.cameras.size(); ++i) cameras.push_back(static_cast<int>(i));
  if (rig.cameras.size() < 3)
    return fail(ErrorCode::InvalidArgument, "leave-one-out needs a take of three cameras at least");
  return cameras;
}

Image cut_out(const Image& rgb, const Image& silhouette) {
  Image cut = rgb;
  for (int y = 0; y < cut.height; ++y)
    for (int x = 0; x < cut.width; ++x)
      for (int c = 0; c < 3; ++c)
        cut.at(x, y)[c] = static_cast<std::uint8_t>((rgb.at(x, y)[c] * silhouette.at(x, y)[0] + 127) / 255);
  return cut;
}

Image both(const Image& silhouette, const Image& rgba) {
  Image mask(silhouette.width, silhouette.height, 1);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      mask.at(x, y)[0] = silhouette.at(x, y)[0] >= 128 && rgba.at(x, y)[3] >= 128 ? 255 : 0;
  return mask;
}

// What every held-out view of one instant shares.
struct Instant {
  FrameSet images;
  std::vector<Matte> mattes;
  std::optional<Mesh> proxy;  ///< from all mattes, for cameras that have none; made when first asked for
};

Result<Instant> load_instant(capture::TakeReader& take, int frame) {
  Result<FrameSet> images = take.frame_set(frame);
  if (!images) return forward(images);
  Result<std::vector<Matte>> mattes = load_mattes(take, frame);
  if (!mattes) return forward(mattes);
  if (std::all_of(mattes->begin(), mattes->end(), [](const Matte& m) { return m.empty(); }))
    return fail(ErrorCode::NotFound,
                text("frame ", frame, " of ", take.layout().folder().string(),
                     " has no mattes yet; run `floatstage process ", take.layout().folder().string(), "`"));
  return Instant{std::move(*images), std::move(*mattes), {}};
}

struct Methods {
  std::vector<std::string> names;
  std::vector<std::unique_ptr<render::ViewRenderer>> renderers;
  render::Scene scene;
};

Result<Mesh> proxy_without(const Rig& rig, Instant& instant, std::size_t held,
                           const EvaluateOptions& options) {
  const bool had = !instant.mattes[held].empty();
  if (!had && instant.proxy) return *instant.proxy;
  std::vector<Matte> mattes = instant.mattes;
  mattes[held] = {};
  recon::HullOptions quick = options.hull;
  quick.quality = false;
  Result<recon::HullReport> hull = recon::visual_hull(rig, mattes, quick);
  const std::string& serial = rig.cameras[held].serial;
  if (!hull) return fail(hull.error().code, text("without camera '", serial, "': ", hull.error().message));
  if (hull->mesh.empty())
    return fail(ErrorCode::BadData,
                text("without camera '", serial, "' the hull is empty: the mattes contradict one another"));
  if (!had) instant.proxy = hull->mesh;
  return std::move(hull->mesh);
}

Result<HeldOutView> evaluate_view(const Rig& rig, Instant& instant, int held, Methods& methods,
                                  const EvaluateOptions& options) {
  const std::size_t h = static_cast<std::size_t>(held);
  const RigCamera& camera = rig.cameras[h];
  HeldOutView view{
      .serial = camera.serial, .truth = {}, .silhouette = {}, .mask = {}, .rendered = {}, .scores = {}};
  Result<Image> photograph = to_rgb(instant.images.frames[h]);
  if (!photograph)
    return fail(ErrorCode::NotFound,
                text("camera '", camera.serial, "' has no photograph to compare with at this instant"));
  view.truth = undistorted(*photograph, camera.model);
  view.has_matte = !instant.mattes[h].empty();

  // From here the held-out view does not exist: neither its silhouette nor its picture.
  Result<Mesh> proxy = proxy_without(rig, instant, h, options);
  if (!proxy) return forward(proxy);
  SceneFrame scene{instant.images, instant.mattes, std::move(*proxy)};
  std::vector<bool> usable(rig.cameras.size(), true);
  for (std::size_t c = 0; c < usable.size(); ++c) {
    if (c != h && !instant.mattes[c].empty()) continue;
    usable[c] = false;
    scene.mattes[c] = {};
    scene.images.frames[c] = {};
  }
  const Result<Rig> drawn = options.balance ? balanced(rig, scene) : rig;
  if (!drawn) return forward(drawn);
  if (Result<void> ok = methods.scene.set(*drawn, scene, usable); !ok) return forward(ok);
  RigCamera ideal = camera;
  ideal.model = pinhole(camera.model);
  view.silhouette = view.has_matte ? undistorted(to_image(instant.mattes[h]), camera.model)
                                   : to_image(recon::mesh_mask(ideal, scene.mesh));

  const View from = view_of_camera(camera, scene.mesh);
  for (std::size_t m = 0; m < methods.names.size(); ++m) {
    Result<render::RenderedView> rendered =
        methods.renderers[m]->render(methods.scene, from, options.renderer);
    if (!rendered) return forward(rendered);
    const Image rgba = render::download(*rendered);
    if (view.mask.empty()) view.mask = erode_mask(both(view.silhouette, rgba), kErode);
    const Image rgb = over(rgba, {0, 0, 0});
    view.scores[methods.names[m]] =
        score(rgb, cut_out(view.truth, view.silhouette), view.mask, view.silhouette);
    view.rendered[methods.names[m]] = rgb;
  }
  return view;
}

}  // namespace

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
  Result<std::vector<int>> held = cameras_to_hold_out(take.rig(), options.hold_out);
  if (!held) return forward(held);
  Methods methods{options.methods, {}, {}};
  for (const std::string& name : options.methods) {
    Result<std::unique_ptr<render::ViewRenderer>> renderer =
        render::make_renderer(name, options.renderer.back_end);
    if (!renderer) return forward(renderer);
    methods.renderers.push_back(std::move(*renderer));
  }
  for (int frame : options.frames) {
    Result<Instant> instant = load_instant(take, frame);
    if (!instant) return forward(instant);
    for (int camera : *held) {
      if (is_cancelled(options.progress)) return cancelled();
      Result<HeldOutView> view = evaluate_view(take.rig(), *instant, camera, methods, options);
      if (!view) return fail(view.error().code, text("frame ", frame, ": ", view.error().message));
      view->frame = frame;
      if (Result<void> ok = report(std::move(*view)); !ok) return ok;
    }
  }
  return {};
}

}  // namespace floatstage::pipeline
