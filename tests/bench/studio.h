#pragma once

#include <stdexcept>
#include <utility>

#include "core/synthetic/synthetic_studio.h"
#include "render/renderer.h"
#include "tests/bench/bench_context.h"

namespace floatstage::render {

/// One instant of the synthetic studio, shared by all benches of a program.
struct Studio {
  Rig rig;
  SceneFrame frame;
  render::Scene scene;

  Studio() {
    rig = synthetic_rig({});
    const SyntheticStudio studio = std::move(*SyntheticStudio::create(rig, {}));
    for (int i = 0; i < static_cast<int>(rig.cameras.size()); ++i) {
      SyntheticShot shot = studio.shoot(i, 0);
      frame.images.frames.push_back(std::move(shot.frame));
      frame.mattes.push_back(std::move(shot.matte));
    }
    frame.mesh = studio.performer(0);
    if (const Result<void> ok = scene.set(rig, frame); !ok) throw std::runtime_error(ok.error().message);
  }
};

inline Studio& studio() {
  if (context() == nullptr) throw std::runtime_error("no OpenGL 4.5 here");
  static Studio shared;
  return shared;
}

/// Between the first two cameras, and a little farther on each call, as an orbit does.
inline View orbit_view(int width, int height, int step) {
  const RigCamera& camera = studio().rig.cameras.front();
  View view;
  view.model = camera.model;
  const double scale = static_cast<double>(width) / camera.model.width;
  view.model.width = width;
  view.model.height = height;
  for (double* v : {&view.model.fx, &view.model.fy, &view.model.cx, &view.model.cy}) *v *= scale;
  const Eigen::Vector3d target = focus_point(studio().rig), eye = camera.cam_from_world.center();
  const Eigen::AngleAxisd turn(0.3 + 0.01 * (step % 16), Eigen::Vector3d::UnitZ());
  view.view_from_world = look_at(target + turn * (eye - target), target, Eigen::Vector3d::UnitZ());
  return view;
}

}  // namespace floatstage::render
