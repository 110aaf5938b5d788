#include "capture/stream/fitted_picture.h"

extern "C" {
#include <libavutil/imgutils.h>
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <array>
#include <cmath>

#include "core/check.h"

namespace floatstage::capture {
namespace {

int even(double length, int most) {
  return std::clamp(2 * static_cast<int>(std::lround(length / 2)), 2, most);
}

}  // namespace

FittedPicture::FittedPicture(int width, int height, AVPixelFormat format)
    : width_(width), height_(height), format_(format) {
  frame_->format = format;
  frame_->width = width;
  frame_->height = height;
  frame_->color_range = AVCOL_RANGE_MPEG;
  frame_->colorspace = AVCOL_SPC_BT709;
  frame_->color_primaries = AVCOL_PRI_BT709;
  frame_->color_trc = AVCOL_TRC_BT709;
  FLOATSTAGE_CHECK(av_frame_get_buffer(frame_.get(), 0) >= 0, "out of memory");
}

void FittedPicture::fill_black() {
  std::array<std::ptrdiff_t, 4> strides{};
  std::copy_n(frame_->linesize, 4, strides.begin());
  av_image_fill_black(frame_->data, strides.data(), format_, AVCOL_RANGE_MPEG, width_, height_);
}

void FittedPicture::prepare(int width, int height) {
  if (width == from_width_ && height == from_height_) return;
  const double scale = std::min(static_cast<double>(width_) / width, static_cast<double>(height_) / height);
  const int to_width = even(scale * width, width_), to_height = even(scale * height, height_);
  constexpr int kExact = SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_BILINEAR;
  scaler_.reset(sws_getContext(width, height, AV_PIX_FMT_RGB24, to_width, to_height, format_, kExact, nullptr,
                               nullptr, nullptr));
  FLOATSTAGE_CHECK(scaler_ != nullptr, "libswscale converts RGB");
  libav::set_bt709(scaler_.get(), true, (av_pix_fmt_desc_get(format_)->flags & AV_PIX_FMT_FLAG_RGB) != 0);
  from_width_ = width, from_height_ = height;
  x_ = (width_ - to_width) / 4 * 2, y_ = (height_ - to_height) / 4 * 2;
}

AVFrame* FittedPicture::of(const Image& rgb) {
  const bool other = rgb.width != from_width_ || rgb.height != from_height_;
  prepare(rgb.width, rgb.height);
  FLOATSTAGE_CHECK(av_frame_make_writable(frame_.get()) >= 0, "out of memory");
  if (other) fill_black();
  const AVPixFmtDescriptor& format = *av_pix_fmt_desc_get(format_);
  std::array<std::uint8_t*, 4> planes{};
  for (int p = 0; p < av_pix_fmt_count_planes(format_); ++p) {
    const bool chroma = p > 0 && (format.flags & AV_PIX_FMT_FLAG_RGB) == 0;
    const int y = chroma ? y_ >> format.log2_chroma_h : y_;
    planes[static_cast<std::size_t>(p)] = frame_->data[p] +
                                          static_cast<std::ptrdiff_t>(y) * frame_->linesize[p] +
                                          av_image_get_linesize(format_, x_, p);
  }
  const std::uint8_t* from[4] = {roomy_.of(rgb.pixels.data(), rgb.pixels.size()), nullptr, nullptr, nullptr};
  const int strides[4] = {3 * rgb.width, 0, 0, 0};
  sws_scale(scaler_.get(), from, strides, 0, rgb.height, planes.data(), frame_->linesize);
  return frame_.get();
}

}  // namespace floatstage::capture
