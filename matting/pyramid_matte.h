#pragma once

#include "core/image.h"
#include "core/result.h"
#include "matting/closed_form.h"

namespace floatstage::matting {

struct PyramidOptions {
  ClosedFormOptions solve;  ///< of each level; its `prior` is not used: `hold` is
  double hold = 1.5e-2;     ///< how hard a level is held to the one above it; 0 … 1e3
  int smallest_side = 20;   ///< px: no level has a shorter side than this; at least 3

  Result<void> check() const;
};

/// Closed-form matting from coarse to fine (ADR 265): the opacity is solved at the smallest size at which the
/// trimap still says what it says, and every larger size is solved in the soft band of the one before, held
/// to it. What is far from anything known is thus decided by large windows, where eq. 15 alone spreads what
/// is known through 3x3 windows pixel by pixel and loses it (Levin, Lischinski, Weiss, PAMI 2008, use a
/// pyramid for speed alone).
///
/// A level is made by halves while its shorter side has `smallest_side` px and both what is known as subject
/// and as background keep half of their share of the picture: a subject that is known by a thin line only
/// begins at full size, and is then closed_form_matte(). `picture` and `trimap` as there. A band of more than
/// `solve.most_unknown` pixels is solved in strips. Deterministic, one thread; 8 megapixels, a sixth of them
/// unknown, take some 20 s and 1.5 GB. Errors: what check() and closed_form_matte() find.
Result<Image> pyramid_matte(const Image& picture, const Image& trimap, const PyramidOptions& options = {});

}  // namespace floatstage::matting
