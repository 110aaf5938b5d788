#include "render/gl/outline.h"

#include "render/gl/projection.h"
#include "render/stage_times.h"

namespace floatstage::render {
namespace {

constexpr int kSamples = 4;  // a pixel, where render/cpu/cover_kernels.h has them: the pattern of every GPU

}  // namespace

Result<Outline> Outline::create() {
  Outline o;
  Result<gl::Program> coverage = gl::make_program("coverage.vert", "coverage.frag", {"view.glsl"});
  if (!coverage) return forward(coverage);
  Result<gl::Kernel> outline =
      gl::Kernel::create("outline.comp", {"view.glsl", "picture.glsl", "synchronize.glsl"});
  if (!outline) return forward(outline);
  o.coverage_ = std::move(*coverage);
  o.outline_ = std::move(*outline);
  o.samples_target_ = gl::Framebuffer::create();
  return o;
}

void Outline::draw_samples(const Projection& projection, const SceneTextures& scene) {
  const Window& w = projection.window();
  if (samples_.reserve_samples(GL_R8, kSamples, w.width, w.height))
    glNamedFramebufferTexture(samples_target_.id(), GL_COLOR_ATTACHMENT0, samples_.id(), 0);
  const float nothing[4] = {0, 0, 0, 0};
  glBindFramebuffer(GL_FRAMEBUFFER, samples_target_.id());
  glClearBufferfv(GL_COLOR, 0, nothing);
  glViewport(0, 0, w.width, w.height);
  glUseProgram(coverage_.id());
  projection.draw_proxy(scene);
}

void Outline::soften(const Projection& projection, const SceneTextures& scene, const RendererOptions& options,
                     ViewTarget& target) {
  if (!has_soft_outline(options)) return;
  StageTimes::enter("coverage");
  draw_samples(projection, scene);
  StageTimes::enter("outline");
  const gl::Texture& drawn = target.begin_again();
  projection.draw(outline_, {&projection.surface(), &samples_, &projection.mattes(), &drawn}, target);
}

}  // namespace floatstage::render
