#pragma once

#include <span>
#include <vector>

#include "render/camera_block.h"
#include "render/depth_windows.h"
#include "render/gl/gl_objects.h"

namespace floatstage::render {

/// The proxy's depth from each photograph's camera, rendered on first use and kept until the scene changes.
class DepthMaps {
 public:
  /// One map a camera, of the windows' largest size. Forgets what was rendered.
  void plan(const std::vector<CameraBlock>& blocks, const std::vector<DepthWindow>& windows);

  /// Renders the maps of `wanted` (indices into plan()'s cameras) that are not there yet.
  void ensure(std::span<const int> wanted, GLuint program, GLuint mesh, GLsizei indices);

  const gl::Texture& texture() const { return maps_; }

 private:
  struct Map {
    std::array<float, 16> cam_from_world;
    DepthWindow window;
    bool rendered = false;
  };
  std::vector<Map> planned_;
  gl::Texture maps_, z_buffer_;
  gl::Framebuffer framebuffer_;
  int width_ = 0, height_ = 0;
};

}  // namespace floatstage::render
