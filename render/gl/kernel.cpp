#include "render/gl/kernel.h"

#include <algorithm>
#include <array>

#include "core/check.h"
#include "render/stage_times.h"

namespace floatstage::render::gl {
namespace {

constexpr int kWindowGroup = 8;     // px: shaders/window.glsl has the same
constexpr GLuint kTileBinding = 2;  // shaders/flow.glsl has the same
constexpr GLbitfield kFinished = GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT |
                                 GL_SHADER_STORAGE_BARRIER_BIT | GL_COMMAND_BARRIER_BIT |
                                 GL_TEXTURE_UPDATE_BARRIER_BIT | GL_BUFFER_UPDATE_BARRIER_BIT;

}  // namespace

std::size_t bytes_of(GLenum format) {
  switch (format) {
    case GL_R8:
    case GL_R8UI:
      return 1;
    case GL_RG8:
    case GL_RG8UI:
    case GL_R16UI:
      return 2;
    case GL_R32F:
    case GL_RG16F:
    case GL_RG16UI:
    case GL_RG16_SNORM:
    case GL_RGBA8:
      return 4;
    case GL_RG32F:
    case GL_RG32UI:
    case GL_RGBA16F:
      return 8;
    case GL_RGBA32F:
      return 16;
    default:
      FLOATSTAGE_CHECK(false, "a format that kernels do not use");
      return 0;
  }
}

void TileList::begin(std::size_t tiles, int fields) {
  const std::array<GLuint, 4> header = {0, 0, static_cast<GLuint>(fields), 0};
  const std::size_t size = sizeof header + tiles * sizeof(GLuint);
  if (!buffer_ || capacity_ < size) {
    buffer_ = Buffer::create();
    glNamedBufferStorage(buffer_.id(), static_cast<GLsizeiptr>(size), nullptr, GL_DYNAMIC_STORAGE_BIT);
    capacity_ = size;
  }
  glNamedBufferSubData(buffer_.id(), 0, sizeof header, header.data());
}

Result<Kernel> Kernel::create(std::string_view shader, std::initializer_list<std::string_view> shared) {
  Result<Program> program = make_compute_program(shader, shared);
  if (!program) return forward(program);
  Kernel kernel;
  kernel.program_ = std::move(*program);
  return kernel;
}

Kernel& Kernel::set(GLint location, int value) {
  glProgramUniform1i(program_.id(), location, value);
  return *this;
}
Kernel& Kernel::set(GLint location, float value) {
  glProgramUniform1f(program_.id(), location, value);
  return *this;
}
Kernel& Kernel::set(GLint location, int x, int y) {
  glProgramUniform2i(program_.id(), location, x, y);
  return *this;
}
Kernel& Kernel::set(GLint location, float x, float y, float z, float w) {
  glProgramUniform4f(program_.id(), location, x, y, z, w);
  return *this;
}
Kernel& Kernel::set(GLint location, const std::array<float, 3>& v) {
  glProgramUniform3fv(program_.id(), location, 1, v.data());
  return *this;
}
Kernel& Kernel::set(GLint location, float x, float y) {
  glProgramUniform2f(program_.id(), location, x, y);
  return *this;
}

void Kernel::bind(Textures read, Textures written, std::size_t pixels) const {
  std::size_t bytes = 0;
  GLuint unit = 1;
  for (const Texture* texture : read) {
    const bool there = texture != nullptr && texture->id() != 0;
    glBindTextureUnit(unit++, there ? texture->id() : 0);
    if (there) bytes += bytes_of(texture->format());
  }
  unit = 0;
  for (const Texture* texture : written) {
    glBindImageTexture(unit++, texture->id(), 0, GL_TRUE, 0, GL_WRITE_ONLY, texture->format());
    bytes += bytes_of(texture->format());
  }
  glUseProgram(program_.id());
  StageTimes::count(bytes * pixels);
}

void Kernel::run(Textures read, Textures written, int x, int y, int z, std::size_t pixels) const {
  bind(read, written, pixels);
  glDispatchCompute(static_cast<GLuint>(x), static_cast<GLuint>(y), static_cast<GLuint>(z));
  glMemoryBarrier(kFinished);
}

void Kernel::over(int width, int height, Textures read, Textures written) const {
  run(read, written, (width + kWindowGroup - 1) / kWindowGroup, (height + kWindowGroup - 1) / kWindowGroup, 1,
      static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

void Kernel::run(Textures read, Textures written, const TileList& tiles, std::size_t pixels) const {
  bind(read, written, pixels);
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, kTileBinding, tiles.id());
  glBindBuffer(GL_DISPATCH_INDIRECT_BUFFER, tiles.id());
  glDispatchComputeIndirect(0);
  glMemoryBarrier(kFinished);
}

}  // namespace floatstage::render::gl
