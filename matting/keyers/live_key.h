#pragma once

#include <memory>

#include "core/frame.h"
#include "core/matte.h"
#include "core/result.h"
#include "matting/cast_shadows.h"
#include "matting/keyers/keyer.h"

namespace floatstage::matting {

/// The mattes of a keyer, picture after picture of one camera, for where they are wanted at once: those of
/// Keyer::key(), but for a step of opacity in a few pixels of the edge. Much faster where the keyer has a
/// RowMeasure (chroma without walls, difference, plate); else it is key() itself. Every picture stands for
/// itself: what was keyed before does not matter. One thread at a time.
///
/// Where it is fast() nothing is allocated for colour frames of one size once subjects as large were seen and
/// the mattes before were given back.
class LiveKey {
 public:
  /// `keyer` outlives it.
  explicit LiveKey(const Keyer& keyer);
  LiveKey(LiveKey&&) noexcept;
  LiveKey& operator=(LiveKey&&) noexcept;
  ~LiveKey();

  /// As Keyer::key(). Before an empty stage that it compares with, shadows on the floor are none of the
  /// subject, as far as `shade`, of the picture and smaller, knows them.
  Result<Matte> key(const Frame& frame, const CastShade* shade = nullptr);
  /// Whether there is anything faster than key() here.
  bool fast() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::matting
