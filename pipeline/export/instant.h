#pragma once

#include <string>
#include <vector>

#include "capture/take.h"
#include "core/image.h"
#include "core/mesh.h"
#include "core/result.h"
#include "core/rig.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {

/// One instant of a take as other programs want it: no lens, no skew, the colours that we show. Of the
/// cameras that have a picture of it.
struct StraightInstant {
  Rig rig;                      ///< straight() cameras
  std::vector<Image> pictures;  ///< RGB; black where the photograph does not reach
  std::vector<Image> mattes;    ///< 0 … 255; empty for a camera without a matte
  Mesh mesh;
};

/// The instant's photographs, mattes and mesh, of `serials` (empty: all cameras). Errors of
/// SceneLoader::load(); NotFound when none of the cameras has a picture of it, InvalidArgument for a serial
/// that there is not.
Result<StraightInstant> load_straight_instant(capture::TakeReader& take, SceneLoader& loader, int frame,
                                              const std::vector<std::string>& serials = {});

}  // namespace floatstage::pipeline
