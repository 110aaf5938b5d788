#include "tests/support/fake_source.h"

namespace floatstage {

FakeSource::FakeSource(std::vector<FakeStep> script, ImageLayout layout)
    : script_(std::move(script)), layout_(layout) {}

Result<capture::StreamInfo> FakeSource::start() {
  if (started_) return fail(ErrorCode::InvalidArgument, "camera 'fake' is started already");
  started_ = true;
  disconnected_ = false;
  step_ = 0;
  sequence_ = 0;
  instant_ = 0;
  last_ = {};
  for (auto* counter : {&delivered_, &lost_, &corrupt_, &starved_}) counter->store(0);
  capture::StreamInfo info;
  info.name = "fake";
  info.layout = layout_;
  info.frame_rate = 25;
  return info;
}

void FakeSource::stop() { started_ = false; }

capture::SourceStats FakeSource::stats() const { return {delivered_, lost_, corrupt_, starved_}; }

Frame FakeSource::make_frame(FrameStatus status, const ImageLayout& layout) const {
  Frame frame;
  frame.info.camera = 0;
  frame.info.sequence = sequence_;
  frame.info.exposure_start = Timestamp{} + milliseconds(40) * instant_;
  frame.info.status = status;
  frame.layout = layout;
  auto bytes = std::make_shared<std::byte[]>(layout.size_bytes);
  for (std::size_t i = 0; i < layout.size_bytes; ++i)
    bytes[i] = static_cast<std::byte>((sequence_ * 7 + i) & 0xFF);
  frame.pixels = std::move(bytes);
  return frame;
}

Frame FakeSource::deliver(FrameStatus status) {
  last_ = make_frame(status, layout_);
  ++sequence_;
  ++instant_;
  ++delivered_;
  if (status == FrameStatus::Corrupt) ++corrupt_;
  return last_;
}

Result<Frame> FakeSource::next(Nanoseconds) {
  if (!started_) return fail(ErrorCode::InvalidArgument, "camera 'fake' is not started");
  if (disconnected_)
    return fail(ErrorCode::Disconnected, "camera 'fake' is gone; plug it in and start again");
  if (step_ == script_.size()) return fail(ErrorCode::EndOfStream, "camera 'fake': the script is over");
  auto lose_one = [this] {
    ++sequence_;
    ++instant_;
    ++lost_;
  };
  switch (script_[step_++]) {
    case FakeStep::Deliver:
      break;
    case FakeStep::Timeout:
      return fail(ErrorCode::Timeout, "camera 'fake': no frame in time");
    case FakeStep::Gap:
      lose_one();
      break;
    case FakeStep::Corrupt:
      return deliver(FrameStatus::Corrupt);
    case FakeStep::Starve:
      lose_one();
      ++starved_;
      return fail(ErrorCode::Timeout, "camera 'fake': no free buffer");
    case FakeStep::Disconnect:
      disconnected_ = true;
      return fail(ErrorCode::Disconnected, "camera 'fake' is gone; plug it in and start again");
    case FakeStep::Duplicate:
      ++delivered_;
      return last_;
    case FakeStep::WrongLayout: {
      ImageLayout half = layout_;
      half.height /= 2;
      half.size_bytes /= 2;
      Frame frame = make_frame(FrameStatus::Ok, half);
      ++sequence_;
      ++instant_;
      ++delivered_;
      return frame;
    }
    case FakeStep::Wrap:
      sequence_ = 0;
      break;
  }
  return deliver(FrameStatus::Ok);
}

}  // namespace floatstage
