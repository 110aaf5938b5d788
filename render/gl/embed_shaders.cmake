# cmake -DOUTPUT=file.cpp -DSHADERS="a;b" -P embed_shaders.cmake: writes shader_text() over the files' contents.
set(table "")
foreach(file IN LISTS SHADERS)
  get_filename_component(name "${file}" NAME)
  file(READ "${file}" content)
  string(APPEND table "  if (name == \"${name}\") return R\"glsl(${content})glsl\";\n")
endforeach()
file(WRITE "${OUTPUT}" "// Made by render/gl/embed_shaders.cmake from render/gl/shaders.
#include \"core/check.h\"
#include \"render/gl/shader_text.h\"

namespace floatstage::render::gl {

std::string_view shader_text(std::string_view name) {
${table}  FLOATSTAGE_CHECK(false, \"no embedded shader of this name\");
  return {};
}

}  // namespace floatstage::render::gl
")
