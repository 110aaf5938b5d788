#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "matting/keyers/plate.h"

namespace floatstage::matting {

/// The picture at a smaller size, by area means; the picture itself when the size fits.
Image shrunk(const Image& picture, int width, int height);

/// Of each pixel of an RGB picture how much of edges lies between it and the picture's border on the way that
/// crosses least: the geodesic distance of Y. Wei, F. Wen, W. Zhu and J. Sun, "Geodesic Saliency Using
/// Background Priors", ECCV 2012, where what is no steeper than light or noise costs nothing. Cloth that
/// is lit unevenly lies near the border by that, a subject before it far. In 8-bit steps, summed over
/// channels.
std::vector<float> edges_to_border(const Image& picture);

/// The standard deviation of a picture's noise, 8-bit steps summed over channels: from the median difference
/// of neighbours, which shows noise wherever more than half of the picture is calm. At least 1.
double noise_of(const Image& picture);

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

 private:
  Plate plate_;
  std::vector<std::uint8_t> changed_, seen_;
  bool empty_stage_ = false;
};

/// What is known of a pixel when a picture is cut.
enum class Certain : std::uint8_t { No, Backdrop, Subject };

/// The cheapest split into subject (255) and background (0): the sum of the odds of pixels on the wrong side
/// plus, for 8-neighbours on different sides, `smooth` times how alike they look, against the mean contrast
/// (Boykov, Jolly 2001). Exact: a minimum cut (core/graph_cut.h). `odds`: log of how much likelier subject
/// is than background. `certain`: empty, or of every pixel. `empty_stage`: empty, or what the camera sees
/// without a subject, RGB of the picture's size: edges are then those of what changed, so that the stage's
/// own are none, and skin before a wall of its colour has some (J. Sun, W. Zhang, X. Tang and H.-Y. Shum,
/// "Background Cut", ECCV 2006, attenuate the former). Deterministic.
Image cut_view(const Image& picture, std::span<const float> odds, std::span<const Certain> certain,
               double smooth, const Image& empty_stage = {});

}  // namespace floatstage::matting
