#pragma once

#include <span>
#include <vector>

#include "core/rig.h"
#include "core/view.h"

struct ImDrawList;
struct ImVec2;

namespace floatstage::apps {

/// The rig's cameras drawn over the picture: wire frusta with thumbnails of their photographs. GL thread
/// only.
class CameraFrusta {
 public:
  CameraFrusta() = default;
  ~CameraFrusta();
  CameraFrusta(const CameraFrusta&) = delete;
  CameraFrusta& operator=(const CameraFrusta&) = delete;

  /// Makes small textures of these photographs.
  void upload(const FrameSet& images);
  /// Draws onto `list`, where the view's picture stands at `origin`, `scale` screen px a view px. `used`
  /// cameras are drawn stronger.
  void draw(ImDrawList* list, const ImVec2& origin, float scale, const Rig& rig, const View& view,
            double depth, std::span<const int> used) const;

 private:
  std::vector<unsigned> thumbnails_;  ///< 0 where a camera has no photograph
};

}  // namespace floatstage::apps
