#include "render/gl/projection.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.h"
#include "render/gl/scene_textures_impl.h"

namespace floatstage::render {
namespace {

constexpr int kWindowGrid = 16;             // px
constexpr double kToleranceShare = 0.0125;  // of the proxy's diagonal: the automatic depth tolerance
constexpr float kNothing = 1e30F;           // shaders/view.glsl has the same

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

Result<void> check(const View& view) {
  if (!std::holds_alternative<std::monostate>(view.model.lens))
    return fail(ErrorCode::InvalidArgument,
                "the view has a lens; a virtual camera is a pinhole: pass pinhole(model)");
  if (Result<void> ok = check(view.model); !ok)
    return fail(ErrorCode::InvalidArgument, text("the view: ", ok.error().message));
  if (!(view.near_plane > 0) || !(view.far_plane > view.near_plane) || !std::isfinite(view.far_plane))
    return fail(ErrorCode::InvalidArgument, text("the view's planes ", view.near_plane, " and ",
                                                 view.far_plane, " m are not 0 < near < far"));
  if (!view.view_from_world.translation.allFinite() || !view.view_from_world.rotation.coeffs().allFinite() ||
      std::abs(view.view_from_world.rotation.norm() - 1) > 1e-6)
    return fail(ErrorCode::InvalidArgument, "the view's transform is not a finite rotation and translation");
  return {};
}

Window window_of(const View& view, const std::vector<Eigen::Vector3f>& positions, int margin) {
  const CameraModel& m = view.model;
  const Eigen::Matrix<float, 3, 4> transform =
      (Eigen::Matrix4d() << m.k(), Eigen::Vector3d::Zero(), 0, 0, 0, 1)
          .finished()
          .topRows<3>()
          .cast<float>() *
      view.view_from_world.matrix().cast<float>();
  const float near_plane = f(view.near_plane), infinity = std::numeric_limits<float>::infinity();
  float low_x = infinity, low_y = infinity, high_x = -infinity, high_y = -infinity;
  bool crosses_near = false;
  for (const Eigen::Vector3f& position : positions) {
    const Eigen::Vector3f p = transform * position.homogeneous();
    if (p.z() < near_plane) {
      crosses_near = true;
      continue;
    }
    const float x = p.x() / p.z(), y = p.y() / p.z();
    low_x = std::min(low_x, x);
    low_y = std::min(low_y, y);
    high_x = std::max(high_x, x);
    high_y = std::max(high_y, y);
  }
  if (!(low_x <= high_x)) return {};
  if (crosses_near) {  // what is cut at the near plane can cover anything
    low_x = low_y = 0;
    high_x = f(m.width);
    high_y = f(m.height);
  }
  auto down = [](float v) { return static_cast<int>(std::floor(v / kWindowGrid)) * kWindowGrid; };
  auto up = [](float v) { return static_cast<int>(std::ceil(v / kWindowGrid)) * kWindowGrid; };
  const float grow = static_cast<float>(margin);
  const float x0 = std::clamp(low_x, 0.F, f(m.width)) - grow, x1 = std::clamp(high_x, 0.F, f(m.width)) + grow;
  const float y0 = std::clamp(low_y, 0.F, f(m.height)) - grow,
              y1 = std::clamp(high_y, 0.F, f(m.height)) + grow;
  if (high_x < -grow || low_x > f(m.width) + grow || high_y < -grow || low_y > f(m.height) + grow) return {};
  const int left = down(x0), top = down(y0);
  return {left, top, up(x1) - left, up(y1) - top};
}

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
                          Wanted{&p.soft_rows_, "fullscreen.vert", "soft_rows.frag"},
                          Wanted{&p.weights_pass_, "fullscreen.vert", "weights.frag"}}) {
    Result<gl::Program> program = gl::make_program(w.vertex, w.fragment, {"view.glsl", "camera.glsl"});
    if (!program) return forward(program);
    *w.program = std::move(*program);
  }
  p.no_vertices_ = gl::VertexArray::create();
  for (gl::Framebuffer* target :
       {&p.surface_target_, &p.visibility_target_, &p.rows_target_, &p.weights_target_})
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
  set_draw_buffers(visibility_target_, 3);
  set_draw_buffers(weights_target_, 4);
}

