#pragma once

#include <memory>
#include <string>

#include "capture/frame_source.h"
#include "capture/take.h"

namespace floatstage::capture {

inline constexpr const char* kReplayUsage = "take:<folder>#<serial>";

/// One camera of a take as a source. Plays as fast as it is asked, and never waits: time comes from the side
/// file, so a replay is the same on every machine. A picture whose bytes are damaged counts as lost; a file
/// that cannot be read any more is Disconnected. Several sources may share a reader. `camera` must be one of
/// the reader's.
std::unique_ptr<FrameSource> replay(std::shared_ptr<TakeReader> take, int camera);

/// `address` is "<folder>#<serial>"; without "#<serial>" the take must have one camera. Errors name `uri`.
Result<std::unique_ptr<FrameSource>> open_replay(const std::string& address, const std::string& uri);

}  // namespace floatstage::capture
