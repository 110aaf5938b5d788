#pragma once

#include <vector>

#include "render/flow/picture_pyramid.h"
#include "render/flow/split_plane.h"

namespace floatstage::render {

/// Takes a field from a level to the next finer one: displacements double.
class Enlargement {
 public:
  /// Bilinear, of one component. `to` gets the size of `fine`; outside its spans it is 0.
  void bilinear(const PictureLevel& fine, const SplitPlane& from, SplitPlane& to);
  /// Joint bilateral (Kopf et al. 2007): of the four coarse pixels around, those count that look like the
  /// fine one. `edge` is the difference, in 8-bit steps, at which a pixel counts half.
  void guided(const PictureLevel& coarse, const PictureLevel& fine, float edge, const SplitPlane& u,
              const SplitPlane& v, SplitPlane& fine_u, SplitPlane& fine_v);

 private:
  /// Columns of two coarse rows in their order, with one column more at both ends.
  struct Rows {
    std::vector<float> u, v, value, known;
  };
  Rows near_, far_;
};

}  // namespace floatstage::render
