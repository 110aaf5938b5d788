#pragma once

#include <memory>
#include <span>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "core/result.h"
#include "core/rig.h"
#include "core/view.h"

namespace floatstage::render {

/// The part of one camera's photograph that shows the subject; what lies outside it is not subject. The
/// pictures are not owned.
struct PictureTile {
  int camera = -1;                 ///< index into Rig::cameras
  int x = 0, y = 0;                ///< of its first pixel in the photograph
  const Image* picture = nullptr;  ///< RGB
  const Image* matte = nullptr;    ///< one channel, same size
};

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

  /// The same for a live scene, of which only the subject's part of only the needed photographs is there
  /// (needed_cameras()). A view from where these are the needed ones equals one drawn from all photographs,
  /// but for parts that none of them sees. Errors as above; InvalidArgument also for a tile that leaves its
  /// photograph.
  Result<void> upload(const Rig& rig, const Mesh& mesh, std::span<const PictureTile> tiles);

  struct Impl;
  const Impl& impl() const { return *impl_; }  ///< for render/ only

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::render
