#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/frame.h"
#include "core/rig.h"
#include "matting/cast_shadows.h"

namespace floatstage::studio {

/// Shadows on the floor in what the cameras of one machine see at an instant, told before anything is keyed
/// from pictures of at most 160 pixels a side (matting/cast_shadows.h). Keeps its memory as CastShadows
/// does. One thread at a time.
class StageShadows {
 public:
  /// `stages`: of each camera of the rig a photograph of its empty stage (RGB, of the model's size), or
  /// empty. Absent where fewer than three have one: nobody could tell.
  static std::optional<StageShadows> of(const Rig& rig, const std::vector<Image>& stages);

  /// `frames` in rig order; one that is empty or of another size than its camera's is not looked at. Valid
  /// until the next call.
  const std::vector<matting::CastShade>& look(const std::vector<Frame>& frames, int threads);

 private:
  /// Of the stage: keys against a plate allow for lighter shadows by themselves (PlateKeyOptions).
  static constexpr float kLightest = 0.9F;
  struct Camera {
    int width = 0, height = 0, factor = 1;
    Image stage, picture;
    std::vector<std::uint32_t> sums;
  };
  StageShadows(const Rig& rig, std::vector<Camera> cameras)
      : cameras_(std::move(cameras)), before_(cameras_.size()), shadows_(rig, kLightest) {}

  std::vector<Camera> cameras_;
  std::vector<matting::BeforeStage> before_;
  matting::CastShadows shadows_;
};

}  // namespace floatstage::studio
