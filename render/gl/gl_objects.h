#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>

#include <epoxy/gl.h>

#include "core/result.h"

// Owners of OpenGL objects, private to render/. All calls on the GL thread.
namespace floatstage::render::gl {

/// Owns one object name; Kind::create and Kind::destroy make and free it.
template <class Kind>
class Object {
 public:
  Object() = default;
  Object(Object&& o) noexcept : id_(std::exchange(o.id_, 0)) {}
  Object& operator=(Object&& o) noexcept {
    std::swap(id_, o.id_);
    return *this;
  }
  ~Object() {
    if (id_ != 0) Kind::destroy(id_);
  }

  static Object create() {
    Object o;
    o.id_ = Kind::create();
    return o;
  }
  GLuint id() const { return id_; }
  explicit operator bool() const { return id_ != 0; }

 private:
  GLuint id_ = 0;
};

struct BufferKind {
  static GLuint create();
  static void destroy(GLuint id);
};
struct VertexArrayKind {
  static GLuint create();
  static void destroy(GLuint id);
};
struct FramebufferKind {
  static GLuint create();
  static void destroy(GLuint id);
};
struct ProgramKind {
  static GLuint create();
  static void destroy(GLuint id);
};
using Buffer = Object<BufferKind>;
using VertexArray = Object<VertexArrayKind>;
using Framebuffer = Object<FramebufferKind>;
using Program = Object<ProgramKind>;

/// A GL_TEXTURE_2D (layers == 0) or GL_TEXTURE_2D_ARRAY with immutable storage, one level, clamped to its
/// edge; or one of several samples a pixel.
class Texture {
 public:
  Texture() = default;
  Texture(Texture&& o) noexcept { swap(o); }
  Texture& operator=(Texture&& o) noexcept {
    swap(o);
    return *this;
  }
  ~Texture();

  /// Makes storage of at least this size; keeps what it has when format, filter and layers agree and it is
  /// large enough (so sizes that vary a little from view to view do not reallocate). True when storage is
  /// new.
  bool reserve(GLenum format, GLenum filter, int width, int height, int layers = 0);
  /// The same with that many samples a pixel: a GL_TEXTURE_2D_MULTISAMPLE.
  bool reserve_samples(GLenum format, int samples, int width, int height);
  /// Makes storage of exactly this size, kept when nothing changes. True when storage is new.
  bool resize(GLenum format, GLenum filter, int width, int height, int layers = 0);

  GLuint id() const { return id_; }
  GLenum format() const { return format_; }
  int width() const { return width_; }
  int height() const { return height_; }
  int layers() const { return layers_; }

 private:
  void swap(Texture& o);
  static int rounded_up(int n);
  void allocate(GLenum format, GLenum filter, int width, int height, int layers);
  GLuint id_ = 0;
  GLenum format_ = 0, filter_ = 0;
  int width_ = 0, height_ = 0, layers_ = 0;
};

/// Compiles and links embedded shaders (names as in render/gl/shaders). `preamble` comes after the #version
/// line, then the shared files named in `shared`. Unsupported with the compiler's own message.
Result<Program> make_program(std::string_view vertex, std::string_view fragment,
                             std::initializer_list<std::string_view> shared = {});

/// The same for a compute shader.
Result<Program> make_compute_program(std::string_view compute,
                                     std::initializer_list<std::string_view> shared = {});

/// Copies bytes into a buffer, growing its storage when needed. `capacity` is what the buffer holds.
void upload(Buffer& buffer, std::size_t& capacity, const void* data, std::size_t size);

}  // namespace floatstage::render::gl
