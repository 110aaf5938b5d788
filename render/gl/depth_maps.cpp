#include "render/gl/depth_maps.h"

#include <algorithm>
#include <cmath>

namespace floatstage::render {
namespace {

constexpr double kGuardPixels = 4;  // around the picture: the test at its border reads a full neighbourhood
constexpr int kLargestSide = 2048;  // texels
constexpr int kStep = 64;           // texels
constexpr float kNothing = 1e30F;   // shaders/view.glsl has the same

}  // namespace

void DepthMaps::plan(const std::vector<RigCamera>& cameras, const Eigen::AlignedBox3f& box,
                     std::vector<CameraBlock>& blocks) {
  windows_.assign(cameras.size(), {});
  width_ = height_ = 1;
  const Eigen::Vector3d middle = box.center().cast<double>();
  const double radius = 0.5 * static_cast<double>(box.diagonal().norm()) + 1e-6;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const RigCamera& camera = cameras[i];
    const Eigen::AlignedBox2d bounds = pinhole_bounds(camera, box, kGuardPixels);
    // One texel a photograph pixel: finer shows nothing that the photograph has, coarser blurs occlusion
    // borders.
    const Eigen::Vector2d extent = bounds.sizes();
    const double scale = std::min(
        {std::max(camera.model.fx, camera.model.fy), kLargestSide / extent.x(), kLargestSide / extent.y()});
    width_ = std::max(width_, static_cast<int>(std::ceil(extent.x() * scale)));
    height_ = std::max(height_, static_cast<int>(std::ceil(extent.y() * scale)));
    const Eigen::Vector2d offset = -bounds.min() * scale;
    Window& w = windows_[i];
    w.place = {static_cast<float>(scale), static_cast<float>(scale), static_cast<float>(offset.x()),
               static_cast<float>(offset.y())};
    w.cam_from_world = blocks[i].cam_from_world;
    const double z = (camera.cam_from_world * middle).z();
    w.far_plane = static_cast<float>(std::max(z + radius, radius));
    w.near_plane = static_cast<float>(std::max(z - radius, 1e-3 * radius));
    blocks[i].depth = w.place;
  }
  // In steps: a subject that moves changes the size with every instant, and new storage costs more than the
  // maps.
  auto in_steps = [](int n) { return std::min((n + kStep - 1) / kStep * kStep, kLargestSide); };
  width_ = in_steps(width_);
  height_ = in_steps(height_);
}

void DepthMaps::ensure(const std::vector<int>& wanted, GLuint program, GLuint mesh, GLsizei indices) {
  if (maps_.resize(GL_R32F, GL_NEAREST, width_, height_, static_cast<int>(windows_.size())))
    for (Window& w : windows_) w.rendered = false;
  z_buffer_.resize(GL_DEPTH_COMPONENT32F, GL_NEAREST, width_, height_);
  if (!framebuffer_) framebuffer_ = gl::Framebuffer::create();
  for (int i : wanted) {
    Window& w = windows_[static_cast<std::size_t>(i)];
    if (w.rendered) continue;
    w.rendered = true;
    glNamedFramebufferTextureLayer(framebuffer_.id(), GL_COLOR_ATTACHMENT0, maps_.id(), 0, i);
    glNamedFramebufferTexture(framebuffer_.id(), GL_DEPTH_ATTACHMENT, z_buffer_.id(), 0);
    const float nothing[4] = {kNothing, 0, 0, 0}, one = 1;
    glClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, nothing);
    glClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &one);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    glViewport(0, 0, width_, height_);
    glEnable(GL_DEPTH_TEST);
    glDepthFunc(GL_LESS);
    glUseProgram(program);
    glUniformMatrix4fv(0, 1, GL_FALSE, w.cam_from_world.data());
    glUniform4fv(1, 1, w.place.data());
    glUniform4f(2, static_cast<float>(width_), static_cast<float>(height_), w.near_plane, w.far_plane);
    glBindVertexArray(mesh);
    glDrawElements(GL_TRIANGLES, indices, GL_UNSIGNED_INT, nullptr);
    glDisable(GL_DEPTH_TEST);
  }
}

}  // namespace floatstage::render
