#include "render/gl/outline.h"

#include <array>

#include "render/gl/projection.h"
#include "render/gl/stage_times.h"

namespace floatstage::render {
namespace {

/// Where a pixel's samples lie from its centre; render/cpu/cover_kernels.h has the same.
constexpr std::array<std::array<float, 2>, 4> kSamples = {
    {{-0.125F, -0.375F}, {0.375F, -0.125F}, {-0.375F, 0.125F}, {0.125F, 0.375F}}};

}  // namespace

Result<Outline> Outline::create() {
  Outline o;
  Result<gl::Program> coverage = gl::make_program("coverage.vert", "coverage.frag", {"view.glsl"});
  if (!coverage) return forward(coverage);
  Result<gl::Program> outline = gl::make_program("fullscreen.vert", "outline.frag", {"view.glsl"});
  if (!outline) return forward(outline);
  o.coverage_ = std::move(*coverage);
  o.outline_ = std::move(*outline);
  o.samples_target_ = gl::Framebuffer::create();
  return o;
}

void Outline::draw_samples(const Projection& projection, const SceneTextures& scene) {
  const Window& w = projection.window();
  if (samples_.reserve(GL_RGBA8, GL_NEAREST, w.width, w.height))
    glNamedFramebufferTexture(samples_target_.id(), GL_COLOR_ATTACHMENT0, samples_.id(), 0);
  const float nothing[4] = {0, 0, 0, 0};
  glClearNamedFramebufferfv(samples_target_.id(), GL_COLOR, 0, nothing);
  glBindFramebuffer(GL_FRAMEBUFFER, samples_target_.id());
  glViewport(0, 0, w.width, w.height);
  glUseProgram(coverage_.id());
  glBindVertexArray(scene.mesh.id());
  for (std::size_t s = 0; s < kSamples.size(); ++s) {
    // The proxy moves so that the sample comes to lie on the pixel's centre; y is up in clip space.
    glUniform2f(0, -2 * kSamples[s][0] / static_cast<float>(w.width),
                2 * kSamples[s][1] / static_cast<float>(w.height));
    glColorMask(s == 0, s == 1, s == 2, s == 3);
    glDrawElements(GL_TRIANGLES, scene.indices, GL_UNSIGNED_INT, nullptr);
  }
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void Outline::soften(const Projection& projection, const SceneTextures& scene, const RendererOptions& options,
                     ViewTarget& target) {
  if (!has_soft_outline(options)) return;
  gl::StageTimes::enter("outline");
  draw_samples(projection, scene);
  const GLuint drawn = target.begin_again(options.background);
  const Window& w = projection.window();
  glProgramUniform2i(outline_.id(), 0, w.x, w.y);
  projection.draw_at(target.framebuffer(), outline_,
                     {projection.surface(), samples_.id(), projection.mattes(), drawn}, w.x, w.y, w.width,
                     w.height);
}

}  // namespace floatstage::render
