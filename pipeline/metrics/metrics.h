#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/image.h"

namespace floatstage::pipeline {

// How alike a rendered picture and a photograph are, inside a mask. docs/metrics.md says why each one is
// here.
//
// All functions: `rendered` and `truth` are of one size and channel count (1 or 3), `mask` has 1 channel and
// their size, and a pixel counts where the mask is >= 128. (Anything else is our bug and throws
// CheckFailure.) Nothing outside the mask has any influence. An empty mask gives NaN. Pure, thread safe, same
// result on any thread.

/// Peak signal-to-noise ratio in dB over all channels: 10 log10(255^2 / MSE). Infinity for equal pictures.
double psnr(const Image& rendered, const Image& truth, const Image& mask);

/// Structural similarity of the luma (Wang et al. 2004, eq. 13; 11x11 Gaussian window, sigma 1.5, K1 0.01, K2
/// 0.03): the mean of the SSIM map over the mask. Windows are cut off at the mask and renormalised there, so
/// that neither background nor the picture's edge enters.
double ssim(const Image& rendered, const Image& truth, const Image& mask);

/// Complex wavelet structural similarity of the luma (Sampat et al. 2009, eq. 7): steerable pyramid of 4
/// scales x 8 orientations, 7x7 windows in each subband, the mean over the mask and then over the subbands.
/// Small shifts turn the phases of all coefficients in a window alike and cost little. Outside the mask both
/// pictures get the truth's mean.
double cw_ssim(const Image& rendered, const Image& truth, const Image& mask);

/// PSNR after each 16x16 block of the truth has chosen the shift of at most 3 px in x and y under which the
/// rendered picture fits it best. Only pairs inside the mask count; a shift needs half of the block's pairs
/// to be admitted.
double psnr_shift(const Image& rendered, const Image& truth, const Image& mask);

/// Gradient energy of the rendered luma over that of the truth's: 1 as sharp, below 1 blurred, above 1 ghost
/// edges or noise. Central differences whose four pixels lie in the mask. NaN when there is none or the truth
/// is flat.
double sharpness(const Image& rendered, const Image& truth, const Image& mask);

/// PSNR after one gain and one offset a channel, those with the least squared error in the mask, were applied
/// to the rendered picture: what is left when exposure and white balance are forgiven. Never below psnr() but
/// for rounding.
double psnr_color(const Image& rendered, const Image& truth, const Image& mask);

/// The band `width` px wide about the outline of a silhouette (>= 128 is inside), half on each side; the
/// picture's edge is no outline. 255 and 0 only.
Image outline_band(const Image& silhouette, int width);

/// What a picture misses of the truth, to be compared with that of the next instant. Without what no mask
/// holds: a pixel of the mask has three differences, rendered - truth, in its rows' order.
struct PictureError {
  Image mask;  ///< 255 and 0 only
  std::vector<std::int16_t> differences;
};
PictureError picture_error(const Image& rendered, const Image& truth, const Image& mask);

/// Flicker: the mean of |error now - error before|, 8-bit levels, over channels and the pixels of both masks.
/// An error that stays is none, however large: only what comes and goes is seen. NaN where the masks do not
/// meet or differ in size.
double flicker(const PictureError& now, const PictureError& before);

/// What the tables of `evaluate` hold of one picture.
struct Scores {
  double psnr = 0;        ///< dB, in the mask
  double ssim = 0;        ///< -1 … 1, in the mask
  double cw_ssim = 0;     ///< 0 … 1, in the mask
  double psnr_shift = 0;  ///< dB, in the mask
  double sharpness = 0;   ///< ratio, in the mask
  double psnr_full = 0;   ///< dB, on the full silhouette: missing and surplus geometry counts
  // NaN where nobody filled them in:
  double psnr_edge = kUnknown;   ///< dB, in the band about the outline, both pictures over mid grey
  double psnr_color = kUnknown;  ///< dB, in the mask, after a gain and an offset a channel
  double ghosting = kUnknown;    ///< 8-bit levels: mean weighted distance of the colours that are blended
  double flicker = kUnknown;     ///< 8-bit levels: mean change of the error since the frame before
  double predicted_blurred = kUnknown, predicted_ghost = kUnknown;  ///< shares of the mask (Eq. 9.11, 9.12)
  double measured_blurred = kUnknown, measured_ghost = kUnknown;    ///< the same, by the flow
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
};

/// The first six of them; `silhouette` is the mask of `psnr_full`.
Scores score(const Image& rendered, const Image& truth, const Image& mask, const Image& silhouette);

/// The mask without what lies within `px` of a pixel outside it (Euclidean). The picture's edge erodes
/// nothing: a subject that it cuts off is as good there as anywhere. 255 and 0 only.
Image erode_mask(const Image& mask, int px);

}  // namespace floatstage::pipeline
