#pragma once

#include <string_view>

namespace floatstage::render::gl {

/// The text of render/gl/shaders/<name>, compiled into the program; an unknown name is our bug.
std::string_view shader_text(std::string_view name);

}  // namespace floatstage::render::gl
