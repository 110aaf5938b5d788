#pragma once

#include "core/image.h"

// Private to the stage.
namespace floatstage::matting {

/// Decides again which pixels near a key's outline are subject, by what the picture itself shows of either
/// side: a thing of the stage (a lamp, a pole, the seam between floor and wall) also stands where nobody is
/// near it, and a shaded fold has the colours of the clothes around it. Near the key a minimum cut weighs how
/// often each colour occurs well inside the key and well outside of it or in the picture's rim, against the
/// key and the outline's length (Rother, Kolmogorov, Blake, "GrabCut", 2004, with the key in the place of the
/// user, once). Colours are told apart on a square-root scale, since what is dark differs by fewer steps.
///
/// `picture`: RGB; `key`: one channel of its size. The result is 0 where it decides for the backing; 255, or
/// the key if that is subject already, where it decides for the subject. Without subject, or without anything
/// else, the key comes back.
Image second_look(const Image& picture, const Image& key);

}  // namespace floatstage::matting
