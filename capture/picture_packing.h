#pragma once

// Private to capture/: how a sensor's pixels become a libav picture and come back, bit by bit unless the
// codec is lossy.

#include "capture/libav.h"
#include "capture/take.h"
#include "core/frame.h"

namespace floatstage::capture {

/// One picture format of one recording. Not thread safe.
class PicturePacking {
 public:
  /// Unsupported for Mjpeg. Sizes must be positive.
  static Result<PicturePacking> create(TakeCodec codec, PixelFormat format, int width, int height);

  /// What the encoder is given and the decoder must return.
  AVPixelFormat pixel_format() const { return pixel_format_; }
  const ImageLayout& layout() const { return layout_; }

  /// Fills `picture`, which has pixel_format() and this size. The frame's stride may be any.
  void pack(const Frame& frame, AVFrame& picture) const;

  /// The other way, into layout().size_bytes zeroed bytes. False when the picture is not of this format or
  /// size.
  bool unpack(const AVFrame& picture, std::byte* out) const;
  /// Pixels that begin at column x and row y of the picture.
  struct Part {
    std::byte* bytes;
    ImageLayout layout;
    int x, y;
  };
  /// Of a codec that loses nothing what lies within `box`, whole_pixels(), into its place in a part that
  /// holds it.
  bool unpack(const AVFrame& picture, const PixelBox& box, const Part& out) const;

 private:
  bool fits(const AVFrame& picture) const;

  TakeCodec codec_ = TakeCodec::Ffv1;
  AVPixelFormat pixel_format_ = AV_PIX_FMT_NONE;
  ImageLayout layout_;
  libav::Owned<SwsContext> to_yuv_, to_rgb_;  // lossy RGB only
  mutable libav::RoomyCopy roomy_;            // memory, kept from picture to picture
};

}  // namespace floatstage::capture
