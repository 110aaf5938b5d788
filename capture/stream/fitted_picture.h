#pragma once

#include "capture/libav.h"
#include "core/image.h"

namespace floatstage::capture {

/// Puts RGB pictures of any size into a YUV or RGB frame of one size: as large as they fit, in its middle,
/// with black bars. BT.709, limited range.
class FittedPicture {
 public:
  FittedPicture(int width, int height, AVPixelFormat format);
  /// The frame stays this object's; good until the next call.
  AVFrame* of(const Image& rgb);

 private:
  void prepare(int width, int height);
  void fill_black();

  const int width_, height_;
  const AVPixelFormat format_;
  libav::Owned<AVFrame> frame_ = libav::new_frame();
  libav::Owned<SwsContext> scaler_;
  libav::RoomyCopy roomy_;
  int from_width_ = 0, from_height_ = 0, x_ = 0, y_ = 0;
};

}  // namespace floatstage::capture
