#pragma once

#include <optional>
#include <vector>

#include "core/image.h"
#include "matting/keyers/backing_field.h"
#include "matting/keyers/keyer.h"

// Private to the stage.
namespace floatstage::matting {

/// What stands behind the subject besides cloth of one colour: walls with lamps and poles (ADR 0170). A
/// value; thread safe to read.
class Walls {
 public:
  /// `samples`: RGB pictures of one camera; `cloth`: the cloth key of each, cloth below 128. Only what hangs
  /// together along the rim with one of its upper corners is a wall: what else is no cloth there may be the
  /// subject, which the frame cuts off. Nothing where that is less than a tenth of the rim.
  static std::optional<Walls> learn(const std::vector<Image>& samples, const std::vector<Image>& cloth);

  /// The key against cloth and walls, cleaned. `cloth`: the raw cloth key of the picture.
  Image key(const Image& picture, const Image& cloth, const CleanupOptions& cleanup) const;

  /// Solves the edges before walls in `alpha`; the others stay. `key`: what key() gave.
  void solve_edges(const Image& picture, const Image& cloth, const Image& key, Image& alpha) const;

 private:
  explicit Walls(BackingField field) : field_(std::move(field)) {}

  BackingField field_;
};

}  // namespace floatstage::matting
