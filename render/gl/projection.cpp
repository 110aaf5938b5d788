#include "render/gl/projection.h"

#include <algorithm>
#include <cmath>

#include "render/footprint.h"

namespace floatstage::render {
namespace {

constexpr float kNothing = 1e30F;  // shaders/view.glsl has the same

Eigen::Matrix4d clip_from_view(const View& view) {
  const CameraModel& m = view.model;
  const double n = view.near_plane, f = view.far_plane;
  Eigen::Matrix4d clip;
  clip << 2 * m.fx / m.width, 2 * m.skew / m.width, 2 * m.cx / m.width - 1, 0,  //
      0, -2 * m.fy / m.height, 1 - 2 * m.cy / m.height, 0,                      // y up in clip space
      0, 0, f / (f - n), -f * n / (f - n),                                      //
      0, 0, 1, 0;
  return clip;
}

/// From clip coordinates of the whole view to those of a window of it.
Eigen::Matrix4d window_clip(const View& view, const Window& w) {
  const double sx = static_cast<double>(view.model.width) / w.width,
               sy = static_cast<double>(view.model.height) / w.height;
  Eigen::Matrix4d clip = Eigen::Matrix4d::Identity();
  clip(0, 0) = sx;
  clip(0, 3) = sx - 1 - 2.0 * w.x / w.width;
  clip(1, 1) = sy;
  clip(1, 3) = 1 - sy + 2.0 * w.y / w.height;
  return clip;
}

std::array<float, 16> columns(const Eigen::Matrix4d& m) {
  std::array<float, 16> a{};
  Eigen::Map<Eigen::Matrix4f>(a.data()) = m.cast<float>();
  return a;
}

float f(double v) { return static_cast<float>(v); }

}  // namespace

void set_draw_buffers(const gl::Framebuffer& framebuffer, int count) {
  std::array<GLenum, 8> buffers{};
  for (std::size_t i = 0; i < buffers.size(); ++i) buffers[i] = GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(i);
  glNamedFramebufferDrawBuffers(framebuffer.id(), count, buffers.data());
}

Result<Projection> Projection::create() {
  Projection p;
  struct Wanted {
    gl::Program* program;
    std::string_view vertex, fragment;
  };
  for (const Wanted& w : {Wanted{&p.depth_map_, "depth_map.vert", "depth_map.frag"},
                          Wanted{&p.proxy_, "proxy.vert", "proxy.frag"},
                          Wanted{&p.visibility_pass_, "fullscreen.vert", "visibility.frag"},
                          Wanted{&p.hidden_pass_, "fullscreen.vert", "hidden.frag"},
                          Wanted{&p.soft_rows_, "fullscreen.vert", "soft_rows.frag"},
                          Wanted{&p.weights_pass_, "fullscreen.vert", "weights.frag"}}) {
    Result<gl::Program> program = gl::make_program(w.vertex, w.fragment, {"view.glsl", "camera.glsl"});
    if (!program) return forward(program);
    *w.program = std::move(*program);
  }
  Result<Outline> outline = Outline::create();
  if (!outline) return forward(outline);
  p.outline_ = std::move(*outline);
  p.no_vertices_ = gl::VertexArray::create();
  for (gl::Framebuffer* target :
       {&p.surface_target_, &p.visibility_target_, &p.hidden_target_, &p.rows_target_, &p.weights_target_})
    *target = gl::Framebuffer::create();
  return p;
}

void Projection::reserve() {
  const int w = window_.width, h = window_.height;
  if (surface_.reserve(GL_RGBA32F, GL_NEAREST, w, h))
    glNamedFramebufferTexture(surface_target_.id(), GL_COLOR_ATTACHMENT0, surface_.id(), 0);
  if (z_buffer_.reserve(GL_DEPTH_COMPONENT32F, GL_NEAREST, w, h))
    glNamedFramebufferTexture(surface_target_.id(), GL_DEPTH_ATTACHMENT, z_buffer_.id(), 0);
  if (visibility_.reserve(GL_RG32UI, GL_NEAREST, w, h))
    glNamedFramebufferTexture(visibility_target_.id(), GL_COLOR_ATTACHMENT0, visibility_.id(), 0);
  if (hidden_.reserve(GL_R8UI, GL_NEAREST, w, h))
    glNamedFramebufferTexture(hidden_target_.id(), GL_COLOR_ATTACHMENT0, hidden_.id(), 0);
  if (row_distances_.reserve(GL_RG32UI, GL_NEAREST, w, h))
    glNamedFramebufferTexture(rows_target_.id(), GL_COLOR_ATTACHMENT0, row_distances_.id(), 0);
  for (int i = 0; i < 2; ++i) {
    const auto n = static_cast<std::size_t>(i);
    const GLenum place = static_cast<GLenum>(i);
    if (angular_[n].reserve(GL_RGBA16F, GL_NEAREST, w, h))
      glNamedFramebufferTexture(visibility_target_.id(), GL_COLOR_ATTACHMENT1 + place, angular_[n].id(), 0);
    if (weights_[n].reserve(GL_RGBA16F, GL_NEAREST, w, h))
      glNamedFramebufferTexture(weights_target_.id(), GL_COLOR_ATTACHMENT0 + place, weights_[n].id(), 0);
    if (soft_[n].reserve(GL_RGBA16F, GL_LINEAR, w, h))
      glNamedFramebufferTexture(weights_target_.id(), GL_COLOR_ATTACHMENT2 + place, soft_[n].id(), 0);
  }
  if (mattes_.reserve(GL_RG8, GL_NEAREST, w, h))
    glNamedFramebufferTexture(visibility_target_.id(), GL_COLOR_ATTACHMENT3, mattes_.id(), 0);
  set_draw_buffers(visibility_target_, 4);
  set_draw_buffers(weights_target_, 4);
}

void Projection::write_uniforms(const SceneTextures& scene, const View& view, const RendererOptions& options,
                                bool one_camera) {
  const CameraModel& m = view.model;
  ViewBlock block{};
  block.clip_from_world =
      columns(window_clip(view, window_) * clip_from_view(view) * view.view_from_world.matrix());
  block.world_from_view = columns(view.view_from_world.inverse().matrix());
  const Eigen::Vector3d eye = view.view_from_world.center();
  block.view_center = {f(eye.x()), f(eye.y()), f(eye.z()), 1};
  block.view_k = {f(m.fx), f(m.fy), f(m.cx), f(m.cy)};
  block.window = {f(window_.x), f(window_.y), f(window_.width), f(window_.height)};
  const double tolerance = depth_tolerance(scene.scene->box);
  block.settings = {f(m.skew), f(options.soft_radius), f(tolerance), f(options.flow.shrink)};
  block.background = {options.background[0], options.background[1], options.background[2],
                      options.sharp ? 0.F : 1.F};
  block.counts = {static_cast<int>(choice_.listed.size()), static_cast<int>(choice_.chosen),
                  one_camera ? 1 : 0, static_cast<int>(options.output)};
  for (std::size_t i = 0; i < choice_.listed.size(); ++i) {
    block.camera_list[i / 4][i % 4] = choice_.listed[i];
    block.camera_fade[i] = {choice_.fade[i], choice_.stand_in_fade[i], static_cast<float>(deepest_[i]), 0};
  }
  gl::upload(uniforms_, uniform_capacity_, &block, sizeof block);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, uniforms_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, scene.camera_buffer.id());
  glBindTextureUnit(0, scene.photographs.id());
}

