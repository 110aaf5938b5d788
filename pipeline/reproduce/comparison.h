#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "core/rig.h"
#include "core/view.h"
#include "pipeline/progress.h"
#include "render/renderer.h"

namespace floatstage::pipeline {

/// What is really seen from a place where no photograph was taken (or one was: how well it is given back).
struct TrueView {
  RigCamera camera;
  Image rgb;         ///< over black
  Image silhouette;  ///< 1 channel; empty: all of the picture counts
};

/// Photographs, what they are projected onto, and views of which the truth is known.
struct TestScene {
  Rig rig;
  SceneFrame photographs;
  std::vector<TrueView> views;
  int border = 0;  ///< px along the pictures' sides that do not count
};

struct MethodScores {
  double psnr = 0, ssim = 0, sharpness = 0;  ///< as docs/metrics.md has them, in the mask
  double ghosting = 0;                       ///< 0 where nobody asked
};

/// One view, drawn by every method.
struct ComparedView {
  Image truth, mask;                      ///< RGB over black; where scores were taken
  std::map<std::string, Image> rendered;  ///< by method: RGB over black
  std::map<std::string, MethodScores> scores;
};

struct ComparisonOptions {
  std::vector<std::string> methods;
  render::RendererOptions renderer;  ///< its back-end is open
  bool ghosting = true;              ///< costs a second picture
  std::string what = "views";        ///< in the words of a progress bar
  Progress* progress = nullptr;
};

/// Draws every view with every method and scores it as `evaluate` does: where truth and proxy both are, 2 px
/// eroded. Errors of the renderers; Cancelled between two pictures.
Result<std::vector<ComparedView>> compare(const TestScene& scene, const ComparisonOptions& options);

MethodScores mean_of(const std::vector<ComparedView>& views, const std::string& method);

/// The scene with its first `count` cameras as views: what should come back is their photographs.
TestScene at_its_cameras(const TestScene& scene, std::size_t count);

}  // namespace floatstage::pipeline
