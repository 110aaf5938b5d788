#pragma once

#include "core/image.h"
#include "core/result.h"

namespace floatstage::matting {

struct Layers {
  Image foreground, background;  ///< RGB; picture = a * foreground + (1 - a) * background
};

struct ForegroundOptions {
  double smooth = 1e-5;  ///< weight of smoothness everywhere
  double at_edges =
      1;  ///< weight of smoothness a unit of opacity's step: colours go on across the matte's edge
  int coarse_steps = 10;  ///< sweeps a level up to 32 px
  int fine_steps = 2;     ///< sweeps a level beyond
};

/// The colours of subject and background in every pixel of a matted picture: minimises
///   sum (a F + (1 - a) B - I)^2
///   + sum over 4-neighbours (smooth + at_edges |a_i - a_j|) ((F_i - F_j)^2 + (B_i - B_j)^2)
/// level by level from one pixel upwards, each level begun with the colours of the level below (Germer,
/// Uelwer, Conrad, Harmeling, "Fast Multi-Level Foreground Estimation", 2020, eq. 4). Where the subject is
/// absent its colour is that of the nearest subject, so that a straight-alpha picture scales without fringes.
/// `picture`: RGB; `matte`: one channel of its size, else InvalidArgument. Deterministic, one thread.
Result<Layers> estimate_foreground(const Image& picture, const Image& matte,
                                   const ForegroundOptions& options = {});

enum class BackingChannel { Green = 1, Blue = 2 };

/// Takes the light that a cloth throws off a picture of the subject: limits the cloth's channel to a mix of
/// the other two, (1 - average) * max + average * mean. 0 leaves every colour alone in which the channel does
/// not lead; 1 also takes the cast off skin and grey. Light that went is given back to all channels when
/// `keep_luma`. `rgb` has 3 channels.
void despill(Image& rgb, BackingChannel channel, double average = 0, bool keep_luma = false);

}  // namespace floatstage::matting
