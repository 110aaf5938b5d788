#include <algorithm>
#include <cmath>

#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/guided_filter.h"

namespace floatstage::matting {

RefineOptions key_refinement() {
  RefineOptions options;
  options.hold = 5e-2;
  return options;
}

Result<Image> refine_matte(const Image& picture, const Image& matte, const RefineOptions& options,
                           const Image& keep) {
  if (matte.empty() || matte.channels != 1)
    return fail(ErrorCode::InvalidArgument, text("a matte to refine has one channel, not ", matte.channels));
  const double scale = static_cast<double>(picture.width) / matte.width,
               scale_y = static_cast<double>(picture.height) / matte.height;
  if (!(std::abs(scale - scale_y) <= 0.1 * std::max(scale, scale_y)))
    return fail(ErrorCode::InvalidArgument,
                text("the matte of ", matte.width, "x", matte.height, " has not the shape of the picture of ",
                     picture.width, "x", picture.height));
  const bool same = matte.width == picture.width && matte.height == picture.height;
  // The band is laid at the matte's own size, where its softness is, and then brought to the picture's.
  Image band = trimap_around(matte, options.band);
  Image start = matte;
  if (!same) {
    start = guided_filter(picture, matte);
    Image large(picture.width, picture.height, 1);
    for (int y = 0; y < large.height; ++y)
      for (int x = 0; x < large.width; ++x)
        *large.at(x, y) = *band.at(std::min(static_cast<int>((x + 0.5) / scale), matte.width - 1),
                                   std::min(static_cast<int>((y + 0.5) / scale_y), matte.height - 1));
    band = std::move(large);
  }
  if (!keep.empty()) {
    if (keep.width != picture.width || keep.height != picture.height || keep.channels != 1)
      return fail(ErrorCode::InvalidArgument,
                  text("what is to be kept is ", keep.width, "x", keep.height, ", but the picture is ",
                       picture.width, "x", picture.height));
    for (std::size_t p = 0; p < keep.pixels.size(); ++p)
      if (keep.pixels[p] == 0 || keep.pixels[p] == 255) band.pixels[p] = keep.pixels[p];
  }
  // A band that is too large to be solved at once has been solved at half the size already: what was carried
  // up stays.
  const auto unknown = std::count_if(band.pixels.begin(), band.pixels.end(),
                                     [](std::uint8_t v) { return v != 0 && v != 255; });
  if (unknown > options.solve.most_unknown) {
    for (std::size_t p = 0; p < band.pixels.size(); ++p)
      if (band.pixels[p] != 0 && band.pixels[p] != 255) band.pixels[p] = start.pixels[p];
    return band;
  }
  ClosedFormOptions solve = options.solve;
  solve.prior = options.hold;
  return closed_form_matte(picture, band, solve, start);
}

}  // namespace floatstage::matting
