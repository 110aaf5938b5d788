#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/image.h"
#include "core/result.h"
#include "detail/float_picture.h"
#include "detail/photo_graph.h"
#include "detail/watch.h"

namespace floatstage::detail {

/// What was done with a photograph.
struct ComposedPhoto {
  std::string name;
  double zoom = 0;         ///< of the root's pixels, linear
  double used = 0;         ///< the seam's inside, of its area
  double same = 0;         ///< what shows the same as its parent, of its area
  int edges = 0;           ///< that were matched across the seam
  double moved = 0;        ///< by how many of its pixels these were apart, mean
  bool adapted = false;    ///< they were moved onto one another: the seam costs less
  double seam_before = 0;  ///< energy of the seam (Eq. 4.2) without and with the displacement
  double seam_after = 0;
  double correction = 0;  ///< of its colours, mean, linear light
  std::string why_not;    ///< why it was left out; empty: it was not
};

/// A photograph as it is laid over the picture.
struct LaidPhoto {
  const ComposedPhoto& report;
  const LightPicture& patch;  ///< of the picture's pixels, from (x, y); the fourth number is its opacity
  int x, y;
  const LightPicture& layer;  ///< the same in its own pixels
  Eigen::Matrix3d root_from_layer;
};

struct ComposeOptions {
  double zoom = 0;              ///< of the root, 1 or more; 0: that of the closest photograph, as far as 32
                                ///< million pixels allow (8 with own_pixels)
  double own_pixels = 0;        ///< above 0: photographs keep their own pixels, up to so many, also where the
                                ///< picture is coarser
  bool adapt = true;            ///< move children's edges onto their parents'
  std::filesystem::path steps;  ///< a folder for pictures of every step; empty: none
  int threads = 0;
  std::function<void(const LaidPhoto&)> laid;  ///< called for each, the least zoom first; may be empty
  Watch watch;
};

struct Composition {
  Image picture;
  double zoom = 1;  ///< of the root
  std::vector<ComposedPhoto> photos;
};

/// The root enlarged, and the photographs below it carried into it from the widest to the closest
/// (thesis 4.3). Errors: those of load_photo(); BadData when a photograph is not the one that was related;
/// InvalidArgument when the picture would have more than 32 million pixels; Cancelled; Io.
Result<Composition> compose(const PhotoGraph& graph, const ComposeOptions& options);

}  // namespace floatstage::detail
