#include "matting/guided_upsample.h"

#include <cmath>

#include "core/text.h"
#include "matting/guided_filter.h"

namespace floatstage::matting {
namespace {

constexpr double kAspect = 0.02;  // how far the two aspects may differ

}  // namespace

Result<Image> guided_upsample(const Image& matte, const Image& photograph) {
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
  return guided_filter(photograph, matte);
}

}  // namespace floatstage::matting
