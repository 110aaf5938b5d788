#pragma once

#include <string>

#include "render/renderer.h"

// The native back-end: the same passes as render/gl, on the CPU.
namespace floatstage::render::cpu {

/// "linear" and, with `one_camera`, "nearest": the projected photographs, blended as they are.
Result<std::unique_ptr<ViewRenderer>> make_blend_renderer(bool one_camera);

/// "light-field": quadrilinear, from cameras on a grid (Levoy and Hanrahan 1996).
Result<std::unique_ptr<ViewRenderer>> make_light_field_renderer();

/// "filtered": Filtered Blending (ch. 10).
Result<std::unique_ptr<ViewRenderer>> make_filtered_renderer();

/// "floating": Floating Textures (Eisemann, Error-Concealed Image-Based Rendering, ch. 11).
Result<std::unique_ptr<ViewRenderer>> make_floating_renderer();

/// "floating-static": the same with fields from the cameras' own pictures (Eq. 11.4).
Result<std::unique_ptr<ViewRenderer>> make_static_renderer();

/// The instruction set that is used here and the number of cores, for reports.
std::string description();

}  // namespace floatstage::render::cpu
