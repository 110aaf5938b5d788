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

struct FieldSet;

/// The part of one camera's photograph that shows the subject; what lies outside it is not subject. The
/// pictures are not owned.
struct PictureTile {
  int camera = -1;                 ///< index into Rig::cameras
  int x = 0, y = 0;                ///< of its first pixel in the photograph
  const Image* picture = nullptr;  ///< RGB
  const Image* matte = nullptr;    ///< one channel, same size
};

/// What is drawn: the mesh, the photographs or their tiles in the rig's colours, and the cameras, prepared
/// once for many views. Knows no graphics library; the GL back-end keeps its textures of a scene beside it,
/// made by the first render() after a set() and freed with the scene, so that a scene drawn with GL lives and
/// dies on the GL thread. One thread at a time. Storage is kept from scene to scene.
class Scene {
 public:
  Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;
  ~Scene();

  /// Replaces the scene. `usable[i] == false` leaves camera i out of everything (leave-one-out); an empty
  /// vector means all. Cameras without a picture at this instant are left out. Pictures may differ in size.
  /// Errors leave the old scene: InvalidArgument (counts, no camera left), BadData (an image shorter than its
  /// layout, NaN in the rig or the mesh).
  Result<void> set(const Rig& rig, const SceneFrame& scene, const std::vector<bool>& usable = {});

  /// The same for a live scene, of which only the subject's part of only the needed photographs is there
  /// (needed_cameras()). A view from where these are the needed ones equals one drawn from all photographs,
  /// but for parts that none of them sees. Errors as above; InvalidArgument also for a tile that leaves its
  /// photograph.
  Result<void> set(const Rig& rig, const Mesh& mesh, std::span<const PictureTile> tiles);

  /// Fields of this very scene (render/camera_fields.h), for "floating-static": what is not among them, or
  /// was estimated otherwise than a picture asks for, is estimated when it is first drawn with. Forgotten by
  /// the next set(). Null: none.
  void set_fields(std::shared_ptr<const FieldSet> fields);

  struct Impl;
  const Impl& impl() const { return *impl_; }  ///< for render/ only

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::render
