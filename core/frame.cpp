#include "core/frame.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "core/frame_pixels.h"
#include "core/text.h"

namespace floatstage {
namespace {

constexpr std::array<const char*, 6> kFormats = {"gray8", "rgb8", "yuyv", "nv12", "bayer-rggb8", "mjpeg"};
constexpr std::array<const char*, 3> kStatuses = {"ok", "corrupt", "lost"};

template <class Enum, std::size_t N>
std::optional<Enum> named(const std::array<const char*, N>& names, std::string_view name) {
  for (std::size_t i = 0; i < N; ++i)
    if (name == names[i]) return static_cast<Enum>(i);
  return std::nullopt;
}

// Bytes of one row that belong to the picture; chroma pairs are whole also where the width is odd.
std::size_t row_bytes(PixelFormat format, int width) {
  const std::size_t w = static_cast<std::size_t>(width);
  switch (format) {
    case PixelFormat::Gray8:
    case PixelFormat::BayerRggb8:
      return w;
    case PixelFormat::Rgb8:
      return w * 3;
    case PixelFormat::Yuyv:
      return (w + 1) / 2 * 4;
    case PixelFormat::Nv12:
      return (w + 1) / 2 * 2;
    case PixelFormat::Mjpeg:
      return 0;
  }
  return 0;
}

std::size_t row_count(PixelFormat format, int height) {
  return static_cast<std::size_t>(format == PixelFormat::Nv12 ? height + (height + 1) / 2 : height);
}

bool holds_its_picture(const ImageLayout& l) {
  if (l.width <= 0 || l.height <= 0) return false;
  const std::size_t row = row_bytes(l.format, l.width);
  return l.stride >= row && l.size_bytes >= l.stride * (row_count(l.format, l.height) - 1) + row;
}

// Bilinear demosaicing of RGGB: each missing colour is the mean of its neighbours of that colour (mirrored at
// borders).
void demosaic(const std::uint8_t* raw, std::size_t stride, Image& out) {
  const int w = out.width, h = out.height;
  auto mirror = [](int v, int n) {
    return v < 0 ? std::min(-v, n - 1) : v >= n ? std::max(2 * n - 2 - v, 0) : v;
  };
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      int sum[3] = {0, 0, 0}, count[3] = {0, 0, 0};
      const int own = (y & 1) + (x & 1);  // 0 red, 1 green, 2 blue: RGGB
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const int sx = mirror(x + dx, w), sy = mirror(y + dy, h);
          const int channel = (sy & 1) + (sx & 1);
          if (channel == own && (dx != 0 || dy != 0)) continue;
          sum[channel] += raw[static_cast<std::size_t>(sy) * stride + static_cast<std::size_t>(sx)];
          ++count[channel];
        }
      }
      for (int c = 0; c < 3; ++c)
        out.at(x, y)[c] = static_cast<std::uint8_t>(count[c] ? (sum[c] + count[c] / 2) / count[c] : 0);
    }
  }
}

}  // namespace

const char* name_of(PixelFormat format) { return kFormats[static_cast<std::size_t>(format)]; }
const char* name_of(FrameStatus status) { return kStatuses[static_cast<std::size_t>(status)]; }
std::optional<PixelFormat> pixel_format_named(std::string_view name) {
  return named<PixelFormat>(kFormats, name);
}
std::optional<FrameStatus> frame_status_named(std::string_view name) {
  return named<FrameStatus>(kStatuses, name);
}

ImageLayout packed_layout(PixelFormat format, int width, int height) {
  FLOATSTAGE_CHECK(format != PixelFormat::Mjpeg, "a compressed format has no packed layout");
  const std::size_t stride = row_bytes(format, width);
  return {format, width, height, stride, stride * row_count(format, height)};
}

Frame make_frame(FrameInfo info, const Image& image) {
  Frame frame = borrowed_frame(info, image);
  auto bytes = std::make_shared<std::byte[]>(image.pixels.size());
  std::memcpy(bytes.get(), image.pixels.data(), image.pixels.size());
  frame.pixels = std::move(bytes);
  return frame;
}

Frame borrowed_frame(FrameInfo info, const Image& image) {
  FLOATSTAGE_CHECK(image.channels == 1 || image.channels == 3,
                   text("a frame of ", image.channels, " channels"));
  const PixelFormat format = image.channels == 1 ? PixelFormat::Gray8 : PixelFormat::Rgb8;
  const auto* bytes = reinterpret_cast<const std::byte*>(image.pixels.data());
  return {info, packed_layout(format, image.width, image.height),
          std::shared_ptr<const std::byte[]>(std::shared_ptr<void>(), bytes)};  // owns nothing
}

Result<void> check_readable(const Frame& frame) {
  const ImageLayout& l = frame.layout;
  if (frame.empty())
    return fail(ErrorCode::NotFound, text("camera ", frame.info.camera, " has no picture at this instant"));
  if (l.format == PixelFormat::Mjpeg)
    return fail(ErrorCode::Unsupported, "an MJPEG frame must be decoded by its capture source first");
  if (!holds_its_picture(l))
    return fail(ErrorCode::BadData, text("camera ", frame.info.camera, ": a frame of ", l.size_bytes,
                                         " bytes in rows of ", l.stride, " is shorter than its ", l.width,
                                         "x", l.height, " ", name_of(l.format), " layout"));
  return {};
}

Result<Image> to_rgb(const Frame& frame) {
  Image rgb;
  if (Result<void> ok = to_rgb(frame, rgb); !ok) return forward(ok);
  return rgb;
}

Result<void> to_rgb(const Frame& frame, Image& rgb) {
  if (Result<void> ok = check_readable(frame); !ok) return ok;
  const ImageLayout& l = frame.layout;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(frame.pixels.get());
  rgb.resize(l.width, l.height, 3);
  if (l.format == PixelFormat::BayerRggb8) {
    demosaic(bytes, l.stride, rgb);
    return {};
  }
  for (int y = 0; y < l.height; ++y) {
    const std::uint8_t* row = bytes + static_cast<std::size_t>(y) * l.stride;
    std::uint8_t* out = rgb.at(0, y);
    switch (l.format) {
      case PixelFormat::Rgb8:
        std::memcpy(out, row, static_cast<std::size_t>(l.width) * 3);
        break;
      case PixelFormat::Gray8:
        for (int x = 0; x < l.width; ++x) std::fill_n(out + 3 * x, 3, row[x]);
        break;
      case PixelFormat::Yuyv:
        for (int x = 0; x < l.width; ++x) {
          const std::uint8_t* pair = row + (x / 2) * 4;
          yuv_to_rgb(row[2 * x], pair[1], pair[3], out + 3 * x);
        }
        break;
      case PixelFormat::Nv12: {
        const std::uint8_t* chroma = bytes + l.stride * static_cast<std::size_t>(l.height) +
                                     static_cast<std::size_t>(y / 2) * l.stride;
        for (int x = 0; x < l.width; ++x)
          yuv_to_rgb(row[x], chroma[x / 2 * 2], chroma[x / 2 * 2 + 1], out + 3 * x);
        break;
      }
      default:
        break;
    }
  }
  return {};
}

}  // namespace floatstage
