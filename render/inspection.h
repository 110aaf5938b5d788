#pragma once

#include <string_view>

#include "core/result.h"
#include "render/camera_choice.h"
#include "render/renderer.h"

// What both back-ends need to show an intermediate instead of the view. Their colours are in
// render/cpu/false_color.h and render/gl/shaders/false_color.glsl.
namespace floatstage::render {

/// The intermediates that are the same for all renderers with a proxy.
bool is_shared_intermediate(RenderOutput output);

/// InvalidArgument, with a sentence, where can_show() says no.
Result<void> check_output(std::string_view renderer, RenderOutput output);

/// The places in a choice of the cameras that an output is about: -1 where the view is not drawn from it.
struct ShownSlots {
  int camera = -1, towards = -1;
};
ShownSlots shown_slots(const Scene& scene, const CameraChoice& choice, const RendererOptions& options);

/// How far from one another a surface point shows in a view that is plainly blended from several photographs,
/// and how wide (M. Eisemann, Error-Concealed Image-Based Rendering, Eq. 9.9-9.12).
enum class BlendClass { Sharp, Blurred, Ghost };

/// A photograph whose pixels are up to this much wider than the view's blurs nothing: as wide as a footprint
/// that reads a level alone (kSharpArea) is narrow.
inline constexpr float kSharpSpacing = 1.2247449F;  // the root of it

/// Of two photographs that show it `apart` px from one another and whose pixels are `spacing` px of the view
/// wide (half of the support w of Eq. 9.8); no filter makes a pixel narrower than the view's own.
inline BlendClass blend_class(float apart, float spacing, float other_spacing) {
  const float narrower = spacing < other_spacing ? spacing : other_spacing;
  if (apart > 1) return apart > narrower ? BlendClass::Ghost : BlendClass::Blurred;
  return spacing > kSharpSpacing || other_spacing > kSharpSpacing ? BlendClass::Blurred : BlendClass::Sharp;
}

}  // namespace floatstage::render
