#pragma once

#include <memory>
#include <string>

#include "capture/frame_source.h"

namespace floatstage::capture {

inline constexpr const char* kSyntheticUsage =
    "synthetic:camera=0&cameras=8&shape=ring|dome&seed=1&width=640&height=480&frames=0&rate=25&samples=16&"
    "noise=0&dropped=0&jitter=0&live=off&loop=25&late-ms=0&gone-after=0";

/// A camera of the embedded studio as a source, rendered when asked and never waiting; with live=on at its
/// rate, on the studio's clock, triggered together with all others but `late-ms` later, with `loop` pictures
/// that it shows again and again: at one time all cameras show the performer in the same pose, whenever they
/// were started. frames=0 never ends; after `gone-after` frames it is unplugged until it is started again
/// (0: never); `dropped` is the fraction of frames lost, `noise` in 8-bit steps, `jitter` in seconds.
/// `options` is what follows "synthetic:"; all have the defaults of kSyntheticUsage. InvalidArgument names
/// `uri`.
Result<std::unique_ptr<FrameSource>> open_synthetic(const std::string& options, const std::string& uri);

}  // namespace floatstage::capture
