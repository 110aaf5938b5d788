#include "capture/picture_packing.h"

#include <cstring>

#include "core/text.h"

namespace floatstage::capture {
namespace {

AVPixelFormat format_for(TakeCodec codec, PixelFormat format) {
  switch (format) {
    case PixelFormat::Gray8:
    case PixelFormat::BayerRggb8:
      return AV_PIX_FMT_GRAY8;
    case PixelFormat::Rgb8:
      // Each codec's nearest: FFV1 has no packed 24-bit RGB, Matroska stores raw RGB only as the 24-bit
      // bitmaps of old, and 4:4:4 keeps the colour edges that keying lives on.
      return codec == TakeCodec::Ffv1  ? AV_PIX_FMT_BGR0
             : codec == TakeCodec::Raw ? AV_PIX_FMT_BGR24
                                       : AV_PIX_FMT_YUV444P;
    case PixelFormat::Yuyv:
      return codec == TakeCodec::Raw ? AV_PIX_FMT_YUYV422 : AV_PIX_FMT_YUV422P;
    case PixelFormat::Nv12:
      return codec == TakeCodec::Raw ? AV_PIX_FMT_NV12 : AV_PIX_FMT_YUV420P;
    case PixelFormat::Mjpeg:
      break;
  }
  return AV_PIX_FMT_NONE;
}

// libav has second names for full-range YUV; the planes are the same.
int without_range(int format) {
  switch (format) {
    case AV_PIX_FMT_YUVJ420P:
      return AV_PIX_FMT_YUV420P;
    case AV_PIX_FMT_YUVJ422P:
      return AV_PIX_FMT_YUV422P;
    case AV_PIX_FMT_YUVJ444P:
      return AV_PIX_FMT_YUV444P;
    default:
      return format;
  }
}

void rgb_to_bgr(const std::uint8_t* in, int width, int bytes_out, std::uint8_t* out) {
  if (bytes_out == 4) {
    for (int x = 0; x < width; ++x, in += 3, out += 4) {
      out[0] = in[2];
      out[1] = in[1];
      out[2] = in[0];
      out[3] = 0;
    }
    return;
  }
  for (int x = 0; x < width; ++x, in += 3, out += 3) {
    out[0] = in[2];
    out[1] = in[1];
    out[2] = in[0];
  }
}

void bgr_to_rgb(const std::uint8_t* in, int width, int bytes_in, std::uint8_t* out) {
  for (int x = 0; x < width; ++x, in += bytes_in, out += 3) {
    out[0] = in[2];
    out[1] = in[1];
    out[2] = in[0];
  }
}

}  // namespace

Result<PicturePacking> PicturePacking::create(TakeCodec codec, PixelFormat format, int width, int height) {
  PicturePacking packing;
  packing.codec_ = codec;
  packing.pixel_format_ = format_for(codec, format);
  if (packing.pixel_format_ == AV_PIX_FMT_NONE)
    return fail(ErrorCode::Unsupported, text("a take stores uncompressed pictures, not ", name_of(format),
                                             "; let the capture source decode them"));
  packing.layout_ = packed_layout(format, width, height);
  if (packing.pixel_format_ == AV_PIX_FMT_YUV444P) {
    constexpr int kExact = SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_FULL_CHR_H_INT | SWS_POINT;
    auto scaler = [&](AVPixelFormat from, AVPixelFormat to) {
      libav::Owned<SwsContext> made(
          sws_getContext(width, height, from, width, height, to, kExact, nullptr, nullptr, nullptr));
      if (made) libav::set_bt709(made.get(), true, true);
      return made;
    };
    packing.to_yuv_ = scaler(AV_PIX_FMT_RGB24, AV_PIX_FMT_YUV444P);
    packing.to_rgb_ = scaler(AV_PIX_FMT_YUV444P, AV_PIX_FMT_RGB24);
    if (!packing.to_yuv_ || !packing.to_rgb_)
      return fail(ErrorCode::Unsupported,
                  text("cannot convert ", width, "x", height, " RGB pictures to YUV"));
  }
  return packing;
}

void PicturePacking::pack(const Frame& frame, AVFrame& picture) const {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(frame.pixels.get());
  const std::size_t stride = frame.layout.stride;
  const int width = layout_.width, height = layout_.height, half = (width + 1) / 2;
  if (to_yuv_) {
    const std::size_t size =
        (static_cast<std::size_t>(height) - 1) * stride + 3 * static_cast<std::size_t>(width);
    const std::uint8_t* planes[4] = {roomy_.of(bytes, size), nullptr, nullptr, nullptr};
    const int strides[4] = {static_cast<int>(stride), 0, 0, 0};
    sws_scale(to_yuv_.get(), planes, strides, 0, height, picture.data, picture.linesize);
    return;
  }
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* in = bytes + static_cast<std::size_t>(y) * stride;
    auto out = [&](int plane, int row) {
      return picture.data[plane] + static_cast<std::ptrdiff_t>(row) * picture.linesize[plane];
    };
    switch (layout_.format) {
      case PixelFormat::Gray8:
      case PixelFormat::BayerRggb8:
        std::memcpy(out(0, y), in, static_cast<std::size_t>(width));
        break;
      case PixelFormat::Rgb8:
        rgb_to_bgr(in, width, codec_ == TakeCodec::Ffv1 ? 4 : 3, out(0, y));
        break;
      case PixelFormat::Yuyv:
        if (codec_ == TakeCodec::Raw) {
          std::memcpy(out(0, y), in, static_cast<std::size_t>(half) * 4);
          break;
        }
        for (int x = 0; x < half; ++x) {
          out(0, y)[2 * x] = in[4 * x];
          if (2 * x + 1 < width) out(0, y)[2 * x + 1] = in[4 * x + 2];
          out(1, y)[x] = in[4 * x + 1];
          out(2, y)[x] = in[4 * x + 3];
        }
        break;
      case PixelFormat::Nv12: {
        std::memcpy(out(0, y), in, static_cast<std::size_t>(width));
        if (y % 2) break;
        const std::uint8_t* chroma = bytes + stride * static_cast<std::size_t>(height + y / 2);
        if (codec_ == TakeCodec::Raw) {
          std::memcpy(out(1, y / 2), chroma, static_cast<std::size_t>(half) * 2);
          break;
        }
        for (int x = 0; x < half; ++x) {
          out(1, y / 2)[x] = chroma[2 * x];
          out(2, y / 2)[x] = chroma[2 * x + 1];
        }
        break;
      }
      case PixelFormat::Mjpeg:
        FLOATSTAGE_CHECK(false, "create() refuses Mjpeg");
    }
  }
}

