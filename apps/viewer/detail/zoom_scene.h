#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/result.h"
#include "detail/zoom_layers.h"
#include "render/zipmap/gl_zipmap.h"

namespace floatstage::apps {

/// Where a photograph lies in the root.
struct ZoomOutline {
  std::string name;
  double zoom = 1;                       ///< of the root's pixels
  std::vector<Eigen::Vector2d> corners;  ///< px of the root, around it
};

/// What the zoom window shows.
struct ZoomScene {
  std::shared_ptr<const render::Zipmap> zipmap;
  std::vector<ZoomOutline> outlines;  ///< one a patch, in their order
  render::ZipmapTints provenance;     ///< colours as `detail synthesize --provenance` paints, strength 1
  int width = 0, height = 0;          ///< of the root
};

/// A zipmap of photographs that were made to fit. InvalidArgument: one whose place in the root folds over.
Result<ZoomScene> zoom_scene(const detail::ZoomLayers& layers);

}  // namespace floatstage::apps
