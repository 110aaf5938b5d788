#pragma once

#include <optional>

#include "core/image.h"
#include "matting/keyers/keyer.h"
#include "matting/keyers/plate.h"
#include "matting/keyers/plate_measure.h"

namespace floatstage::matting {

/// What a plate that was shot tells against a key by colour (docs/adr/0293). A key by colour takes for
/// subject what stands beside the cloth (lamps, stands, doors), and for cloth what is as dark as nothing has
/// a colour, or has the cloth's own: both show against the empty stage. Immutable once made, thread safe.
class EmptyStage {
 public:
  /// What `keyer`, without cleaning up, makes of `plate`; nothing where it can make nothing of it.
  static std::optional<EmptyStage> seen_by(const Keyer& keyer, Plate plate);
  /// `plate`: not empty; `key`: the keyer's of it, one channel of its size. What is left of a key's edges
  /// goes as small islands do: `smallest_island` as in CleanupOptions.
  EmptyStage(Plate plate, const Image& key, double smallest_island);

  /// Takes out of a key what it takes for subject on the empty stage, wherever the photograph shows that as
  /// the plate does: within its noise, a shadow, a reflex. Elsewhere, and where nothing is taken out, the key
  /// keeps its bytes. `picture`: RGB of the plate's size; `key`: one channel of that size. False, and nothing
  /// done, for others.
  bool take_out_fixtures(const Image& picture, Image& key) const;

  /// Corrects a key by itself, at its own size: without fixtures, and with what no shadow can be where that
  /// hangs together with the key's subject and is no outline, as hard parts. False where the plate does not
  /// fit, before which only fixtures went. Pictures and keys as above.
  bool correct(const Image& picture, Image& key) const;

  /// Of what the key takes for subject on the empty stage, the share that a photograph (RGB of the plate's
  /// size) shows as the plate does; 1 where that is nothing. A camera that was moved shows it elsewhere.
  double fixtures_shown(const Image& picture) const;

  /// 255 where a photograph (RGB of the plate's size) shows what no shadow on the empty stage can be, without
  /// specks and holes; 0 elsewhere.
  Image solid(const Image& picture) const;

  /// Whether a plate shows the place of a photograph: what it alone takes for subject (solid()) is no more
  /// than what the key does. A camera that was moved, or other light, gives it edges and walls everywhere.
  static bool fits(const Image& solid, const Image& key);

  /// Of `more`, what hangs together with the key's subject: a plate adds to whom the key has found. Cables
  /// that were laid since, and cloth that was pulled, are nobody's.
  static Image touching(const Image& more, const Image& key);

  /// 255 where a mask is not near its outline, where opacities are a key's to tell; 0 elsewhere.
  static Image inside(const Image& mask);

  /// Of `part`, which lies in `whole`, what is no outline: parts that are as thick as five pixels of 480 in
  /// the longer side, and whatever only `whole` surrounds half as far, such as stripes and folds (not of a
  /// mask of less than 240 px a side, whose arms are no wider).
  static Image not_outlines(const Image& part, const Image& whole);

  /// For who does the same on bits (bit_empty_stage.h): where fixtures stand with their soft edges (255);
  /// pixels that are unlike the plate, and that no shadow of it can be; and the sizes of the above.
  const Image& fixtures() const { return fixtures_; }
  const PlateMeasure& alike() const { return alike_; }
  const PlateMeasure& no_shadow() const { return no_shadow_; }
  double smallest_island() const { return smallest_island_; }
  static const CleanupOptions& solid_clean_up();
  static int rim(const Image& picture);
  static int outline_radius(const Image& picture);
  static bool tells_stripes(const Image& picture);

 private:
  PlateMeasure alike_, no_shadow_;
  double smallest_island_;
  Image core_;      // 255 where fixtures stand
  Image fixtures_;  // the same with their soft edges
};

}  // namespace floatstage::matting