bool PicturePacking::unpack(const AVFrame& picture, std::byte* out) const {
  if (!to_rgb_) return unpack(picture, {0, 0, layout_.width, layout_.height}, {out, layout_, 0, 0});
  if (!fits(picture)) return false;
  std::uint8_t* planes[4] = {reinterpret_cast<std::uint8_t*>(out), nullptr, nullptr, nullptr};
  const int strides[4] = {static_cast<int>(layout_.stride), 0, 0, 0};
  sws_scale(to_rgb_.get(), picture.data, picture.linesize, 0, layout_.height, planes, strides);
  return true;
}

bool PicturePacking::fits(const AVFrame& picture) const {
  // H.264's decoder returns grey pictures with flat chroma planes; the first plane is what was recorded.
  const bool lossy_gray = codec_ == TakeCodec::H264 && pixel_format_ == AV_PIX_FMT_GRAY8;
  const int format = without_range(picture.format);
  return picture.width == layout_.width && picture.height == layout_.height &&
         (format == pixel_format_ || (lossy_gray && format == AV_PIX_FMT_YUV420P));
}

bool PicturePacking::unpack(const AVFrame& picture, const PixelBox& box, const Part& part) const {
  FLOATSTAGE_CHECK(!to_rgb_, "pictures that are scaled come back whole");
  if (!fits(picture)) return false;
  auto* bytes = reinterpret_cast<std::uint8_t*>(part.bytes);
  const int width = box.width, half = (width + 1) / 2;
  const std::size_t stride = part.layout.stride;
  for (int y = 0; y < box.height; ++y) {
    const int row = box.y + y;
    // From the box's column on, in a plane with a column for so many of the picture, of so many bytes.
    auto in = [&](int plane, int at, int columns, int size) -> const std::uint8_t* {
      return picture.data[plane] + static_cast<std::ptrdiff_t>(at) * picture.linesize[plane] +
             box.x / columns * size;
    };
    auto to = [&](int at, int columns, int size) {
      return bytes + stride * static_cast<std::size_t>(at) + (box.x - part.x) / columns * size;
    };
    switch (layout_.format) {
      case PixelFormat::Gray8:
      case PixelFormat::BayerRggb8:
        std::memcpy(to(row - part.y, 1, 1), in(0, row, 1, 1), static_cast<std::size_t>(width));
        break;
      case PixelFormat::Rgb8: {
        const int size = codec_ == TakeCodec::Ffv1 ? 4 : 3;
        bgr_to_rgb(in(0, row, 1, size), width, size, to(row - part.y, 1, 3));
        break;
      }
      case PixelFormat::Yuyv: {
        std::uint8_t* out = to(row - part.y, 2, 4);
        if (codec_ == TakeCodec::Raw) {
          std::memcpy(out, in(0, row, 2, 4), static_cast<std::size_t>(half) * 4);
          break;
        }
        const std::uint8_t *luma = in(0, row, 1, 1), *blue = in(1, row, 2, 1), *red = in(2, row, 2, 1);
        for (int x = 0; x < half; ++x) {
          out[4 * x] = luma[2 * x];
          if (2 * x + 1 < width) out[4 * x + 2] = luma[2 * x + 1];
          out[4 * x + 1] = blue[x];
          out[4 * x + 3] = red[x];
        }
        break;
      }
      case PixelFormat::Nv12: {
        std::memcpy(to(row - part.y, 1, 1), in(0, row, 1, 1), static_cast<std::size_t>(width));
        if (y % 2) break;
        std::uint8_t* chroma = to(part.layout.height + (row - part.y) / 2, 2, 2);
        if (codec_ == TakeCodec::Raw) {
          std::memcpy(chroma, in(1, row / 2, 2, 2), static_cast<std::size_t>(half) * 2);
          break;
        }
        const std::uint8_t *blue = in(1, row / 2, 2, 1), *red = in(2, row / 2, 2, 1);
        for (int x = 0; x < half; ++x) {
          chroma[2 * x] = blue[x];
          chroma[2 * x + 1] = red[x];
        }
        break;
      }
      case PixelFormat::Mjpeg:
        FLOATSTAGE_CHECK(false, "create() refuses Mjpeg");
    }
  }
  return true;
}

}  // namespace floatstage::capture
