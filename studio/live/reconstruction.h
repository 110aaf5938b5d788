#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/result.h"
#include "core/rig.h"
#include "recon/visual_hull.h"
#include "studio/messages/camera_view.h"
#include "studio/messages/studio_scene.h"

namespace floatstage::studio {

/// The camera views of one instant in, the subject's surface out. Keeps its memory from frame to frame; used
/// by one thread at a time.
class Reconstruction {
 public:
  Reconstruction(Rig rig, std::string rig_sha256)
      : rig_(std::move(rig)), rig_sha256_(std::move(rig_sha256)) {}

  /// Replaces `scene`, whose memory is used again. Views in any order, null ones and those of cameras that
  /// the rig does not know left out; a camera without a view does not carve. A stage without a subject, and
  /// one that the outlines do not bound, is a scene with an empty mesh: remark() says why. InvalidArgument
  /// for views of pictures of another size than the rig's, and those of the hull.
  Result<void> make(std::span<const std::shared_ptr<const CameraView>> views, int threads,
                    StudioScene& scene);

  const std::string& remark() const {
    return remark_;
  }  ///< of the last make(); empty when there is nothing to say
  /// Of the last make(), one a camera of the rig; those that say nothing are empty.
  std::span<const Silhouette> outlines() const { return outlines_; }
  const Rig& rig() const { return rig_; }

 private:
  const Rig rig_;
  const std::string rig_sha256_;
  std::vector<Silhouette> outlines_;
  recon::HullWorkspace workspace_;
  recon::HullReport report_;
  std::string remark_;
};

}  // namespace floatstage::studio
