#pragma once

#include <atomic>
#include <vector>

#include "capture/frame_source.h"

namespace floatstage {

/// What a FakeSource does at one call of next().
enum class FakeStep {
  Deliver,      ///< the next frame, as it should be
  Timeout,      ///< nothing arrived in time
  Gap,          ///< the frame after the next one: one is lost
  Corrupt,      ///< the next frame, with status Corrupt
  Starve,       ///< a frame is lost because there was no free buffer; then a Timeout
  Disconnect,   ///< the cable is pulled: Disconnected until it is started again
  Duplicate,    ///< the last frame again: against the contract
  WrongLayout,  ///< a frame of half the height: against the contract
  Wrap,         ///< the device's counter begins again at 0: against the contract
};

/// A camera that behaves, or misbehaves, by script; then its recording is over. Its pictures depend on
/// nothing but the sequence number, its time is a multiple of 40 ms, and it never waits.
class FakeSource final : public capture::FrameSource {
 public:
  explicit FakeSource(std::vector<FakeStep> script,
                      ImageLayout layout = packed_layout(PixelFormat::Gray8, 16, 12));

  Result<capture::StreamInfo> start() override;
  Result<Frame> next(Nanoseconds timeout) override;
  void stop() override;
  capture::SourceStats stats() const override;

 private:
  Frame make_frame(FrameStatus status, const ImageLayout& layout) const;
  Frame deliver(FrameStatus status);

  const std::vector<FakeStep> script_;
  const ImageLayout layout_;
  bool started_ = false, disconnected_ = false;
  std::size_t step_ = 0;
  std::uint64_t sequence_ = 0;  // of the next frame
  std::int64_t instant_ = 0;
  Frame last_;
  std::atomic<std::uint64_t> delivered_{0}, lost_{0}, corrupt_{0}, starved_{0};
};

}  // namespace floatstage
