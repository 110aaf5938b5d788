#pragma once

#include <vector>

#include "render/camera_block.h"
#include "render/gl/gl_objects.h"

namespace floatstage::render {

/// The proxy's depth from each photograph's camera, in ideal pinhole coordinates (so that one map serves any
/// lens), rendered on first use and kept until the scene changes.
class DepthMaps {
 public:
  /// Places every camera's map over the part of its picture that `box` can cover. Forgets what was rendered.
  /// Fills `blocks[i].depth`.
  void plan(const std::vector<RigCamera>& cameras, const Eigen::AlignedBox3f& box,
            std::vector<CameraBlock>& blocks);

  /// Renders the maps of `wanted` (indices into plan()'s cameras) that are not there yet.
  void ensure(const std::vector<int>& wanted, GLuint program, GLuint mesh, GLsizei indices);

  GLuint texture() const { return maps_.id(); }

 private:
  struct Window {
    std::array<float, 16> cam_from_world;
    std::array<float, 4> place;
    float near_plane = 0, far_plane = 0;
    bool rendered = false;
  };
  std::vector<Window> windows_;
  gl::Texture maps_, z_buffer_;
  gl::Framebuffer framebuffer_;
  int width_ = 0, height_ = 0;
};

}  // namespace floatstage::render
