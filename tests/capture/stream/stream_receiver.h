#pragma once

#include <functional>
#include <string>

#include "core/image.h"
#include "core/time.h"

namespace floatstage::capture {

/// A picture as a player gets it.
struct ReceivedPicture {
  Image rgb;
  double seconds = 0;  ///< its time in the stream
  bool key = false;
  Timestamp decoded;  ///< when
};

/// Plays a stream as libav's programs do, on the calling thread, until `visit` says no, `stop` yes or the
/// stream ends. False: it could not be opened. `keep_probed`: what came while it looked what comes is visited
/// too, late; else it is dropped, as by players that want little latency.
bool play_stream(const std::string& url, const std::function<bool(const ReceivedPicture&)>& visit,
                 const std::function<bool()>& stop, bool keep_probed = false);

/// A UDP port of the loopback that nobody has.
int free_udp_port();

}  // namespace floatstage::capture
