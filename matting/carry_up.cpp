#include <cmath>

#include "core/text.h"
#include "matting/video/affine_carry.h"
#include "matting/video/video_matting.h"

namespace floatstage::matting {
namespace {

constexpr double kAspect = 0.02;  // how far the two aspects may differ

}  // namespace

Result<Image> carry_up(const Image& matte, const Image& photograph) {
  if (matte.channels != 1 || matte.empty())
    return fail(ErrorCode::InvalidArgument,
                text("a matte of ", matte.channels, " channels cannot be carried up"));
  if ((photograph.channels != 1 && photograph.channels != 3) || photograph.empty())
    return fail(ErrorCode::InvalidArgument,
                text("a matte cannot be carried up to a photograph of ", photograph.channels, " channels"));
  if (matte.width == photograph.width && matte.height == photograph.height) return matte;
  const double aspect = static_cast<double>(matte.width) * photograph.height /
                        (static_cast<double>(matte.height) * photograph.width);
  if (std::abs(aspect - 1) > kAspect)
    return fail(ErrorCode::InvalidArgument,
                text("a matte of ", matte.width, "x", matte.height, " does not fit a photograph of ",
                     photograph.width, "x", photograph.height));
  return carried_up(photograph, matte);
}

Image silhouette_of(const Image& matte, int threshold) {
  Image out(matte.width, matte.height, 1);
  for (std::size_t p = 0; p < out.pixels.size(); ++p) out.pixels[p] = matte.pixels[p] >= threshold ? 255 : 0;
  return out;
}

}  // namespace floatstage::matting
