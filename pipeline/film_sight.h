#pragma once

#include <optional>
#include <string>

#include "render/seen_pixels.h"

namespace floatstage::pipeline {

/// A picture of which so much is seen by none of the photographs that it is drawn from is said (ADR 365).
inline constexpr double kMuchUnseen = 0.05;

/// How much of a film's pictures the photographs that they are drawn from see.
struct FilmSight {
  int pictures = 0;        ///< of which it is known
  double unseen = 0;       ///< of what they show of the subject, 0 … 1: the mean share that nobody sees
  int much = 0;            ///< pictures with more of it than kMuchUnseen
  double worst = 0;        ///< the largest share
  int worst_picture = -1;  ///< of the film; -1: none is known

  /// A picture's pixels; none shown: it is not known.
  void add(int picture, const render::SeenPixels& pixels);
  /// What there is to be said of it, if anything.
  std::optional<std::string> doubt() const;
};

}  // namespace floatstage::pipeline
