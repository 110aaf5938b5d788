#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/gl/depth_maps.h"
#include "render/gl/gl_objects.h"
#include "render/scene_impl.h"

namespace floatstage::render {

/// A Scene on the GPU: photographs in one array texture, mattes beside them, cameras in one storage buffer,
/// the mesh in vertex buffers, one depth map per camera. GL thread only.
class SceneTextures {
 public:
  /// This scene's, which live as long as it does; brought up to date when the scene was set anew. GPU storage
  /// is reused when sizes agree. Unsupported when the pictures do not fit the GPU's textures.
  static Result<const SceneTextures*> of(const Scene& scene);

  const Scene::Impl* scene = nullptr;
  GLsizei indices = 0;
  bool closed = false;      ///< the mesh: from outside its back faces are hidden
  gl::Texture photographs;  ///< RGBA8 array, alpha is the matte; layer i belongs to scene->cameras[i]; its
                            ///< pyramid is to the right of it after ensure_levels()
  gl::Buffer camera_buffer;
  gl::VertexArray mesh;
  /// Fills the levels of these photographs (indices into scene->cameras) from their PhotoPyramid.
  void ensure_levels(std::span<const int> cameras) const;

  mutable DepthMaps depth_maps;  ///< a cache: rendered by the first view that needs a camera

 private:
  Result<void> upload(const Scene::Impl& from);
  void upload_mesh(const Mesh& source);

  std::uint64_t version_ = 0;
  mutable std::vector<bool> has_levels_;  // of scene->cameras
  gl::Buffer vertex_buffer_, index_buffer_;
  std::size_t camera_capacity_ = 0, vertex_capacity_ = 0, index_capacity_ = 0;
};

}  // namespace floatstage::render
