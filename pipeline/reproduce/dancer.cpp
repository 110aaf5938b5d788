#include "pipeline/reproduce/dancer.h"

#include "core/parallel.h"
#include "pipeline/progress.h"
#include "recon/visual_hull.h"

namespace floatstage::pipeline {
namespace {

// What is not performer becomes black.
Image over_black(const Image& rgb, const Image& alpha) {
  Image out = rgb;
  for (std::size_t i = 0; i < out.pixels.size(); ++i)
    out.pixels[i] = static_cast<std::uint8_t>((out.pixels[i] * alpha.pixels[i / 3] + 127) / 255);
  return out;
}

}  // namespace

Result<TestScene> dancer(const DancerOptions& options) {
  SyntheticRigOptions ring;
  ring.cameras = options.cameras;
  ring.width = options.width;
  ring.height = options.height;
  SyntheticStudioOptions studio_options;
  studio_options.defects = options.defects;
  studio_options.stop = [&] { return is_cancelled(options.progress); };
  Result<SyntheticStudio> studio = SyntheticStudio::create(synthetic_rig(ring), studio_options);
  if (!studio) return forward(studio);

  TestScene scene;
  scene.rig = studio->published_rig();
  const auto count = static_cast<std::size_t>(options.cameras);
  ring.cameras = 2 * options.cameras;  // every second one stands between two of ours
  const Rig between = synthetic_rig(ring);
  std::vector<SyntheticShot> shots(count + static_cast<std::size_t>(options.views));
  ProgressPart progress(options.progress, "photographs", shots.size());
  parallel_for(shots.size(), 0, [&](std::size_t i) {
    if (i < count) {
      shots[i] = studio->shoot(static_cast<int>(i), options.frame);
    } else {
      const std::size_t place = (i - count) * count / static_cast<std::size_t>(options.views);
      const RigCamera& camera = between.cameras[2 * place + 1];
      shots[i] = studio->shoot_view({.model = camera.model, .view_from_world = camera.cam_from_world},
                                    options.frame);
    }
    progress.advance();
  });
  if (is_cancelled(options.progress)) return cancelled();
  for (std::size_t i = 0; i < shots.size(); ++i) {
    if (i < count) {
      scene.photographs.images.frames.push_back(shots[i].frame);
      scene.photographs.mattes.push_back(shots[i].matte);
      continue;
    }
    const Result<Image> rgb = to_rgb(shots[i].frame);
    if (!rgb) return forward(rgb);
    const std::size_t place = (i - count) * count / static_cast<std::size_t>(options.views);
    const Image alpha = to_image(shots[i].matte);
    scene.views.push_back({between.cameras[2 * place + 1], over_black(*rgb, alpha), alpha});
  }
  recon::HullOptions hull_options;
  hull_options.voting = recon::HullVoting::Auto;
  hull_options.quality = false;
  Result<recon::HullReport> hull = recon::visual_hull(scene.rig, scene.photographs.mattes, hull_options);
  if (!hull) return forward(hull);
  scene.photographs.mesh = std::move(hull->mesh);
  return scene;
}

}  // namespace floatstage::pipeline
