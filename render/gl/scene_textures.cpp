#include "render/gl/scene_textures.h"

#include <algorithm>

#include "core/text.h"
#include "render/closed_mesh.h"
#include "render/photo_pyramid.h"
#include "render/stage_times.h"

namespace floatstage::render {
namespace {

constexpr int kBetweenLevels = 2 * kLastLevel;  // px: what rounding adds to the levels' heights

Result<void> check_fit(int width, int height, std::size_t pictures) {
  GLint largest = 0, most_layers = 0;
  glGetIntegerv(GL_MAX_TEXTURE_SIZE, &largest);
  glGetIntegerv(GL_MAX_ARRAY_TEXTURE_LAYERS, &most_layers);
  if (std::max(width, height) <= largest && static_cast<int>(pictures) <= most_layers) return {};
  return fail(ErrorCode::Unsupported,
              text(pictures, " pictures of up to ", width, "x", height, " do not fit this GPU's textures (",
                   largest, " px, ", most_layers, " layers); draw with --renderer cpu"));
}

// Where shaders/camera.glsl reads a level: beside the photograph, one below the other.
void upload_level(const gl::Texture& to, int level, std::size_t layer, const SceneTile& photograph,
                  const SceneTile& tile) {
  const int x = level == 0 ? 0 : photograph.width;
  const int y = level == 0 ? 0
                           : photograph.height -
                                 (photograph.height + (1 << (level - 1)) - 1) / (1 << (level - 1)) + level;
  glPixelStorei(GL_UNPACK_ROW_LENGTH, tile.stride());
  glTextureSubImage3D(to.id(), 0, x, y, static_cast<GLint>(layer), tile.width, tile.height, 1, GL_RGBA,
                      GL_UNSIGNED_BYTE, tile.at(0, 0));
  glPixelStorei(GL_UNPACK_ROW_LENGTH, 0);
}

}  // namespace

Result<const SceneTextures*> SceneTextures::of(const Scene& scene) {
  const Scene::Impl& s = scene.impl();
  if (!s.on_gpu) s.on_gpu = std::make_shared<SceneTextures>();
  auto* textures = static_cast<SceneTextures*>(s.on_gpu.get());
  if (textures->version_ != s.version || textures->scene != &s)
    if (Result<void> ok = textures->upload(s); !ok) return forward(ok);
  return textures;
}

Result<void> SceneTextures::upload(const Scene::Impl& from) {
  StageTimes::enter("uploads");
  const std::size_t count = from.cameras.size();
  int width = 0, height = 0;
  for (std::size_t i = 0; i < count; ++i) {
    width = std::max(width, from.tiles[i].width);
    height = std::max(height, from.tiles[i].height);
  }
  if (Result<void> ok = check_fit(width + (width + 1) / 2, height + kBetweenLevels, count); !ok) return ok;
  // Tiles change their size with every step of the subject: storage only grows.
  photographs.reserve(GL_RGBA8, GL_LINEAR, width + (width + 1) / 2, height + kBetweenLevels,
                      static_cast<int>(count));
  has_levels_.assign(count, false);
  for (std::size_t i = 0; i < count; ++i) upload_level(photographs, 0, i, from.tiles[i], from.tiles[i]);
  upload_mesh(from.mesh);
  depth_maps.plan(from.blocks, from.depth_windows);
  gl::upload(camera_buffer, camera_capacity_, from.blocks.data(), from.blocks.size() * sizeof(CameraBlock));
  scene = &from;
  version_ = from.version;
  return {};
}

void SceneTextures::ensure_levels(std::span<const int> cameras) const {
  if (cameras.empty()) return;
  const PhotoPyramid& pyramid = PhotoPyramid::of(*scene, cameras);
  for (int camera : cameras) {
    const auto i = static_cast<std::size_t>(camera);
    if (has_levels_[i]) continue;
    has_levels_[i] = true;
    for (int level = 1; level <= kLastLevel; ++level)
      upload_level(photographs, level, i, scene->tiles[i],
                   pyramid.levels[static_cast<std::size_t>(level - 1)][i]);
  }
}

void SceneTextures::upload_mesh(const Mesh& source) {
  indices = static_cast<GLsizei>(source.triangles.size());
  closed = is_closed(source);
  gl::upload(vertex_buffer_, vertex_capacity_, source.positions.data(),
             source.positions.size() * sizeof(Eigen::Vector3f));
  gl::upload(index_buffer_, index_capacity_, source.triangles.data(),
             source.triangles.size() * sizeof(std::uint32_t));
  if (!mesh) mesh = gl::VertexArray::create();
  glVertexArrayVertexBuffer(mesh.id(), 0, vertex_buffer_.id(), 0, sizeof(Eigen::Vector3f));
  glVertexArrayElementBuffer(mesh.id(), index_buffer_.id());
  glEnableVertexArrayAttrib(mesh.id(), 0);
  glVertexArrayAttribFormat(mesh.id(), 0, 3, GL_FLOAT, GL_FALSE, 0);
  glVertexArrayAttribBinding(mesh.id(), 0, 0);
}

}  // namespace floatstage::render
