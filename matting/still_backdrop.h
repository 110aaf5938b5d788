#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "matting/keyers/plate.h"

namespace floatstage::matting {

/// What a still camera sees at each place when the subject is elsewhere, learnt from a clip or from the empty
/// stage: a colour, how often it was there, and whether anything else ever was.
class StillBackdrop {
 public:
  /// `pictures`: RGB, of one size, spread over a clip; at least two. `subjects`: empty, or of each picture
  /// where somebody is or may be (one channel, not 0), which is left out. Errors: InvalidArgument.
  static Result<StillBackdrop> learn(std::span<const Image> pictures, std::span<const Image> subjects = {});

  /// From photographs of the empty stage (RGB, of one size, at least one): every place was seen without the
  /// subject, so what looks like it is as surely backdrop as what does not is not. Light is what a subject
  /// changes, too: his shadow and his reflex (PlateClass) tell nothing. Errors: InvalidArgument.
  static Result<StillBackdrop> of_empty_stage(const std::vector<Image>& photographs);

  /// Takes the picture (RGB of its size) for what is seen there when the subject is elsewhere, wherever
  /// `mask` (one channel, of its size) is not 0: other light falls on it.
  void light(const Image& picture, const Image& mask) { plate_ = lit(std::move(plate_), picture, mask); }

  /// Whether the place was ever seen without the subject.
  bool knows(std::size_t pixel) const { return seen_[pixel] > 0; }
  /// What is seen there, RGB, wherever it knows.
  const Image& colors() const { return plate_.color; }
  /// The empty stage's colours, RGB; empty where the backdrop was learnt from a clip.
  const Image& empty_stage() const {
    static const Image kNone;
    return empty_stage_ ? plate_.color : kNone;
  }
  /// Of each pixel the log of how much likelier its colour is if something stands before the place. A place
  /// that never changed speaks softly against it: the subject may have stood there all the time. 0 where
  /// nothing is known. `unlike`: empty, or of the picture's size, not 0 where the photograph that it is made
  /// of is unlike the empty stage for certain (known_by_plate.h), which at its own size may be too thin to
  /// tell.
  std::vector<float> odds(const Image& picture, const Image& unlike = {}) const;

  /// The same before an empty stage as if nobody changed its light: what is only darker or brighter than the
  /// stage is something else, too, and so is a change too small to tell that a pixel shares with those around
  /// it, if it stands out from what changed all over the picture. Right of clothes in the stage's colours,
  /// wrong of shadows and reflexes. Empty where the backdrop was learnt from a clip, and where light has
  /// changed all over the stage.
  std::vector<float> odds_in_constant_light(const Image& picture, const Image& unlike = {}) const;

 private:
  float odds_of(std::size_t pixel, double squared_deviations, double sigma) const;
  std::vector<float> amid(std::vector<float> odds, const Image& picture, const Image& unlike) const;

  Plate plate_;
  std::vector<std::uint8_t> changed_, seen_;
  bool empty_stage_ = false;
};

}  // namespace floatstage::matting
