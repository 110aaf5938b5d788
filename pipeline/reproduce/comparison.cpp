#include "pipeline/reproduce/comparison.h"

#include "pipeline/evaluate/evaluate.h"
#include "pipeline/evaluate/ghosting.h"
#include "pipeline/film.h"
#include "pipeline/metrics/metrics.h"

namespace floatstage::pipeline {
namespace {

constexpr int kErode = 2;  // px: mixed pixels at the outline are not the renderer's fault

Image mask_of(const TrueView& view, const Image& rgba, int border) {
  Image mask(rgba.width, rgba.height, 1);
  for (int y = border; y < mask.height - border; ++y)
    for (int x = border; x < mask.width - border; ++x) {
      const bool subject = view.silhouette.empty() || *view.silhouette.at(x, y) >= 128;
      *mask.at(x, y) = subject && rgba.at(x, y)[3] >= 128 ? 255 : 0;
    }
  return erode_mask(mask, kErode);
}

}  // namespace

Result<std::vector<ComparedView>> compare(const TestScene& scene, const ComparisonOptions& options) {
  std::vector<std::unique_ptr<render::ViewRenderer>> renderers;
  for (const std::string& method : options.methods) {
    Result<std::unique_ptr<render::ViewRenderer>> made =
        render::make_renderer(method, options.renderer.back_end);
    if (!made) return forward(made);
    renderers.push_back(std::move(*made));
  }
  render::Scene drawn;
  if (Result<void> ok = drawn.set(scene.rig, scene.photographs); !ok) return forward(ok);
  render::RendererOptions apart = options.renderer;
  apart.output = render::RenderOutput::Ghosting;
  std::vector<ComparedView> compared;
  ProgressPart progress(options.progress, options.what, scene.views.size() * renderers.size());
  for (const TrueView& view : scene.views) {
    ComparedView result{view.rgb, {}, {}, {}};
    const View from = view_of_camera(view.camera, scene.photographs.mesh);
    for (std::size_t m = 0; m < renderers.size(); ++m) {
      if (is_cancelled(options.progress)) return cancelled();
      renderers[m]->reset_history();
      Image heat;
      if (options.ghosting || result.mask.empty()) {
        const Result<render::RenderedView> first = renderers[m]->render(drawn, from, apart);
        if (!first) return forward(first);
        heat = render::download(*first);
        // An intermediate is opaque wherever the proxy is.
        if (result.mask.empty()) result.mask = mask_of(view, heat, scene.border);
      }
      const Result<render::RenderedView> picture = renderers[m]->render(drawn, from, options.renderer);
      if (!picture) return forward(picture);
      const std::string& name = options.methods[m];
      const Image& rgb = result.rendered[name] = over(render::download(*picture), {0, 0, 0});
      MethodScores& s = result.scores[name];
      s.psnr = psnr(rgb, view.rgb, result.mask);
      s.ssim = ssim(rgb, view.rgb, result.mask);
      s.sharpness = sharpness(rgb, view.rgb, result.mask);
      if (options.ghosting) s.ghosting = ghosting_of(heat, result.mask);
      progress.advance();
    }
    compared.push_back(std::move(result));
  }
  return compared;
}

MethodScores mean_of(const std::vector<ComparedView>& views, const std::string& method) {
  MethodScores mean;
  const auto count = static_cast<double>(views.size());
  for (const ComparedView& view : views) {
    const MethodScores& s = view.scores.at(method);
    mean.psnr += s.psnr / count;
    mean.ssim += s.ssim / count;
    mean.sharpness += s.sharpness / count;
    mean.ghosting += s.ghosting / count;
  }
  return mean;
}

TestScene at_its_cameras(const TestScene& scene, std::size_t count) {
  TestScene at = scene;
  at.views.clear();
  for (std::size_t i = 0; i < std::min(count, scene.rig.cameras.size()); ++i) {
    const Matte& matte = scene.photographs.mattes[i];
    const Result<Image> rgb = to_rgb(scene.photographs.images.frames[i]);
    if (rgb) at.views.push_back({scene.rig.cameras[i], *rgb, matte.empty() ? Image() : to_image(matte)});
  }
  return at;
}

}  // namespace floatstage::pipeline
