#pragma once

#include "core/image.h"
#include "matting/keyers/plate.h"

namespace floatstage::matting {

/// What a plate that was shot tells against a key by colour (docs/adr/0293). A key by colour takes for
/// subject what stands beside the cloth (lamps, stands, doors), and for cloth what is as dark as nothing has
/// a colour, or has the cloth's own: both show against the empty stage. Immutable once made, thread safe.
class EmptyStage {
 public:
  /// `plate`: not empty; `key`: what the keyer makes of it without cleaning up, one channel of its size.
  EmptyStage(Plate plate, const Image& key);

  /// Takes out of a key what it takes for subject on the empty stage, wherever the photograph shows that as
  /// the plate does: within its noise, a shadow, a reflex. What is left of its edges goes as small islands do
  /// (`smallest_island` as in CleanupOptions). Elsewhere, and where nothing is taken out, the key keeps its
  /// bytes. `picture`: RGB of the plate's size; `key`: one channel of that size. False, and nothing done, for
  /// others.
  bool take_out_fixtures(const Image& picture, double smallest_island, Image& key) const;

  /// Of what the key takes for subject on the empty stage, the share that a photograph (RGB of the plate's
  /// size) shows as the plate does; 1 where that is nothing. A camera that was moved shows it elsewhere.
  double fixtures_shown(const Image& picture) const;

  /// 255 where a photograph (RGB of the plate's size) shows what no shadow on the empty stage can be, without
  /// specks and holes; 0 elsewhere.
  Image solid(const Image& picture) const;

  /// 255 where a mask is not near its outline, where opacities are a key's to tell; 0 elsewhere.
  static Image inside(const Image& mask);

  /// Of `part`, which lies in `whole`, what is no outline: parts that are five pixels thick, and whatever
  /// only `whole` surrounds two pixels far, such as stripes and folds (not of a
  /// mask of less than 240 px a side, whose arms are no wider).
  static Image not_outlines(const Image& part, const Image& whole);

 private:
  Plate plate_;
  Image core_;      // 255 where fixtures stand
  Image fixtures_;  // the same with their soft edges
};

}  // namespace floatstage::matting
