#pragma once

#include <filesystem>
#include <string>

#include "core/result.h"

namespace floatstage::capture {

/// Where a live picture goes, as `live --stream` has it.
struct StreamAddress {
  enum class Kind { Srt, Udp, Rtp, Rtsp, File, V4l2 };
  Kind kind = Kind::Srt;
  std::string url;             ///< for libav
  std::string shown;           ///< the same for people: without passphrase and password
  std::string host;            ///< of the network kinds; empty: every address of this machine
  int port = 0;                ///< of the network kinds
  std::filesystem::path path;  ///< of a file or a device
  bool listens = false;        ///< receivers call, not we
  bool encrypted = false;      ///< by a passphrase of SRT
};

/// "srt://127.0.0.1:9000?mode=listener", "udp://HOST:PORT", "rtp://…", "rtsp://HOST:PORT/NAME", "file:OUT.ts"
/// or "v4l2:/dev/videoN". InvalidArgument says what is wrong: another protocol, no port, an option that the
/// protocol does not have (libav's names, for srt, udp and rtp). Looks nothing up.
Result<StreamAddress> parse_stream_address(const std::string& url);

/// Looks the host up. True when every address of it is this machine's loopback. NotFound names the host.
Result<bool> is_loopback(const StreamAddress& address);

/// Io when somebody has the port that `address` is to listen at.
Result<void> check_port_is_free(const StreamAddress& address);

}  // namespace floatstage::capture
