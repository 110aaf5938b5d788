#include "render/gl/projection.h"

#include <algorithm>
#include <cmath>

#include "render/footprint.h"
#include "render/stage_times.h"

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

/// Whether all of a box lies between the view's planes: a closed proxy in it hides its back faces.
bool is_before(const View& view, const Eigen::AlignedBox3f& box) {
  for (int corner = 0; corner < 8; ++corner) {
    const auto type = static_cast<Eigen::AlignedBox3f::CornerType>(corner);
    const double z = (view.view_from_world * Eigen::Vector3d(box.corner(type).cast<double>())).z();
    if (!(z > view.near_plane && z < view.far_plane)) return false;
  }
  return true;
}

}  // namespace

Result<Projection> Projection::create() {
  Projection p;
  struct Raster {
    gl::Program* program;
    std::string_view vertex, fragment;
  };
  for (const Raster& w : {Raster{&p.depth_map_, "depth_map.vert", "depth_map.frag"},
                          Raster{&p.proxy_, "proxy.vert", "proxy.frag"}}) {
    Result<gl::Program> program = gl::make_program(w.vertex, w.fragment, {"view.glsl"});
    if (!program) return forward(program);
    *w.program = std::move(*program);
  }
  struct Pass {
    gl::Kernel* kernel;
    std::string_view shader;
    std::initializer_list<std::string_view> shared;
  };
  for (const Pass& w :
       {Pass{&p.visibility_pass_, "visibility.comp", {"view.glsl", "camera.glsl", "window.glsl"}},
        Pass{&p.soft_rows_, "soft_rows.comp", {"view.glsl", "synchronize.glsl"}},
        Pass{&p.weights_pass_, "weights.comp", {"view.glsl", "window.glsl"}}}) {
    Result<gl::Kernel> kernel = gl::Kernel::create(w.shader, w.shared);
    if (!kernel) return forward(kernel);
    *w.kernel = std::move(*kernel);
  }
  Result<Unseen> unseen = Unseen::create();
  if (!unseen) return forward(unseen);
  p.unseen_ = std::move(*unseen);
  Result<Outline> outline = Outline::create();
  if (!outline) return forward(outline);
  p.outline_ = std::move(*outline);
  p.surface_target_ = gl::Framebuffer::create();
  return p;
}

void Projection::reserve() {
  const int w = window_.width, h = window_.height;
  if (surface_.reserve(GL_RGBA32F, GL_NEAREST, w, h))
    glNamedFramebufferTexture(surface_target_.id(), GL_COLOR_ATTACHMENT0, surface_.id(), 0);
  if (z_buffer_.reserve(GL_DEPTH_COMPONENT32F, GL_NEAREST, w, h))
    glNamedFramebufferTexture(surface_target_.id(), GL_DEPTH_ATTACHMENT, z_buffer_.id(), 0);
  visibility_.reserve(GL_RG32UI, GL_NEAREST, w, h);
  row_distances_.reserve(GL_RG32UI, GL_NEAREST, w, h);
  mattes_.reserve(GL_RG8, GL_NEAREST, w, h);
  for (std::size_t i = 0; i < 2; ++i) {
    angular_[i].reserve(GL_RGBA16F, GL_NEAREST, w, h);
    weights_[i].reserve(GL_RGBA16F, GL_NEAREST, w, h);
    soft_[i].reserve(GL_RGBA16F, GL_LINEAR, w, h);
  }
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
                     bool one_camera, bool levels, float unreached) {
  choice_ = scene.scene->choose(view, options.cameras);
  window_ = window_of(view, scene.scene->mesh.positions, scene.scene->vertex_blocks, margin);
  margin_ = margin;
  counts_seen_ = false;
  if (window_.empty()) return;
  glDisable(GL_BLEND);
  glDisable(GL_CULL_FACE);
  glDisable(GL_SCISSOR_TEST);
  StageTimes::enter("depth maps");
  scene.depth_maps.ensure(choice_.listed, depth_map_.id(), scene.mesh.id(), scene.indices);
  reserve();
  find_deepest(scene, view, levels);
  write_uniforms(scene, view, options, one_camera);

  StageTimes::enter("surface");
  const float nothing[4] = {0, 0, 0, kNothing}, one = 1;
  glBindFramebuffer(GL_FRAMEBUFFER, surface_target_.id());
  glClearBufferfv(GL_COLOR, 0, nothing);
  glClearBufferfv(GL_DEPTH, 0, &one);
  glViewport(0, 0, window_.width, window_.height);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glUseProgram(proxy_.id());
  hides_backs_ = scene.closed && is_before(view, scene.scene->box);
  draw_proxy(scene);
  glDisable(GL_DEPTH_TEST);

  StageTimes::enter("visibility");
  visibility_pass_.set(0, unreached);
  on_window(visibility_pass_, {&surface_, &scene.depth_maps.texture()},
            {&visibility_, &angular_[0], &angular_[1], &mattes_});
  StageTimes::enter("weights");
  find_row_distances();
  on_window(weights_pass_, {&visibility_, &row_distances_, &angular_[0], &angular_[1]},
            {&weights_[0], &weights_[1], &soft_[0], &soft_[1]});
}

void Projection::draw_proxy(const SceneTextures& scene) const {
  if (hides_backs_) glEnable(GL_CULL_FACE);
  glBindVertexArray(scene.mesh.id());
  glDrawElements(GL_TRIANGLES, scene.indices, GL_UNSIGNED_INT, nullptr);
  glDisable(GL_CULL_FACE);
}

void Projection::find_row_distances() {
  constexpr int kWide = 32, kHigh = 8;  // shaders/soft_rows.comp has the same
  soft_rows_.run({&visibility_}, {&row_distances_}, (window_.width + kWide - 1) / kWide,
                 (window_.height + kHigh - 1) / kHigh, 1,
                 static_cast<std::size_t>(window_.width) * static_cast<std::size_t>(window_.height));
}

void Projection::on_window(const gl::Kernel& kernel, gl::Kernel::Textures read,
                           gl::Kernel::Textures written) const {
  kernel.over(window_.width, window_.height, read, written);
}

void Projection::draw(gl::Kernel& kernel, gl::Kernel::Textures read, const ViewTarget& target) const {
  kernel.set(0, window_.x, window_.y);
  const gl::Texture& picture = target.texture();
  kernel.over(picture.width(), picture.height(), read, {&picture});
}

void ViewTarget::begin(int width, int height) {
  last_ = 0;
  colors_[0].resize(GL_RGBA8, GL_LINEAR, width, height);
}

const gl::Texture& ViewTarget::begin_again() {
  const gl::Texture& drawn = colors_[last_];
  last_ = 1 - last_;
  colors_[last_].resize(GL_RGBA8, GL_LINEAR, drawn.width(), drawn.height());
  return drawn;
}

void ViewTarget::clear(const std::array<float, 3>& background) {
  const float clear[4] = {background[0], background[1], background[2], 0};
  glClearTexImage(texture().id(), 0, GL_RGBA, GL_FLOAT, clear);
}

}  // namespace floatstage::render
