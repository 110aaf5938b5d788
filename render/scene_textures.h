#pragma once

#include <memory>
#include <vector>

#include "core/result.h"
#include "core/rig.h"
#include "core/view.h"

namespace floatstage {

/// A SceneFrame on the GPU: photographs in one array texture, mattes beside them, cameras in one storage
/// buffer, the mesh in vertex buffers, one depth map per camera. Upload once, render many views. GL thread
/// only.
class SceneTextures {
 public:
  SceneTextures();
  SceneTextures(SceneTextures&&) noexcept;
  SceneTextures& operator=(SceneTextures&&) noexcept;
  ~SceneTextures();

  /// Replaces the scene; GPU storage is reused when sizes agree. `usable[i] == false` leaves camera i out of
  /// everything (leave-one-out); an empty vector means all. Cameras without a picture at this instant are
  /// left out. Pictures may differ in size. Errors: InvalidArgument (counts, no camera left), BadData (an
  /// image shorter than its layout, NaN in the rig or the mesh).
  Result<void> upload(const Rig& rig, const SceneFrame& scene, const std::vector<bool>& usable = {});

  struct Impl;
  const Impl& impl() const { return *impl_; }  ///< for render/ only

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage
