#include "tests/capture/pictures.h"

#include <cmath>
#include <cstring>

#include <gtest/gtest.h>

#include "core/random.h"
#include "core/text.h"

namespace floatstage::capture {

Rig small_rig(int cameras, int width, int height) {
  Rig rig;
  for (int i = 0; i < cameras; ++i) {
    const double angle = 2 * 3.141592653589793 * i / cameras;
    RigCamera c;
    c.serial = text("cam", i);
    c.model = {width, height, 1.2 * width, 1.2 * width, 0.5 * width, 0.5 * height, 0, {}};
    c.cam_from_world = look_at({3 * std::cos(angle), 3 * std::sin(angle), 1.3}, {0, 0, 1}, {0, 0, 1});
    rig.cameras.push_back(c);
  }
  return rig;
}

Frame patterned_frame(PixelFormat format, int width, int height, int camera, std::uint64_t sequence) {
  Frame frame;
  frame.info.camera = camera;
  frame.info.sequence = sequence;
  frame.info.exposure_start =
      Timestamp{1'700'000'000'000'000'000 + static_cast<std::int64_t>(sequence) * 40'000'000 + camera};
  frame.info.device_time = Nanoseconds{static_cast<std::int64_t>(sequence) * 39'999'871};
  frame.info.exposure = milliseconds(4);
  frame.layout = packed_layout(format, width, height);
  auto bytes = std::make_shared<std::byte[]>(frame.layout.size_bytes);
  const std::uint64_t seed = mix(sequence * 64 + static_cast<std::uint64_t>(camera));
  for (std::size_t i = 0; i < frame.layout.size_bytes; ++i) {
    const std::size_t x = i % frame.layout.stride, y = i / frame.layout.stride;
    bytes[i] = static_cast<std::byte>((40 + x + 2 * y + sequence + mix(seed + i) % 16) & 0xFF);
  }
  frame.pixels = std::move(bytes);
  return frame;
}

Frame with_longer_rows(const Frame& frame, std::size_t extra) {
  Frame longer = frame;
  const std::size_t rows = frame.layout.size_bytes / frame.layout.stride;
  longer.layout.stride += extra;
  longer.layout.size_bytes = longer.layout.stride * rows;
  auto bytes = std::make_shared<std::byte[]>(longer.layout.size_bytes);
  for (std::size_t y = 0; y < rows; ++y)
    std::memcpy(bytes.get() + y * longer.layout.stride, frame.pixels.get() + y * frame.layout.stride,
                frame.layout.stride);
  longer.pixels = std::move(bytes);
  return longer;
}

Frame lost_frame(int camera, std::uint64_t sequence) {
  Frame frame = patterned_frame(PixelFormat::Gray8, 1, 1, camera, sequence);
  frame.layout = {};
  frame.pixels = nullptr;
  frame.info.status = FrameStatus::Lost;
  frame.info.exposure.reset();
  frame.info.device_time.reset();
  return frame;
}

bool same_pixels(const Frame& a, const Frame& b) {
  if (a.empty() || b.empty()) return a.empty() == b.empty();
  if (a.layout != b.layout) return false;
  const ImageLayout& l = a.layout;
  const bool has_padding = l.width % 2 && (l.format == PixelFormat::Yuyv || l.format == PixelFormat::Nv12);
  for (std::size_t i = 0; i < l.size_bytes; ++i) {
    const std::size_t x = i % l.stride, y = i / l.stride;
    const bool padding = has_padding && (l.format == PixelFormat::Yuyv
                                             ? x == l.stride - 2
                                             : x == l.stride - 1 && y < static_cast<std::size_t>(l.height));
    if (!padding && a.pixels[i] != b.pixels[i]) return false;
  }
  return true;
}

void record_small_take(const std::filesystem::path& folder, int cameras, int frames, TakeCodec codec, int gap,
                       int width, int height) {
  TakeWriterOptions options;
  options.codec = codec;
  options.label = "small";
  options.created = "2026-01-02T03:04:05Z";
  auto writer = TakeWriter::create(folder, small_rig(cameras, width, height), options);
  ASSERT_TRUE(writer.has_value()) << writer.error().message;
  for (int k = 0; k < frames; ++k) {
    for (int c = 0; c < cameras; ++c) {
      const auto sequence = static_cast<std::uint64_t>(k);
      const Frame frame = c == 0 && k == gap ? lost_frame(c, sequence)
                                             : patterned_frame(PixelFormat::Rgb8, width, height, c, sequence);
      const Result<void> ok = (*writer)->write(frame);
      ASSERT_TRUE(ok.has_value()) << ok.error().message;
    }
  }
  const Result<void> ok = (*writer)->finish();
  ASSERT_TRUE(ok.has_value()) << ok.error().message;
}

}  // namespace floatstage::capture
