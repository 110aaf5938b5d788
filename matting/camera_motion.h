#pragma once

#include "core/image.h"

namespace floatstage::matting {

/// What stood still between two pictures of one camera, by the corners that it can follow.
struct CameraStillness {
  int textured = 0;   ///< cells of a grid over the picture that show corners
  int still = 0;      ///< of them: most of whose corners are where they were
  int elsewhere = 0;  ///< of them: most of whose corners were found again in another place
  double moved = 0;   ///< px of the pictures: middle way of the corners that were found again elsewhere
  double spread = 0;  ///< share of the grid's rows and columns that textured cells lie in, the smaller one

  /// Whether the pictures tell: a few cells, all over the picture. Before plain cloth only the performer has
  /// corners, and he says nothing about the camera.
  bool tells() const;
  /// Whether the camera itself moved: hardly anything, wherever it looks, is where it was, and much of it is
  /// elsewhere. A performer who walks through the picture leaves most of the place behind him as it is, and a
  /// picture that went dark is not elsewhere.
  bool camera_moved() const;
};

/// Compares two RGB pictures of one size, of the same camera, whatever lies between them in time. Corners are
/// followed with sub-pixel precision there and back; one that is not found again is neither still nor
/// elsewhere. Nothing is found in pictures of less than 32 px. Deterministic; one thread.
CameraStillness stillness_between(const Image& a, const Image& b);

}  // namespace floatstage::matting
