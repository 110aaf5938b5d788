#include "render/gl/depth_maps.h"

#include <algorithm>

namespace floatstage::render {
namespace {

constexpr int kLargestSide = 2048;  // texels
constexpr int kStep = 64;           // texels
constexpr float kNothing = 1e30F;   // shaders/view.glsl has the same

}  // namespace

void DepthMaps::plan(const std::vector<CameraBlock>& blocks, const std::vector<DepthWindow>& windows) {
  planned_.clear();
  width_ = height_ = 1;
  for (std::size_t i = 0; i < windows.size(); ++i) {
    planned_.push_back({blocks[i].cam_from_world, windows[i]});
    width_ = std::max(width_, windows[i].width);
    height_ = std::max(height_, windows[i].height);
  }
  // In steps: a subject that moves changes the size with every instant, and new storage costs more than the
  // maps.
  auto in_steps = [](int n) { return std::min((n + kStep - 1) / kStep * kStep, kLargestSide); };
  width_ = in_steps(width_);
  height_ = in_steps(height_);
}

void DepthMaps::ensure(std::span<const int> wanted, GLuint program, GLuint mesh, GLsizei indices) {
  if (maps_.resize(GL_R32F, GL_NEAREST, width_, height_, static_cast<int>(planned_.size())))
    for (Map& m : planned_) m.rendered = false;
  z_buffer_.resize(GL_DEPTH_COMPONENT32F, GL_NEAREST, width_, height_);
  if (!framebuffer_) framebuffer_ = gl::Framebuffer::create();
  for (int i : wanted) {
    Map& m = planned_[static_cast<std::size_t>(i)];
    if (m.rendered) continue;
    m.rendered = true;
    glNamedFramebufferTextureLayer(framebuffer_.id(), GL_COLOR_ATTACHMENT0, maps_.id(), 0, i);
    glNamedFramebufferTexture(framebuffer_.id(), GL_DEPTH_ATTACHMENT, z_buffer_.id(), 0);
    const float nothing[4] = {kNothing, 0, 0, 0}, one = 1;
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    glClearBufferfv(GL_COLOR, 0, nothing);
    glClearBufferfv(GL_DEPTH, 0, &one);
    glViewport(0, 0, width_, height_);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glUseProgram(program);
    glUniformMatrix4fv(0, 1, GL_FALSE, m.cam_from_world.data());
    glUniform4fv(1, 1, m.window.place.data());
    glUniform4f(2, static_cast<float>(width_), static_cast<float>(height_), m.window.near_plane,
                m.window.far_plane);
    glBindVertexArray(mesh);
    glDrawElements(GL_TRIANGLES, indices, GL_UNSIGNED_INT, nullptr);
    glDisable(GL_DEPTH_TEST);
  }
}

}  // namespace floatstage::render
