#pragma once

#include "core/result.h"
#include "render/renderer.h"
#include "render/scene_impl.h"

namespace floatstage::render {

/// The width of the filter under which a camera's photograph shows no ghosts beside its neighbours', px of
/// it: RendererOptions::band_limit, or four times the disparity that Eq. 9.13 leaves to what lies at the ends
/// of the depth range (options.nearest to farthest, or the proxy's depth give or take options.uncertainty),
/// between the camera and the farthest of those with which it is blended. `camera` is an index into
/// scene.cameras.
double band_limit_of(const Scene::Impl& scene, std::size_t camera, const RendererOptions& options);

/// A picture through the filter of Mitchell and Netravali `width` px wide, along rows and then along columns.
/// Colours count by their opacity, so that no backdrop comes in; opacity stays. A width of up to four pixels
/// leaves the picture as it is: it is as sharp as pixels are.
void band_limit(SceneTile& tile, double width);

/// The same, pixel by pixel from its definition: for tests.
void band_limit_reference(SceneTile& tile, double width);

/// "band-limited" (§9.3.5): "linear" from photographs that were band-limited once, for all views.
Result<std::unique_ptr<ViewRenderer>> make_band_limited_renderer(BackEnd back_end);

}  // namespace floatstage::render
