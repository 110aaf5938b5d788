#include "pipeline/balance.h"

#include <algorithm>
#include <filesystem>

#include "calib/gain_balance.h"
#include "calib/surface_colors.h"
#include "core/file_presence.h"
#include "core/log.h"
#include "core/parallel.h"
#include "core/text.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {
namespace {

constexpr double kFarOff = 1.6;  // cameras of one studio differ by less

bool has_colors(const Rig& rig) {
  return std::any_of(rig.cameras.begin(), rig.cameras.end(),
                     [](const RigCamera& c) { return !c.color.is_identity(); });
}

void say_far_off(const Rig& rig) {
  for (const RigCamera& camera : rig.cameras) {
    const Eigen::Vector3d gains = camera.color.matrix.diagonal();
    if (gains.maxCoeff() < kFarOff && gains.minCoeff() > 1 / kFarOff) continue;
    log::warning(text("camera '", camera.serial, "': its colours need gains of ", gains.x(), ", ", gains.y(),
                      ", ", gains.z(), " to agree with the others'; check its exposure and white balance"));
  }
}

// A small subject, thin limbs or rough cloth leave too few places to compare.
void say_unknown(const Rig& rig, const std::vector<Image>& images, const calib::GainBalance& balance) {
  std::string names;
  for (std::size_t i = 0; i < images.size(); ++i)
    if (!images[i].empty() && !balance.known[i])
      names += text(names.empty() ? "" : ", ", "'", rig.cameras[i].serial, "'");
  if (names.empty()) return;
  log::warning(text("--balance leaves the colours of ", names,
                    " as they are: too little of the subject can be compared with what others see of it; a "
                    "chart can (`calibrate color --chart`)"));
}

}  // namespace

Result<Rig> balanced(Rig rig, const SceneFrame& scene) {
  if (has_colors(rig) || scene.mesh.empty()) return rig;
  const std::size_t cameras = rig.cameras.size();
  std::vector<Image> images(cameras);
  std::vector<Result<void>> read(cameras);
  parallel_for(cameras, 0, [&](std::size_t i) {
    if (i >= scene.images.frames.size() || scene.images.frames[i].empty() || scene.mattes[i].empty()) return;
    Result<Image> rgb = to_rgb(scene.images.frames[i]);
    if (rgb)
      images[i] = std::move(*rgb);
    else
      read[i] = forward(rgb);
  });
  for (const Result<void>& r : read)
    if (!r) return forward(r);
  const std::vector<calib::ColorSample> samples = calib::surface_colors(scene.mesh, rig, images, 0);
  const calib::GainBalance balance = calib::balance_gains(samples, cameras);
  for (std::size_t i = 0; i < cameras; ++i) rig.cameras[i].color = balance.transforms[i];
  say_unknown(rig, images, balance);
  say_far_off(rig);
  return rig;
}

Result<Rig> rig_in_balance(capture::TakeReader& take) {
  Result<Rig> rig = rig_with_colors(take);
  if (!rig || has_colors(*rig)) return rig;
  SceneLoader loader(take, true);
  for (int frame = 0; frame < take.frame_count(); ++frame) {
    if (!is_there(take.layout().mesh(frame))) continue;
    const Result<SceneFrame> scene = loader.load(frame);
    if (!scene) return forward(scene);
    if (!scene->mesh.empty()) return balanced(std::move(*rig), *scene);
  }
  return rig;
}

}  // namespace floatstage::pipeline
