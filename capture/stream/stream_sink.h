#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "capture/stream/stream_address.h"
#include "core/image.h"
#include "core/result.h"

namespace floatstage::capture {

/// How a stream's pictures are coded.
struct StreamFormat {
  int width = 0, height = 0;  ///< px, even; pictures of other sizes are fitted in, with bars
  double rate = 0;            ///< pictures a second
  int most_kbit = 0;          ///< bits a second, on average over a quarter of a second; / 1000
};

/// One place that pictures go to. Called by one thread at a time; connect() and write() may wait, and ask
/// `stop` while they do.
class StreamSink {
 public:
  virtual ~StreamSink() = default;
  /// Until somebody receives: for one that listens as long as nobody calls. Cancelled when stopped.
  virtual Result<void> connect() = 0;
  /// The bytes that went out; 0: the receiver did not take this picture. `fresh`: a receiver can begin with
  /// it. An error: the receiver is gone, or is so slow that it was given up; close() and connect() then.
  virtual Result<std::size_t> write(const Image& rgb, std::int64_t instant, bool fresh) = 0;
  virtual void close() = 0;
  /// May be connected again once it was closed.
  virtual bool returns() const { return true; }
};

/// H.264 as MPEG-TS over SRT, UDP or RTP or into a file, or over RTSP. `stop` is asked from several threads.
Result<std::unique_ptr<StreamSink>> open_coded_sink(const StreamAddress& address, const StreamFormat& format,
                                                    std::function<bool()> stop);
/// Pictures for a video output device: v4l2loopback, or the kernel's vivid. Its own size, where it has one.
Result<std::unique_ptr<StreamSink>> open_v4l2_sink(const StreamAddress& address, const StreamFormat& format,
                                                   std::function<bool()> stop);

}  // namespace floatstage::capture
