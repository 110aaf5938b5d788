// Method:  closed-form matting solved from coarse to fine, each size held to the one before
// Paper:   A. Levin, D. Lischinski, Y. Weiss, "A closed-form solution to natural image matting", 2008, eq.
//          15; its pyramid, with a hold
// Differs: the coarse matte is a prior in the band instead of a bound on what is solved again
// ADR:     0265

#include "matting/pyramid_matte.h"

#include <algorithm>

#include "core/text.h"
#include "matting/half_trimap.h"
#include "matting/picture_scale.h"

namespace floatstage::matting {
namespace {

// The share of a region that a smaller trimap may lose before it says something else.
constexpr double kKeptShare = 0.5;

double share_of(const Image& trimap, std::uint8_t value) {
  return static_cast<double>(std::count(trimap.pixels.begin(), trimap.pixels.end(), value)) /
         static_cast<double>(trimap.pixels.size());
}

bool says_the_same(const Image& half, const Image& trimap) {
  for (const std::uint8_t side : {0, 255})
    if (share_of(half, side) < kKeptShare * share_of(trimap, side)) return false;
  return true;
}

Result<Image> solve(const Image& picture, const Image& trimap, const PyramidOptions& options) {
  const int width = picture.width / 2, height = picture.height / 2;
  if (std::min(width, height) < options.smallest_side || trimap.width != picture.width ||
      trimap.height != picture.height)
    return closed_form_matte(picture, trimap, options.solve);
  const Image half = half_trimap(trimap, width, height);
  if (!says_the_same(half, trimap)) return closed_form_matte(picture, trimap, options.solve);
  const Result<Image> coarse = solve(scaled(picture, width, height), half, options);
  if (!coarse) return coarse;
  RefineOptions refine;
  refine.solve = options.solve;
  refine.hold = options.hold;
  return refine_matte(picture, *coarse, refine, trimap);
}

}  // namespace

Result<void> PyramidOptions::check() const {
  if (Result<void> ok = solve.check(); !ok) return ok;
  if (!(hold >= 0 && hold <= 1e3))
    return fail(ErrorCode::InvalidArgument, text("hold is ", hold, "; it must be 0 to 1000"));
  if (smallest_side < 3)
    return fail(ErrorCode::InvalidArgument,
                text("smallest_side is ", smallest_side, "; it must be at least 3"));
  return {};
}

Result<Image> pyramid_matte(const Image& picture, const Image& trimap, const PyramidOptions& options) {
  if (Result<void> ok = options.check(); !ok) return forward(ok);
  if (picture.empty() || trimap.empty() || trimap.channels != 1)
    return closed_form_matte(picture, trimap, options.solve);  // which says what is wrong
  return solve(picture, trimap, options);
}

}  // namespace floatstage::matting