void Projection::find_deepest(const SceneTextures& scene, const View& view, bool levels) {
  ShortList<int, kMostListed> with_levels;
  for (std::size_t slot = 0; slot < choice_.listed.size(); ++slot) {
    const int camera = choice_.listed[slot];
    deepest_[slot] =
        deepest_level(scene.scene->cameras[static_cast<std::size_t>(camera)], view, scene.scene->box);
    if (levels || deepest_[slot] > 0) with_levels.push_back(camera);
  }
  scene.ensure_levels({with_levels.begin(), with_levels.end()});
}

void Projection::run(const SceneTextures& scene, const View& view, const RendererOptions& options, int margin,
                     bool one_camera, bool levels) {
  choice_ = scene.scene->choose(view, options.cameras);
  window_ = window_of(view, scene.scene->mesh.positions, scene.scene->vertex_blocks, margin);
  if (window_.empty()) return;
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDisable(GL_SCISSOR_TEST);
  scene.depth_maps.ensure(choice_.listed, depth_map_.id(), scene.mesh.id(), scene.indices);
  reserve();
  find_deepest(scene, view, levels);
  write_uniforms(scene, view, options, one_camera);

  const float nothing[4] = {0, 0, 0, kNothing}, one = 1;
  glClearNamedFramebufferfv(surface_target_.id(), GL_COLOR, 0, nothing);
  glClearNamedFramebufferfv(surface_target_.id(), GL_DEPTH, 0, &one);
  glBindFramebuffer(GL_FRAMEBUFFER, surface_target_.id());
  glViewport(0, 0, window_.width, window_.height);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glUseProgram(proxy_.id());
  glBindVertexArray(scene.mesh.id());
  glDrawElements(GL_TRIANGLES, scene.indices, GL_UNSIGNED_INT, nullptr);
  glDisable(GL_DEPTH_TEST);

  draw(visibility_target_.id(), visibility_pass_, {surface_.id(), scene.depth_maps.texture()});
  draw(hidden_target_.id(), hidden_pass_, {visibility_.id()});
  draw(rows_target_.id(), soft_rows_, {hidden_.id()});
  draw(weights_target_.id(), weights_pass_,
       {visibility_.id(), row_distances_.id(), angular_[0].id(), angular_[1].id()});
}

void Projection::draw(GLuint framebuffer, const gl::Program& program,
                      std::initializer_list<GLuint> textures) const {
  draw_at(framebuffer, program, textures, 0, 0, window_.width, window_.height);
}

void Projection::draw_at(GLuint framebuffer, const gl::Program& program,
                         std::initializer_list<GLuint> textures, int x, int y, int width, int height) const {
  GLuint unit = 1;
  for (GLuint texture : textures) glBindTextureUnit(unit++, texture);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(x, y, width, height);
  glUseProgram(program.id());
  glBindVertexArray(no_vertices_.id());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

void ViewTarget::begin(int width, int height, const std::array<float, 3>& background) {
  clear(0, width, height, background);
}

GLuint ViewTarget::begin_again(const std::array<float, 3>& background) {
  clear(1, colors_[0].width(), colors_[0].height(), background);
  return colors_[0].id();
}

void ViewTarget::clear(std::size_t which, int width, int height, const std::array<float, 3>& background) {
  last_ = which;
  gl::Framebuffer& framebuffer = framebuffers_[which];
  if (!framebuffer) framebuffer = gl::Framebuffer::create();
  if (colors_[which].resize(GL_RGBA8, GL_LINEAR, width, height))
    glNamedFramebufferTexture(framebuffer.id(), GL_COLOR_ATTACHMENT0, colors_[which].id(), 0);
  const float clear[4] = {background[0], background[1], background[2], 0};
  glClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, clear);
}

}  // namespace floatstage::render
