#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/rig.h"
#include "matting/keyers/keyer_choice.h"
#include "studio/messages/camera_view.h"
#include "studio/messages/scene_times.h"
#include "studio/node/camera_view_maker.h"
#include "studio/node/set_builder.h"
#include "studio/node/stage_shadows.h"

namespace floatstage::studio {

/// The camera nodes of one machine: a set of frames in, all their views out.
class CameraRack {
 public:
  /// One node for each of the rig's cameras. `spec`: the keyer, or "auto": choose_keyers(). `samples` are
  /// per camera. Errors name the camera. A keyer against the empty stage that was made from other pictures is
  /// a warning: whoever stood in them stays in its eyes.
  static Result<CameraRack> make(const Rig& rig, const std::string& spec,
                                 std::vector<matting::KeySamples> samples);

  /// CameraViewMaker::prepare() of all.
  Result<void> prepare(int shrink);

  /// views[i] becomes that of rig.cameras[i]; their memory is used again once nobody has them any more.
  /// `textured[i]`: somebody wants its texture; empty: of all. A camera whose picture cannot be used is a
  /// null view, and trouble() says why. Cameras that are compared with their empty stage tell one another
  /// first where shadows fall on the floor. Adds what it took to `times`.
  void look(const TimedSet& set, const std::vector<bool>& textured, const NodeQuality& quality, int threads,
            SceneTimes& times, std::vector<std::shared_ptr<const CameraView>>& views);

  /// For people: "chroma", or "chroma (cam00, cam01), plate (cam02)".
  std::string keys() const;

  const std::string& trouble() const { return trouble_; }  ///< of the last look(); empty when all went well

 private:
  std::vector<CameraViewMaker> nodes_;
  std::optional<StageShadows> shadows_;
  std::vector<std::string> troubles_;  // of each node's last look
  std::string trouble_;
};

}  // namespace floatstage::studio
