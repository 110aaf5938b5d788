#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/time.h"
#include "render/renderer.h"
#include "studio/node/camera_view_maker.h"

namespace floatstage::studio {

/// Everything in the live chain that trades looks for speed.
struct LiveQuality {
  std::string name;
  NodeQuality node;
  std::string method = "floating";
  render::FlowOptions flow;
  bool sharp = true;  ///< RendererOptions::sharp
  int output = 1;     ///< the view is drawn at 1 / output of its size along each side, and enlarged
};

/// From the best to the fastest: fewer warps of the flow, the flow at half resolution, coarser outlines, a
/// smaller picture, plain blending (docs/adr/0196). The first is what `render` does offline, but for the
/// outlines' specks.
const std::vector<LiveQuality>& live_qualities();
/// "keys at 1/1, outlines within 0.75 px, floating, flow at 1/2 with 1 warp"
std::string describe(const LiveQuality& quality);

/// Chooses a quality that keeps up with a wanted frame rate: goes down at once when the chain is too slow,
/// and up again after a while of ease, each time more patiently when that did not last. Pure: time is a
/// parameter.
class QualityControl {
 public:
  /// Begins at `level`; a `target` of 0 frames a second never changes it.
  QualityControl(double target, std::size_t level) : target_(target), level_(level) {}

  /// A window of at least a second has passed in which `fps` scenes a second were shown, of `offered` that
  /// the cameras had; `busy` is the share of time in which the chain worked. Without any offered, nothing
  /// changes. A new level when one is better now.
  std::optional<std::size_t> judge(Timestamp time, double fps, double offered, double busy);
  std::size_t level() const { return level_; }

 private:
  double target_;
  std::size_t level_;
  int slow_ = 0;  // windows in a row
  std::optional<Timestamp> easy_since_;
  double patience_s_ = 8;  // of ease before a better quality is tried
  std::optional<Timestamp> rose_;
};

}  // namespace floatstage::studio
