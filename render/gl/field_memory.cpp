#include "render/gl/field_memory.h"

#include <utility>

#include <Eigen/Geometry>

#include "render/scene_impl.h"

namespace floatstage::render {
namespace {

constexpr int kBinding = 1;  // of MemoryBlock
constexpr std::size_t kFields = kMostListed * (kMostListed - 1);

// Uniforms of the pass (std140; shaders/field_memory.comp has the twin).
struct MemoryBlock {
  std::array<float, 16> view_from_world, now_from_then;
  std::array<float, 4> k, window;
  std::array<int, kFields> layers;
  std::array<float, kFields> shares;
};
static_assert(sizeof(MemoryBlock) == 128 + 2 * 16 + 2 * 14 * 16);

float f(double v) { return static_cast<float>(v); }

}  // namespace

Result<FieldMemory> FieldMemory::create() {
  Result<gl::Kernel> pass = gl::Kernel::create("field_memory.comp", {"view.glsl", "window.glsl"});
  if (!pass) return forward(pass);
  FieldMemory memory;
  memory.pass_ = std::move(*pass);
  memory.uniforms_ = gl::Buffer::create();
  return memory;
}

bool FieldMemory::knows(const Scene& scene, int shrink) const {
  return scene_.lock() == scene.impl().on_gpu && version_ == scene.impl().version && shrink_ == shrink;
}

const gl::Texture& FieldMemory::mix(const Scene& scene, const View& view, const Projection& projection,
                                    const std::vector<bool>& wanted, int shrink, double share,
                                    const gl::Texture& flows) {
  const Window& window = projection.window();
  const CameraChoice& choice = projection.choice();
  const auto fields = static_cast<int>(choice.chosen * (choice.chosen - 1));
  FieldsOfPicture picture{view.view_from_world.center(), {}, wanted};
  for (std::size_t i = 0; i < choice.chosen; ++i) picture.cameras.push_back(choice.listed[i]);
  MemoryBlock block{};
  block.layers.fill(-1);
  if (knows(scene, shrink)) {
    Eigen::Map<Eigen::Matrix4f>(block.view_from_world.data()) = view_.view_from_world.matrix().cast<float>();
    Eigen::Map<Eigen::Matrix4f>(block.now_from_then.data()) =
        (view.view_from_world * view_.view_from_world.inverse()).matrix().cast<float>();
    const CameraModel& m = view_.model;
    block.k = {f(m.fx), f(m.fy), f(m.cx - window_.x), f(m.cy - window_.y)};
    block.window = {f(window_.width), f(window_.height), f(m.skew), 0};
    for (const RememberedField& one : remembered_fields(scene.impl(), picture, picture_, share)) {
      block.layers[one.now] = static_cast<int>(one.before);
      block.shares[one.now] = one.share;
    }
  }
  gl::upload(uniforms_, uniform_capacity_, &block, sizeof block);
  glBindBufferBase(GL_UNIFORM_BUFFER, kBinding, uniforms_.id());

  const int width = (window.width + shrink - 1) / shrink, height = (window.height + shrink - 1) / shrink;
  gl::Texture& mixed = fields_[1 - kept_];
  mixed.reserve(flows.format(), GL_LINEAR, width, height, fields);
  pass_.set(0, width, height).set(1, fields);
  pass_.over(width, height, {&projection.surface(), &flows, &fields_[kept_], &surface_}, {&mixed});

  surface_.reserve(projection.surface().format(), GL_NEAREST, window.width, window.height);
  glCopyImageSubData(projection.surface().id(), GL_TEXTURE_2D, 0, 0, 0, 0, surface_.id(), GL_TEXTURE_2D, 0, 0,
                     0, 0, window.width, window.height, 1);
  kept_ = 1 - kept_;
  scene_ = scene.impl().on_gpu;
  version_ = scene.impl().version;
  view_ = view;
  window_ = window;
  shrink_ = shrink;
  picture_ = std::move(picture);
  return mixed;
}

}  // namespace floatstage::render
