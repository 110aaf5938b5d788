#pragma once

#include <string>
#include <vector>

#include "capture/take.h"
#include "core/frame.h"
#include "core/rig.h"

namespace floatstage::capture {

/// Cameras "cam0", "cam1", … of one size, on a ring.
Rig small_rig(int cameras, int width, int height);

/// A frame of hashed noise over a gradient, packed, whose every byte depends on camera, sequence and place.
Frame patterned_frame(PixelFormat format, int width, int height, int camera, std::uint64_t sequence);

/// The same picture in a buffer whose rows are `extra` bytes longer.
Frame with_longer_rows(const Frame& frame, std::size_t extra);

/// A gap: no pixels, status Lost.
Frame lost_frame(int camera, std::uint64_t sequence);

/// Pixels only, byte by byte: the padding that odd sizes leave in Yuyv and Nv12 rows does not count.
bool same_pixels(const Frame& a, const Frame& b);

/// Records `frames` Rgb8 pictures of every camera of small_rig(); sequence `gap` is lost in camera 0.
void record_small_take(const std::filesystem::path& folder, int cameras, int frames,
                       TakeCodec codec = TakeCodec::Ffv1, int gap = -1, int width = 32, int height = 24);

}  // namespace floatstage::capture
