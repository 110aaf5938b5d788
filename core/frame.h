#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "core/time.h"

namespace floatstage {

/// How a sensor's bytes are to be read. Conversion happens at the last consumer: to_image().
enum class PixelFormat { Gray8, Rgb8, Yuyv, Nv12, BayerRggb8, Mjpeg };

const char* name_of(PixelFormat format);
std::optional<PixelFormat> pixel_format_named(std::string_view name);

/// Where the pixels lie inside a frame's buffer. For planar Nv12 the chroma plane follows the luma plane at
/// stride * height with the same stride; for Mjpeg the stride is 0.
struct ImageLayout {
  PixelFormat format = PixelFormat::Gray8;
  int width = 0, height = 0;   ///< px
  std::size_t stride = 0;      ///< bytes from one row to the next
  std::size_t size_bytes = 0;  ///< of the whole buffer
  bool operator==(const ImageLayout&) const = default;
};

/// The layout of a tightly packed image of an uncompressed format.
ImageLayout packed_layout(PixelFormat format, int width, int height);

enum class FrameStatus {
  Ok,
  Corrupt,  ///< incomplete or damaged; the pixels may be partly old
  Lost,     ///< expected and never arrived: a gap. Such a frame has no pixels.
};

const char* name_of(FrameStatus status);
std::optional<FrameStatus> frame_status_named(std::string_view name);

/// Measured facts about one exposure. What the device does not report is absent, never 0.
struct FrameInfo {
  int camera = -1;                         ///< index into Rig::cameras
  std::uint64_t sequence = 0;              ///< device counter rebased to 0 at start; a jump is a lost frame
  Timestamp exposure_start;                ///< studio clock
  std::optional<Nanoseconds> exposure;     ///< duration, when the device reports it
  std::optional<Nanoseconds> device_time;  ///< raw camera counter
  FrameStatus status = FrameStatus::Ok;
  bool operator==(const FrameInfo&) const = default;
};

/// A handle: facts and shared read-only pixels in the sensor's own format. Copying is a reference count; the
/// last copy, dropped on any thread, returns the buffer to where it came from.
struct Frame {
  FrameInfo info;
  ImageLayout layout;
  std::shared_ptr<const std::byte[]> pixels;  ///< layout.size_bytes bytes; null when there is no picture

  bool empty() const { return pixels == nullptr; }
};

/// What a rig saw at one instant: frames[i] comes from rig.cameras[i] and is empty if that camera missed it.
struct FrameSet {
  Timestamp time;
  std::vector<Frame> frames;
};

/// A Frame that owns a copy of `image` (1 channel: Gray8, 3: Rgb8).
Frame make_frame(FrameInfo info, const Image& image);
/// The same without a copy: `image` outlives the frame and all that is cropped from it.
Frame borrowed_frame(FrameInfo info, const Image& image);

/// The frame's pixels as RGB (3 channels, tightly packed). Yuyv and Nv12 are read as BT.601 limited range;
/// Bayer is demosaiced bilinearly. Errors: NotFound for an empty frame, Unsupported for Mjpeg (the capture
/// source decodes it), BadData when the buffer is shorter than its layout says.
Result<Image> to_rgb(const Frame& frame);
/// The same into a picture whose memory is used again. Errors leave it as it was.
Result<void> to_rgb(const Frame& frame, Image& rgb);

/// The frame at a fraction of its size, without making the whole picture first: each pixel is the mean of the
/// factor x factor sensor pixels below it (fewer at the right and bottom border), so ceil(size / factor)
/// pixels. Gray8 stays one channel, everything else becomes RGB; of Bayer cells each colour is averaged where
/// it was measured, chroma where it was sampled. Errors as to_rgb(), and InvalidArgument for a factor
/// below 1.
Result<Image> shrink(const Frame& frame, int factor);
/// The same into a picture whose memory is used again, as is that of `sums`, which it works in. Errors leave
/// the picture as it was.
Result<void> shrink(const Frame& frame, int factor, std::vector<std::uint32_t>& sums, Image& small);

/// A rectangle of a frame's pixels, px.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
  bool empty() const { return width <= 0 || height <= 0; }
  bool operator==(const PixelBox&) const = default;
};

/// `box` cut to a picture of this layout, and grown to whole ones where pixels come in pairs (Yuyv) or cells
/// (Nv12, Bayer). Empty when it misses the picture.
PixelBox whole_pixels(const ImageLayout& layout, const PixelBox& box);

/// The smallest box that holds these; empty ones do not count.
PixelBox around(std::span<const PixelBox> boxes);

/// The frame's pixels within `box`, still in the sensor's format, without copying where the format allows it
/// (all but Nv12): the result keeps the whole buffer alive. `box` becomes what was taken, whole_pixels() of
/// it. Errors as to_rgb(); InvalidArgument for a box that misses the picture.
Result<Frame> crop(const Frame& frame, PixelBox& box);

}  // namespace floatstage
