#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "core/result.h"
#include "core/time.h"

namespace floatstage::capture {

struct StreamOptions {
  int width = 640, height = 480;  ///< px; pictures of other sizes are fitted in, with bars
  double rate = 25;               ///< pictures a second
  int most_kbit = 8000;           ///< kbit a second at most, averaged over a quarter of a second (H.264 only)
  std::function<bool()> stop;     ///< asked from two threads while a receiver is called or waited for
};

/// What became of the pictures.
struct StreamReport {
  std::uint64_t offered = 0;
  std::uint64_t sent = 0;          ///< of the offered
  std::uint64_t overtaken = 0;     ///< of the offered: a newer one came before they could be sent
  std::uint64_t unwatched = 0;     ///< of the offered: nobody received then
  std::uint64_t again = 0;         ///< instants of the stream that got the picture before once more
  std::uint64_t missed = 0;        ///< instants of the stream that got none: the receiver was too slow
  std::uint64_t receivers = 0;     ///< times that one came
  std::uint64_t bytes = 0;         ///< of pictures
  std::vector<double> latency_ms;  ///< of pictures sent with a time, the last 100,000 at most: see offer()
  bool connected = false;
  std::string trouble;  ///< why nobody receives; empty where somebody does or nobody has come yet
};

/// Pictures for players, mixers and browsers of others while they are made: H.264 as MPEG-TS over SRT, UDP or
/// RTP, over RTSP or into a file, or plain pictures for a V4L2 output device. They go out on a grid of
/// constant rate (stream_grid.h). A thread of its own codes and sends, and waits for receivers: whoever
/// offers never waits, and the newest picture wins.
class StreamOutput {
 public:
  /// InvalidArgument for what is no address of a stream or no size or rate of one; looks nothing up.
  static Result<void> check(const std::string& url, const StreamOptions& options);
  /// Listens, or calls the receiver and waits for its answer (5 s at most). Warns where pictures travel
  /// beyond this machine unencrypted. NotFound (host, device), Io (port in use, no permission), Disconnected
  /// (nobody answers), AlreadyExists (a file), Unsupported, Cancelled; and those of check(). A receiver that
  /// goes later is called again every second.
  static Result<std::unique_ptr<StreamOutput>> open(const std::string& url, const StreamOptions& options);
  ~StreamOutput();

  /// One picture, RGB of any size. `exposed`: when what it shows was, on the studio's clock; absent for one
  /// that shows what another did. Latency is from there until its last byte was given to the system. From any
  /// thread; does not wait.
  void offer(Image rgb, std::optional<Timestamp> exposed);
  StreamReport report() const;
  struct Health {
    bool connected = false;
    std::string trouble;
  };
  /// Of the report, at no cost.
  Health health() const;
  /// Where to, without secrets.
  const std::string& address() const;

 private:
  struct Impl;
  explicit StreamOutput(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace floatstage::capture
