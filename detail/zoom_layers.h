#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"
#include "detail/compose.h"
#include "detail/photo_graph.h"
#include "detail/watch.h"

namespace floatstage::detail {

/// A close photograph made to fit into those before it, in its own pixels.
struct ZoomLayer {
  std::string name;
  Image picture;  ///< RGBA, straight opacity
  /// Its pixels to the root's, corners at whole numbers.
  Eigen::Matrix3d root_from_layer = Eigen::Matrix3d::Identity();
  double zoom = 1;     ///< of the root's pixels, linear
  bool moved = false;  ///< it was bent to fit
};

struct ZoomLayersOptions {
  double own_pixels = 4e6;  ///< of one photograph, at most: larger ones are shrunk
  bool adapt = true;        ///< as ComposeOptions
  int threads = 0;
  Watch watch;
};

/// A root and what lies over it, the least zoom first: what a zipmap is made of.
struct ZoomLayers {
  Image root;
  std::vector<ZoomLayer> layers;
  std::vector<ComposedPhoto> photos;  ///< of all below the root, also those that were left out
};

/// The photographs below the root as compose() carries them into it, each at its own resolution whatever the
/// root's is. Errors: those of compose().
Result<ZoomLayers> zoom_layers(const PhotoGraph& graph, const ZoomLayersOptions& options);

}  // namespace floatstage::detail
