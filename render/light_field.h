#pragma once

#include <array>
#include <vector>

#include "render/camera_grid.h"
#include "render/renderer.h"
#include "render/scene_impl.h"

namespace floatstage::render {

/// The cameras' plane of a light field as an eye sees it: which four cameras stand around a viewing ray, and
/// how much each counts. In single precision, as the shader has it.
struct LightFieldPlane {
  static constexpr float kBeside = 1e-6F;  ///< how much a camera counts whose picture does not reach
  struct Cell {
    int first = 0;              ///< place of its camera at the top left, row after row
    float right = 0, down = 0;  ///< where the ray goes through it, 0 … 1; beyond the grid at its side
  };

  LightFieldPlane() = default;
  LightFieldPlane(const CameraGrid& grid, const Eigen::Vector3d& eye);

  Cell cell(const std::array<float, 3>& way) const;  ///< `way`: the ray's direction in the world, any length
  int offset(std::size_t k) const {                  ///< from a cell's first place to its k-th
    return static_cast<int>(k & 1) + (k >= 2 ? static_cast<int>(x.size()) : 0);
  }
  static float weight(std::size_t k, float right, float down) {
    return ((k & 1) != 0 ? right : 1 - right) * (k >= 2 ? down : 1 - down);
  }

  std::array<float, 3> normal{}, right{}, down{};
  float height = 0, eye_x = 0, eye_y = 0;  ///< of the eye: before the plane, and on it; metres
  std::vector<float> x, y;                 ///< of columns and rows, on the plane
  std::vector<int> cameras;                ///< row after row: indices into Scene::Impl::cameras
};

/// The four cameras in the middle of the view, strongest first, as RenderedView::cameras.
ShortList<int, kMostListed> strongest(const Scene::Impl& scene, const LightFieldPlane& plane,
                                      const View& view);

}  // namespace floatstage::render
