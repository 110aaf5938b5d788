#pragma once

#include <array>

#include "render/inspection.h"

// False colours of the intermediates, rgb 0…255. The twin of render/gl/shaders/false_color.glsl.
namespace floatstage::render::cpu {

std::array<float, 3> camera_color(int index);           ///< one colour a camera, the same from every view
std::array<float, 3> flow_color(float u, float v);      ///< hue: direction; full at 8 px
std::array<float, 3> heat_color(float amount);          ///< black, red, yellow, white over 0…1
std::array<float, 3> spacing_color(float spacing);      ///< white at 1, blue towards 1/4, red towards 4
std::array<float, 3> class_color(BlendClass of_blend);  ///< green sharp, blue blurred, red ghost

}  // namespace floatstage::render::cpu
