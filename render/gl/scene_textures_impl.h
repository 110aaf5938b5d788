#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "core/rig.h"
#include "render/camera_block.h"
#include "render/camera_choice.h"
#include "render/gl/depth_maps.h"
#include "render/gl/gl_objects.h"
#include "render/gl/scene_textures.h"

namespace floatstage::render {

struct SceneTextures::Impl {
  CameraChoice choose(const View& view, int count) const;  ///< listed are indices into `cameras`
  void put_mesh(const Mesh& mesh);
  /// Depth maps' places and the camera buffer, once cameras and mesh are there.
  void put_cameras(std::vector<CameraBlock>& blocks);

  std::vector<RigCamera> cameras;  ///< those in use, in the rig's order
  std::vector<int> rig_index;      ///< of each, in the rig
  std::vector<RigCamera> ranked;   ///< those whose angles say how the others' weights fade: these, or all
  std::vector<int> slot;           ///< of each ranked camera in `cameras`; -1: it has no picture
  std::vector<Eigen::Vector3f> positions;  ///< the mesh's, for the views' windows
  std::vector<Eigen::Vector3f> samples;    ///< a few of them, spread over the mesh, for ranking cameras
  Eigen::AlignedBox3f box;
  GLsizei indices = 0;

  gl::Texture photographs;  ///< RGBA8 array, alpha is the matte; layer i belongs to cameras[i]
  gl::Buffer camera_buffer, vertex_buffer, index_buffer;
  std::size_t camera_capacity = 0, vertex_capacity = 0, index_capacity = 0;
  gl::VertexArray mesh;
  std::vector<std::uint8_t> staging;  ///< one tile as RGBA
  mutable DepthMaps depth_maps;       ///< a cache: rendered by the first view that needs a camera
};

}  // namespace floatstage::render