void Projection::write_uniforms(const SceneTextures& scene, const View& view, const RendererOptions& options,
                                bool one_camera) {
  const SceneTextures::Impl& s = scene.impl();
  const CameraModel& m = view.model;
  ViewBlock block{};
  block.clip_from_world =
      columns(window_clip(view, window_) * clip_from_view(view) * view.view_from_world.matrix());
  block.world_from_view = columns(view.view_from_world.inverse().matrix());
  const Eigen::Vector3d eye = view.view_from_world.center();
  block.view_center = {f(eye.x()), f(eye.y()), f(eye.z()), 1};
  block.view_k = {f(m.fx), f(m.fy), f(m.cx), f(m.cy)};
  block.window = {f(window_.x), f(window_.y), f(window_.width), f(window_.height)};
  const double tolerance = options.depth_tolerance > 0
                               ? options.depth_tolerance
                               : kToleranceShare * static_cast<double>(s.box.diagonal().norm());
  block.settings = {f(m.skew), f(options.soft_radius), f(tolerance), f(options.flow.shrink)};
  block.background = {options.background[0], options.background[1], options.background[2],
                      options.sharp ? 0.F : 1.F};
  block.counts = {static_cast<int>(choice_.listed.size()), static_cast<int>(choice_.chosen),
                  one_camera ? 1 : 0, static_cast<int>(options.output)};
  for (std::size_t i = 0; i < choice_.listed.size(); ++i) {
    block.camera_list[i / 4][i % 4] = choice_.listed[i];
    block.camera_fade[i] = {choice_.fade[i], choice_.stand_in_fade[i], 0, 0};
  }
  gl::upload(uniforms_, uniform_capacity_, &block, sizeof block);
  glBindBufferBase(GL_UNIFORM_BUFFER, 0, uniforms_.id());
  glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, s.camera_buffer.id());
  glBindTextureUnit(0, s.photographs.id());
}

void Projection::run(const SceneTextures& scene, const View& view, const RendererOptions& options, int margin,
                     bool one_camera) {
  const SceneTextures::Impl& s = scene.impl();
  choice_ = s.choose(view, options.cameras);
  window_ = window_of(view, s.positions, margin);
  if (window_.empty()) return;
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDisable(GL_SCISSOR_TEST);
  s.depth_maps.ensure(choice_.listed, depth_map_.id(), s.mesh.id(), s.indices);
  reserve();
  write_uniforms(scene, view, options, one_camera);

  const float nothing[4] = {0, 0, 0, kNothing}, one = 1;
  glClearNamedFramebufferfv(surface_target_.id(), GL_COLOR, 0, nothing);
  glClearNamedFramebufferfv(surface_target_.id(), GL_DEPTH, 0, &one);
  glBindFramebuffer(GL_FRAMEBUFFER, surface_target_.id());
  glViewport(0, 0, window_.width, window_.height);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glUseProgram(proxy_.id());
  glBindVertexArray(s.mesh.id());
  glDrawElements(GL_TRIANGLES, s.indices, GL_UNSIGNED_INT, nullptr);
  glDisable(GL_DEPTH_TEST);

  draw(visibility_target_.id(), visibility_pass_, {surface_.id(), s.depth_maps.texture()});
  draw(rows_target_.id(), soft_rows_, {visibility_.id()});
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
  if (!framebuffer_) framebuffer_ = gl::Framebuffer::create();
  if (color_.resize(GL_RGBA8, GL_LINEAR, width, height))
    glNamedFramebufferTexture(framebuffer_.id(), GL_COLOR_ATTACHMENT0, color_.id(), 0);
  const float clear[4] = {background[0], background[1], background[2], 0};
  glClearNamedFramebufferfv(framebuffer_.id(), GL_COLOR, 0, clear);
}

}  // namespace floatstage::render
