#include "render/gl/gl_objects.h"

#include <algorithm>
#include <vector>

#include "core/text.h"
#include "render/gl/shader_text.h"

namespace floatstage::render::gl {
namespace {

constexpr int kGranularity =
    64;  // px: storage sizes are rounded up, so that a moving crop seldom reallocates

Result<GLuint> compile(GLenum stage, std::string_view name, std::initializer_list<std::string_view> shared) {
  std::string source = "#version 450 core\n";
  for (std::string_view part : shared) source += shader_text(part);
  source += shader_text(name);
  const GLuint shader = glCreateShader(stage);
  const GLchar* text_pointer = source.c_str();
  glShaderSource(shader, 1, &text_pointer, nullptr);
  glCompileShader(shader);
  GLint ok = 0;
  glGetShaderiv(shader, GL_COMPILE_STATUS, &ok);
  if (ok) return shader;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  glDeleteShader(shader);
  return fail(ErrorCode::Unsupported, text("this OpenGL driver does not compile shader '", name, "': ", log));
}

/// Takes the shaders.
Result<Program> link(std::initializer_list<GLuint> shaders, const std::string& names) {
  Program program = Program::create();
  for (const GLuint shader : shaders) glAttachShader(program.id(), shader);
  glLinkProgram(program.id());
  for (const GLuint shader : shaders) glDeleteShader(shader);
  GLint ok = 0;
  glGetProgramiv(program.id(), GL_LINK_STATUS, &ok);
  if (ok) return program;
  std::string log(4096, '\0');
  GLsizei length = 0;
  glGetProgramInfoLog(program.id(), static_cast<GLsizei>(log.size()), &length, log.data());
  log.resize(static_cast<std::size_t>(length));
  return fail(ErrorCode::Unsupported, text("this OpenGL driver does not link shaders ", names, ": ", log));
}

}  // namespace

GLuint BufferKind::create() {
  GLuint id = 0;
  glCreateBuffers(1, &id);
  return id;
}
void BufferKind::destroy(GLuint id) { glDeleteBuffers(1, &id); }
GLuint VertexArrayKind::create() {
  GLuint id = 0;
  glCreateVertexArrays(1, &id);
  return id;
}
void VertexArrayKind::destroy(GLuint id) { glDeleteVertexArrays(1, &id); }
GLuint FramebufferKind::create() {
  GLuint id = 0;
  glCreateFramebuffers(1, &id);
  return id;
}
void FramebufferKind::destroy(GLuint id) { glDeleteFramebuffers(1, &id); }
GLuint ProgramKind::create() { return glCreateProgram(); }
void ProgramKind::destroy(GLuint id) { glDeleteProgram(id); }

Texture::~Texture() {
  if (id_ != 0) glDeleteTextures(1, &id_);
}

void Texture::swap(Texture& o) {
  std::swap(id_, o.id_);
  std::swap(format_, o.format_);
  std::swap(filter_, o.filter_);
  std::swap(width_, o.width_);
  std::swap(height_, o.height_);
  std::swap(layers_, o.layers_);
}

int Texture::rounded_up(int n) { return (n + kGranularity - 1) / kGranularity * kGranularity; }

void Texture::allocate(GLenum format, GLenum filter, int width, int height, int layers) {
  if (id_ != 0) glDeleteTextures(1, &id_);
  glCreateTextures(layers > 0 ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D, 1, &id_);
  if (layers > 0)
    glTextureStorage3D(id_, 1, format, width, height, layers);
  else
    glTextureStorage2D(id_, 1, format, width, height);
  glTextureParameteri(id_, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(filter));
  glTextureParameteri(id_, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(filter));
  glTextureParameteri(id_, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTextureParameteri(id_, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  format_ = format;
  filter_ = filter;
  width_ = width;
  height_ = height;
  layers_ = layers;
}

bool Texture::reserve(GLenum format, GLenum filter, int width, int height, int layers) {
  if (id_ != 0 && format == format_ && filter == filter_ && layers == layers_ && width <= width_ &&
      height <= height_)
    return false;
  const bool same_kind = format == format_ && layers == layers_;
  allocate(format, filter, std::max(rounded_up(width), same_kind ? width_ : 0),
           std::max(rounded_up(height), same_kind ? height_ : 0), layers);
  return true;
}

bool Texture::reserve_samples(GLenum format, int samples, int width, int height) {
  if (id_ != 0 && format == format_ && width <= width_ && height <= height_) return false;
  if (id_ != 0) glDeleteTextures(1, &id_);
  format_ = format;
  width_ = std::max(rounded_up(width), width_);
  height_ = std::max(rounded_up(height), height_);
  glCreateTextures(GL_TEXTURE_2D_MULTISAMPLE, 1, &id_);
  glTextureStorage2DMultisample(id_, samples, format, width_, height_, GL_TRUE);
  return true;
}

bool Texture::resize(GLenum format, GLenum filter, int width, int height, int layers) {
  if (id_ != 0 && format == format_ && filter == filter_ && layers == layers_ && width == width_ &&
      height == height_)
    return false;
  allocate(format, filter, width, height, layers);
  return true;
}

Result<Program> make_program(std::string_view vertex, std::string_view fragment,
                             std::initializer_list<std::string_view> shared) {
  const Result<GLuint> v = compile(GL_VERTEX_SHADER, vertex, shared);
  if (!v) return forward(v);
  const Result<GLuint> f = compile(GL_FRAGMENT_SHADER, fragment, shared);
  if (!f) {
    glDeleteShader(*v);
    return forward(f);
  }
  return link({*v, *f}, text("'", vertex, "' and '", fragment, "'"));
}

Result<Program> make_compute_program(std::string_view compute,
                                     std::initializer_list<std::string_view> shared) {
  const Result<GLuint> shader = compile(GL_COMPUTE_SHADER, compute, shared);
  if (!shader) return forward(shader);
  return link({*shader}, text("'", compute, "'"));
}

void upload(Buffer& buffer, std::size_t& capacity, const void* data, std::size_t size) {
  if (!buffer || capacity < size) {
    buffer = Buffer::create();
    // Also nothing at all has to have storage.
    capacity = std::max<std::size_t>(size, 1);
    glNamedBufferStorage(buffer.id(), static_cast<GLsizeiptr>(capacity), size > 0 ? data : nullptr,
                         GL_DYNAMIC_STORAGE_BIT);
  } else if (size > 0) {
    glNamedBufferSubData(buffer.id(), 0, static_cast<GLsizeiptr>(size), data);
  }
}

}  // namespace floatstage::render::gl
