#pragma once

#include "render/camera_choice.h"
#include "render/renderer.h"

namespace floatstage::render {

/// The refusals that all renderers share.
Result<void> check_render(const Scene& scene, const View& view, const RendererOptions& options);

/// Whether floating finds one depth a pixel for all photographs at once (RendererOptions::alignment).
/// `on_gpu`: fields would be found there.
bool finds_depth(const RendererOptions& options, bool on_gpu = false);

/// RenderedView::cameras of a choice.
ShortList<int, kMostListed> cameras_of(const Scene& scene, const CameraChoice& choice);

}  // namespace floatstage::render
