#include <algorithm>
#include <cmath>
#include <vector>

#include "core/text.h"
#include "matting/closed_form.h"
#include "matting/guided_filter.h"

namespace floatstage::matting {
namespace {

// Rows beyond a strip that are solved with it and thrown away: what is farther is not felt by held pixels.
constexpr int kApron = 48;

Image rows_of(const Image& image, int from, int to) {
  const std::size_t row = static_cast<std::size_t>(image.width) * image.channels;
  Image out(image.width, to - from, image.channels);
  std::copy_n(image.pixels.begin() + static_cast<std::ptrdiff_t>(row * from), out.pixels.size(),
              out.pixels.begin());
  return out;
}

// Where a strip from `from` on ends whose band, aprons included, is not above `most`; `from` when there is
// none.
int end_of_strip(const std::vector<long>& unknown_above, int from, long most) {
  const int rows = static_cast<int>(unknown_above.size()) - 1;
  int end = from;
  while (end < rows &&
         unknown_above[std::min(rows, end + 1 + kApron)] - unknown_above[std::max(0, from - kApron)] <= most)
    ++end;
  return end;
}

// Closed form in a band however large. A strip that cannot be solved at once keeps what was carried up.
Result<Image> solve_in_strips(const Image& picture, const Image& band, const ClosedFormOptions& options,
                              const Image& start) {
  std::vector<long> unknown_above(static_cast<std::size_t>(band.height) + 1, 0);
  for (int y = 0; y < band.height; ++y)
    unknown_above[y + 1] =
        unknown_above[y] + std::count_if(band.at(0, y), band.at(0, y) + band.width,
                                         [](std::uint8_t v) { return v != 0 && v != 255; });
  if (unknown_above.back() <= options.most_unknown) return closed_form_matte(picture, band, options, start);
  Image out = band;
  for (int from = 0; from < band.height;) {
    int end = end_of_strip(unknown_above, from, options.most_unknown);
    const int top = std::max(0, from - kApron), bottom = std::min(band.height, end + kApron);
    Image solved;
    if (end > from && bottom - top >= 3) {
      Result<Image> strip = closed_form_matte(rows_of(picture, top, bottom), rows_of(band, top, bottom),
                                              options, rows_of(start, top, bottom));
      if (!strip) return strip;
      solved = std::move(*strip);
    } else {
      end = from + 1;
    }
    for (int y = from; y < end; ++y)
      for (int x = 0; x < band.width; ++x)
        if (std::uint8_t& v = *out.at(x, y); v != 0 && v != 255)
          v = solved.empty() ? *start.at(x, y) : *solved.at(x, y - top);
    from = end;
  }
  return out;
}

}  // namespace

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
  ClosedFormOptions solve = options.solve;
  solve.prior = options.hold;
  return solve_in_strips(picture, band, solve, start);
}

}  // namespace floatstage::matting
