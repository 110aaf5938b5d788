#include <algorithm>
#include <cstring>
#include <vector>

#include "core/check.h"
#include "core/frame_pixels.h"
#include "core/text.h"

namespace floatstage {
namespace {

struct Source {
  const std::uint8_t* bytes;
  const ImageLayout& layout;
  const std::uint8_t* row(int y) const { return bytes + static_cast<std::size_t>(y) * layout.stride; }
  const std::uint8_t* chroma_row(int y) const { return row(layout.height + y); }  // Nv12
};

/// Interleaved bytes, whatever they mean: rows are summed first, which compilers vectorise.
void shrink_packed(const Source& in, int factor, std::vector<std::uint32_t>& sums, Image& out) {
  const int channels = out.channels, whole = in.layout.width / factor;
  const auto line = static_cast<std::size_t>(in.layout.width) * static_cast<std::size_t>(channels);
  sums.resize(line);
  for (int y = 0; y < out.height; ++y) {
    const int first = y * factor, rows = std::min(factor, in.layout.height - first);
    std::copy_n(in.row(first), line, sums.begin());
    for (int r = 1; r < rows; ++r) {
      const std::uint8_t* from = in.row(first + r);
      for (std::size_t i = 0; i < line; ++i) sums[i] += from[i];
    }
    std::uint8_t* to = out.at(0, y);
    const auto mean = [&](int x, int columns) {
      const std::uint32_t count = static_cast<std::uint32_t>(rows * columns);
      const std::uint32_t* at =
          sums.data() + static_cast<std::size_t>(x) * static_cast<std::size_t>(factor * channels);
      for (int c = 0; c < channels; ++c) {
        std::uint32_t sum = count / 2;
        for (int k = 0; k < columns; ++k) sum += at[k * channels + c];
        *to++ = static_cast<std::uint8_t>(sum / count);
      }
    };
    if (factor == 2 && rows == 2) {  // the usual case, without divisions
      const std::uint32_t* at = sums.data();
      for (int x = 0; x < whole; ++x, at += 2 * channels)
        for (int c = 0; c < channels; ++c)
          *to++ = static_cast<std::uint8_t>((at[c] + at[channels + c] + 2) >> 2);
    } else {
      for (int x = 0; x < whole; ++x) mean(x, factor);
    }
    if (whole < out.width) mean(whole, in.layout.width - whole * factor);
  }
}

struct Mean {
  std::uint32_t sum = 0, count = 0;
  void add(std::uint8_t v) {
    sum += v;
    ++count;
  }
  int value(int otherwise) const { return count ? static_cast<int>((sum + count / 2) / count) : otherwise; }
};

void shrink_bayer(const Source& in, int factor, Image& out) {
  for (int y = 0; y < out.height; ++y) {
    const int y1 = std::min((y + 1) * factor, in.layout.height);
    for (int x = 0; x < out.width; ++x) {
      const int x1 = std::min((x + 1) * factor, in.layout.width);
      Mean color[3];
      for (int v = y * factor; v < y1; ++v)
        for (int u = x * factor; u < x1; ++u)
          color[(u & 1) + (v & 1)].add(in.row(v)[u]);  // RGGB: 0 red, 1 green, 2 blue
      const int green = color[1].value(color[0].value(color[2].value(0)));
      const int rgb[3] = {color[0].value(green), green, color[2].value(green)};
      for (int c = 0; c < 3; ++c) out.at(x, y)[c] = static_cast<std::uint8_t>(rgb[c]);
    }
  }
}

void shrink_yuv(const Source& in, int factor, Image& out) {
  const bool planar = in.layout.format == PixelFormat::Nv12;
  for (int y = 0; y < out.height; ++y) {
    const int y0 = y * factor, y1 = std::min(y0 + factor, in.layout.height);
    for (int x = 0; x < out.width; ++x) {
      const int x0 = x * factor, x1 = std::min(x0 + factor, in.layout.width);
      Mean luma, cb, cr;
      for (int v = y0; v < y1; ++v)
        for (int u = x0; u < x1; ++u) luma.add(in.row(v)[planar ? u : 2 * u]);
      for (int v = planar ? y0 / 2 : y0; v < (planar ? (y1 + 1) / 2 : y1); ++v) {
        for (int u = x0 / 2; u < (x1 + 1) / 2; ++u) {
          cb.add(planar ? in.chroma_row(v)[2 * u] : in.row(v)[4 * u + 1]);
          cr.add(planar ? in.chroma_row(v)[2 * u + 1] : in.row(v)[4 * u + 3]);
        }
      }
      yuv_to_rgb(luma.value(0), cb.value(128), cr.value(128), out.at(x, y));
    }
  }
}

}  // namespace

Result<Image> shrink(const Frame& frame, int factor) {
  std::vector<std::uint32_t> sums;
  Image small;
  if (Result<void> ok = shrink(frame, factor, sums, small); !ok) return forward(ok);
  return small;
}

Result<void> shrink(const Frame& frame, int factor, std::vector<std::uint32_t>& sums, Image& small) {
  if (Result<void> ok = check_readable(frame); !ok) return ok;
  if (factor < 1)
    return fail(ErrorCode::InvalidArgument, text("a frame cannot be shrunk by ", factor, "; give 1 or more"));
  const ImageLayout& l = frame.layout;
  const bool gray = l.format == PixelFormat::Gray8;
  if (factor == 1 && !gray) return to_rgb(frame, small);
  const Source in{reinterpret_cast<const std::uint8_t*>(frame.pixels.get()), l};
  small.resize((l.width + factor - 1) / factor, (l.height + factor - 1) / factor, gray ? 1 : 3);
  switch (l.format) {
    case PixelFormat::Gray8:
    case PixelFormat::Rgb8:
      shrink_packed(in, factor, sums, small);
      break;
    case PixelFormat::BayerRggb8:
      shrink_bayer(in, factor, small);
      break;
    case PixelFormat::Yuyv:
    case PixelFormat::Nv12:
      shrink_yuv(in, factor, small);
      break;
    case PixelFormat::Mjpeg:
      break;
  }
  return {};
}

PixelBox whole_pixels(const ImageLayout& layout, const PixelBox& box) {
  const bool pairs = layout.format != PixelFormat::Gray8 && layout.format != PixelFormat::Rgb8;
  const bool cells = pairs && layout.format != PixelFormat::Yuyv;
  const auto even = [](int v, bool down) { return down ? v - (v & 1) : v + (v & 1); };
  int x0 = std::max(box.x, 0), y0 = std::max(box.y, 0);
  int x1 = std::min(box.x + box.width, layout.width), y1 = std::min(box.y + box.height, layout.height);
  if (x0 >= x1 || y0 >= y1) return {};
  if (pairs) x0 = even(x0, true), x1 = std::min(even(x1, false), layout.width);
  if (cells) y0 = even(y0, true), y1 = std::min(even(y1, false), layout.height);
  return {x0, y0, x1 - x0, y1 - y0};
}

PixelBox around(std::span<const PixelBox> boxes) {
  PixelBox all;
  for (const PixelBox& box : boxes) {
    if (box.empty()) continue;
    if (all.empty()) all = box;
    const int right = std::max(all.x + all.width, box.x + box.width),
              bottom = std::max(all.y + all.height, box.y + box.height);
    all.x = std::min(all.x, box.x);
    all.y = std::min(all.y, box.y);
    all.width = right - all.x;
    all.height = bottom - all.y;
  }
  return all;
}

Result<Frame> crop(const Frame& frame, PixelBox& box) {
  if (Result<void> ok = check_readable(frame); !ok) return forward(ok);
  const ImageLayout& l = frame.layout;
  const PixelBox taken = whole_pixels(l, box);
  if (taken.empty())
    return fail(ErrorCode::InvalidArgument,
                text("camera ", frame.info.camera, ": the part at ", box.x, ",", box.y, " of ", box.width,
                     "x", box.height, " lies outside its ", l.width, "x", l.height, " picture"));
  box = taken;
  const int x0 = box.x, y0 = box.y, y1 = box.y + box.height;

  Frame part{frame.info, l, nullptr};
  part.layout.width = box.width;
  part.layout.height = box.height;
  if (l.format == PixelFormat::Nv12) {  // two planes: no one stride fits a part of both
    part.layout = packed_layout(l.format, box.width, box.height);
    auto bytes = std::make_shared<std::byte[]>(part.layout.size_bytes);
    const auto first = static_cast<std::size_t>(x0);
    std::byte* to = bytes.get();
    for (int y = y0; y < y1; ++y, to += part.layout.stride)
      std::memcpy(to, frame.pixels.get() + l.stride * static_cast<std::size_t>(y) + first,
                  static_cast<std::size_t>(box.width));
    for (int y = y0 / 2; y < (y1 + 1) / 2; ++y, to += part.layout.stride)
      std::memcpy(to, frame.pixels.get() + l.stride * static_cast<std::size_t>(l.height + y) + first,
                  part.layout.stride);
    part.pixels = std::move(bytes);
    return part;
  }
  const std::size_t pixel = l.format == PixelFormat::Rgb8 ? 3 : l.format == PixelFormat::Yuyv ? 2 : 1;
  const std::size_t offset = l.stride * static_cast<std::size_t>(y0) + pixel * static_cast<std::size_t>(x0);
  part.layout.size_bytes = std::min(l.size_bytes - offset, l.stride * static_cast<std::size_t>(box.height));
  part.pixels = std::shared_ptr<const std::byte[]>(frame.pixels, frame.pixels.get() + offset);
  return part;
}

}  // namespace floatstage
