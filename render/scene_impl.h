#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "core/rig.h"
#include "render/camera_block.h"
#include "render/camera_choice.h"
#include "render/camera_fields.h"
#include "render/depth_windows.h"
#include "render/scene.h"
#include "render/vertex_blocks.h"

namespace floatstage::render {

/// A photograph or a part of one: RGBA8, alpha is the matte, with `kApron` px around it that repeat its
/// border, so that a spline's sixteen pixels can be read without asking where they lie.
struct SceneTile {
  static constexpr int kApron = 2;
  int width = 0, height = 0;  ///< without the apron
  std::vector<std::uint8_t> rgba;

  int stride() const { return width + 2 * kApron; }  ///< px from row to row
  void resize(int w, int h);
  /// x and y from -kApron to the size + kApron - 1.
  const std::uint8_t* at(int x, int y) const { return rgba.data() + offset(x, y); }
  std::uint8_t* at(int x, int y) { return rgba.data() + offset(x, y); }
  void repeat_border();

 private:
  std::size_t offset(int x, int y) const {
    return 4 * (static_cast<std::size_t>(y + kApron) * static_cast<std::size_t>(stride()) +
                static_cast<std::size_t>(x + kApron));
  }
};

struct Scene::Impl {
  CameraChoice choose(const View& view, int count) const;  ///< listed are indices into `cameras`

  std::vector<RigCamera> cameras;  ///< those in use, in the rig's order
  std::vector<int> rig_index;      ///< of each, in the rig
  std::vector<CameraBlock> blocks;
  std::vector<DepthWindow> depth_windows;
  std::vector<SceneTile> tiles;   ///< of each camera; may hold more, kept for their storage
  std::vector<RigCamera> ranked;  ///< those whose angles say how the others' weights fade: these, or all
  std::vector<int> slot;          ///< of each ranked camera in `cameras`; -1: it has no picture
  Mesh mesh;
  VertexBlocks vertex_blocks;  ///< of the mesh, for finding windows
  Eigen::AlignedBox3f box;
  std::uint64_t version = 0;                     ///< counts what was set
  std::shared_ptr<const FieldSet> given_fields;  ///< precomputed ones; null: none

  std::vector<bool> pictured;                  ///< of each ranked camera: whether it has a slot
  mutable CameraRanking ranking;               ///< of the ranked cameras
  mutable std::shared_ptr<void> on_gpu;        ///< gl::SceneTextures of a version
  mutable std::shared_ptr<void> on_cpu;        ///< cpu::SceneMaps of a version
  mutable std::shared_ptr<void> pyramid;       ///< PhotoPyramid of a version
  mutable std::vector<FieldSet> fields;        ///< those and what was made since, one a FlowOptions
  mutable std::shared_ptr<void> band_limited;  ///< the scene with filtered photographs, of a version

  void begin(std::size_t count, const Mesh& mesh);  ///< `count` cameras will be added
  void add(const RigCamera& camera, int index);     ///< its tile's size and place come after
  void finish();                                    ///< once all cameras and their tiles are there
};

}  // namespace floatstage::render
