#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <string_view>

#include "render/gl/gl_objects.h"

namespace floatstage::render::gl {

/// The tiles of a level that hold something, and the work groups that are dispatched over them; made and read
/// by the GPU (shaders/flow_tiles.comp, flow.glsl).
class TileList {
 public:
  /// Forgets all tiles. At most `tiles` will be listed; each is worked on for up to `fields` fields.
  void begin(std::size_t tiles, int fields);
  GLuint id() const { return buffer_.id(); }

 private:
  Buffer buffer_;
  std::size_t capacity_ = 0;
};

/// A compute shader with what it is run on. Textures are read at units 1, 2, … and written at image units 0,
/// 1, … (null or without storage: a unit that this run does not read); unit 0 and the first storage buffer
/// belong to the scene (Projection). Every run() is finished for those that follow.
class Kernel {
 public:
  static Result<Kernel> create(std::string_view shader, std::initializer_list<std::string_view> shared);

  Kernel& set(GLint location, int value);
  Kernel& set(GLint location, float value);
  Kernel& set(GLint location, int x, int y);
  Kernel& set(GLint location, float x, float y, float z, float w);
  Kernel& set(GLint location, float x, float y);
  Kernel& set(GLint location, const std::array<float, 3>& v);

  using Textures = std::initializer_list<const Texture*>;
  /// `x` * `y` * `z` work groups, which stand for `pixels` pixels.
  void run(Textures read, Textures written, int x, int y, int z, std::size_t pixels) const;
  /// One invocation of local size 8x8 for each of `width` * `height` pixels (shaders/window.glsl).
  void over(int width, int height, Textures read, Textures written) const;
  /// As many as the list says.
  void run(Textures read, Textures written, const TileList& tiles, std::size_t pixels) const;

 private:
  void bind(Textures read, Textures written, std::size_t pixels) const;
  Program program_;
};

/// How many work groups of `side` px cover `size` px.
constexpr int groups_over(int size, int side) { return (size + side - 1) / side; }

/// Of one texel.
std::size_t bytes_of(GLenum format);

}  // namespace floatstage::render::gl
