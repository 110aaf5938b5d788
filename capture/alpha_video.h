#pragma once

#include "capture/media_file.h"

namespace floatstage::capture {

/// Writes RGBA pictures (straight alpha) of one size as ProRes 4444 in a MOV (yuva444p10, BT.709, opacity in
/// 16 bits), which editing programs lay over other pictures. VideoWriter's contract, with 4 channels in the
/// place of 3; sizes may be odd.
Result<std::unique_ptr<VideoWriter>> create_alpha_video(const std::filesystem::path& file, int width,
                                                        int height, double frame_rate);

}  // namespace floatstage::capture
