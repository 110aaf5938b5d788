#include "capture/v4l2/v4l2_source.h"

#include <atomic>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>

#include <poll.h>
#include <sys/mman.h>

#include "capture/clock_map.h"
#include "capture/source_meter.h"
#include "capture/source_uri.h"
#include "capture/studio_clock.h"
#include "capture/v4l2/v4l2_device.h"
#include "core/jpeg.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

// A driver's buffer in our memory; stays mapped while a frame shows it, also when the device is closed.
class Mapping {
 public:
  Mapping(int fd, const v4l2_buffer& buffer)
      : bytes_(::mmap(nullptr, buffer.length, PROT_READ, MAP_SHARED, fd, buffer.m.offset)),
        size_(buffer.length) {}
  ~Mapping() {
    if (valid()) ::munmap(bytes_, size_);
  }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  bool valid() const { return bytes_ != MAP_FAILED; }
  const std::byte* data() const { return static_cast<const std::byte*>(bytes_); }
  std::size_t size() const { return size_; }

 private:
  void* bytes_;
  std::size_t size_;
};

v4l2_buffer buffer_number(std::uint32_t index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

// An open device with its buffers.
struct Stream {
  explicit Stream(V4l2Device opened) : device(std::move(opened)) {}

  V4l2Device device;
  std::vector<std::shared_ptr<Mapping>> buffers;
  std::atomic<std::size_t> lent{0};

  int queue(std::uint32_t index) {
    v4l2_buffer buffer = buffer_number(index);
    return device.ioctl(VIDIOC_QBUF, &buffer);
  }
};

// The last frame that shows the buffer queues it again, if its stream still runs.
std::shared_ptr<const std::byte[]> lend(const std::shared_ptr<Stream>& stream, std::uint32_t index) {
  const std::shared_ptr<Mapping> mapping = stream->buffers[index];
  ++stream->lent;
  const auto give_back = [mapping, index, from = std::weak_ptr<Stream>(stream)](const std::byte*) {
    if (const std::shared_ptr<Stream> alive = from.lock()) {
      --alive->lent;
      alive->queue(index);  // a device that is gone says so at the next picture
    }
  };
  return {mapping->data(), give_back};
}

class V4l2Source final : public FrameSource {
 public:
  V4l2Source(V4l2Settings settings, std::uint64_t frames) : settings_(std::move(settings)), frames_(frames) {}
  ~V4l2Source() override { stop(); }

  Result<StreamInfo> start() override;
  Result<Frame> next(Nanoseconds timeout) override;
  void stop() override;
  SourceStats stats() const override { return meter_.read(); }
  std::vector<CameraControl> controls() override {
    return stream_ ? light_controls(stream_->device) : std::vector<CameraControl>();
  }
  Result<void> set_control(const std::string& name, double value) override;

 private:
  auto failed(ErrorCode code, const std::string& what) const {
    return fail(code, text("camera '", settings_.path, "': ", what));
  }
  Result<void> map_buffers(Stream& stream) const;
  Result<std::optional<Frame>> take();
  Result<Frame> frame_of(const v4l2_buffer& buffer, FrameInfo info);
  Timestamp exposure_of(const v4l2_buffer& buffer, FrameInfo& info);
  std::uint64_t number(std::uint32_t sequence);

  const V4l2Settings settings_;
  const std::uint64_t frames_;
  std::shared_ptr<Stream> stream_;  // while started
  V4l2Format format_;
  ImageLayout layout_;  // of the frames
  bool jpeg_ = false;   // decoded here
  ClockMap clock_;
  std::optional<std::uint32_t> last_sequence_;
  std::uint64_t newest_ = 0, expected_ = 0;
  bool starving_ = false;
  std::string gone_;  // why the stream is over, once it is
  SourceMeter meter_;
};

Result<void> V4l2Source::set_control(const std::string& name, double value) {
  if (!stream_) return failed(ErrorCode::InvalidArgument, "it is not started; start it first");
  Result<void> set = set_light_control(stream_->device, settings_.path, name, value);
  format_.exposure = exposure_time(stream_->device);
  return set;
}

Result<void> V4l2Source::map_buffers(Stream& stream) const {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(settings_.buffers);
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (const int error = stream.device.ioctl(VIDIOC_REQBUFS, &request); error != 0 || request.count < 2)
    return failed(ErrorCode::Io,
                  text("it lends no buffers (", error ? why_not_streaming(error) : "too few", ")"));
  for (std::uint32_t i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = buffer_number(i);
    if (const int error = stream.device.ioctl(VIDIOC_QUERYBUF, &buffer); error != 0)
      return failed(ErrorCode::Io, text("it does not describe its buffers (", std::strerror(error), ")"));
    stream.buffers.push_back(std::make_shared<Mapping>(stream.device.fd(), buffer));
    if (!stream.buffers.back()->valid())
      return failed(ErrorCode::Io, text("its buffers cannot be mapped (", std::strerror(errno), ")"));
    if (const int error = stream.queue(i); error != 0)
      return failed(ErrorCode::Io, text("it does not take a buffer (", why_not_streaming(error), ")"));
  }
  return {};
}

Result<StreamInfo> V4l2Source::start() {
  if (stream_) return failed(ErrorCode::InvalidArgument, "it is started already; stop it first");
  Result<V4l2Device> device = V4l2Device::open(settings_.path);
  if (!device) return forward(device);
  Result<V4l2Format> format = apply_settings(*device, settings_);
  if (!format) return forward(format);
  auto stream = std::make_shared<Stream>(std::move(*device));
  if (Result<void> mapped = map_buffers(*stream); !mapped) return forward(mapped);
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (const int error = stream->device.ioctl(VIDIOC_STREAMON, &type); error != 0)
    return failed(error == ENODEV ? ErrorCode::Disconnected : ErrorCode::Io,
                  text("it does not start (", why_not_streaming(error), ")"));
  format_ = *format;
  layout_ = format_.device;
  jpeg_ = layout_.format == PixelFormat::Mjpeg;
  if (jpeg_) layout_ = packed_layout(PixelFormat::Rgb8, layout_.width, layout_.height);
  clock_ = ClockMap();
  last_sequence_.reset();
  newest_ = expected_ = 0;
  starving_ = false;
  gone_.clear();
  meter_.reset();
  stream_ = std::move(stream);
  StreamInfo info;
  info.name = settings_.path;
  info.layout = layout_;
  info.frame_rate = format_.frame_rate;
  if (frames_ != UINT64_MAX) info.frame_count = static_cast<std::int64_t>(frames_);
  return info;
}

void V4l2Source::stop() {
  if (!stream_) return;
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  stream_->device.ioctl(VIDIOC_STREAMOFF, &type);
  // What is still mapped keeps the device's file open; letting the buffers go leaves them to their frames and
  // the device free for the next stream.
  v4l2_requestbuffers none{};
  none.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  none.memory = V4L2_MEMORY_MMAP;
  stream_->device.ioctl(VIDIOC_REQBUFS, &none);
  stream_.reset();
}

// The driver's 32-bit counter, unwrapped and counted from its first value.
std::uint64_t V4l2Source::number(std::uint32_t sequence) {
  newest_ += last_sequence_ ? static_cast<std::uint32_t>(sequence - *last_sequence_) : 0u;
  last_sequence_ = sequence;
  return newest_;
}

Timestamp V4l2Source::exposure_of(const v4l2_buffer& buffer, FrameInfo& info) {
  constexpr Nanoseconds kBelievable{5'000'000'000};
  const Timestamp now = studio_now();
  const Nanoseconds stamp{buffer.timestamp.tv_sec * std::int64_t{1'000'000'000} +
                          buffer.timestamp.tv_usec * std::int64_t{1000}};
  if (stamp.count <= 0) return now;
  info.device_time = stamp;
  const bool monotonic = (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  const Timestamp as_it_is{stamp.count};
  // A driver may hand out a picture a moment before the end of the readout that it stamps.
  const bool believable = monotonic && as_it_is - now < kBelievable && now - as_it_is < kBelievable;
  const Timestamp stamped = believable ? as_it_is : clock_.observe(stamp, now);
  const bool at_end = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_EOF;
  if (!at_end || format_.frame_rate <= 0) return stamped;
  return stamped - Nanoseconds{std::llround(1e9 / format_.frame_rate)};
}

Result<Frame> V4l2Source::frame_of(const v4l2_buffer& buffer, FrameInfo info) {
  Frame frame;
  frame.layout = layout_;
  info.exposure = format_.exposure;
  info.exposure_start = exposure_of(buffer, info);
  const bool flagged = buffer.flags & V4L2_BUF_FLAG_ERROR;
  const std::size_t least = jpeg_ ? 1 : format_.device.stride * static_cast<std::size_t>(layout_.height);
  if (flagged || buffer.bytesused < least) info.status = FrameStatus::Corrupt;
  if (!jpeg_) {
    frame.info = info;
    frame.pixels = lend(stream_, buffer.index);
    return frame;
  }
  const Mapping& mapping = *stream_->buffers[buffer.index];
  const std::size_t bytes = std::min<std::size_t>(buffer.bytesused, mapping.size());
  Result<Image> image = decode_jpeg({mapping.data(), bytes}, layout_.width, layout_.height);
  if (!image) {
    info.status = FrameStatus::Corrupt;
    image = Image(layout_.width, layout_.height, 3);
  }
  if (const int error = stream_->queue(buffer.index); error != 0)
    return failed(ErrorCode::Disconnected,
                  text("it takes its buffer no more (", why_not_streaming(error), ")"));
  return make_frame(info, *image);
}

// The next filled buffer as a frame; nothing when none is ready.
Result<std::optional<Frame>> V4l2Source::take() {
  v4l2_buffer buffer = buffer_number(0);
  if (const int error = stream_->device.ioctl(VIDIOC_DQBUF, &buffer); error != 0) {
    if (error == EAGAIN) return std::optional<Frame>();
    gone_ = text("its stream is over (", why_not_streaming(error), "); stop and start it");
    return failed(ErrorCode::Disconnected, gone_);
  }
  const std::uint64_t sequence = number(buffer.sequence);
  const std::uint64_t skipped = std::min(sequence, frames_) - std::min(expected_, frames_);
  expected_ = sequence + 1;
  meter_.count_lost(skipped);
  if (starving_)
    for (std::uint64_t i = 0; i < skipped; ++i) meter_.count_starved();
  starving_ = false;
  if (sequence >= frames_) {
    stream_->queue(buffer.index);
    return std::optional<Frame>();
  }
  FrameInfo info;
  info.sequence = sequence;
  Result<Frame> frame = frame_of(buffer, info);
  if (!frame) {
    gone_ = frame.error().message;
    return forward(frame);
  }
  meter_.count_delivered(*frame);
  return std::optional<Frame>(std::move(*frame));
}

Result<Frame> V4l2Source::next(Nanoseconds timeout) {
  if (!stream_) return failed(ErrorCode::InvalidArgument, "it is not started; start it first");
  if (!gone_.empty()) return failed(ErrorCode::Disconnected, gone_);
  const Timestamp end = studio_now() + timeout;
  for (;;) {
    if (expected_ >= frames_)
      return failed(ErrorCode::EndOfStream, text("its ", frames_, " pictures are over"));
    if (stream_->lent >= stream_->buffers.size()) starving_ = true;
    pollfd ready{stream_->device.fd(), POLLIN, 0};
    const std::int64_t left = std::max<std::int64_t>(0, (end - studio_now()).count);
    const timespec wait{left / 1'000'000'000, left % 1'000'000'000};
    const int events = ::ppoll(&ready, 1, &wait, nullptr);
    if (events > 0) {
      Result<std::optional<Frame>> frame = take();
      if (!frame) return forward(frame);
      if (*frame) return std::move(**frame);
    }
    if (studio_now() >= end && events <= 0)
      return failed(ErrorCode::Timeout, text("no picture within ", seconds(timeout), " s"));
  }
}

// "brightness:10,gain:3"; nothing when it is not that.
std::optional<std::vector<std::pair<std::string, int>>> controls_of(std::string_view list) {
  std::vector<std::pair<std::string, int>> controls;
  while (!list.empty()) {
    const std::string_view item = list.substr(0, list.find(','));
    list.remove_prefix(std::min(list.size(), item.size() + 1));
    const std::size_t colon = item.find(':');
    if (colon == std::string_view::npos || colon == 0) return std::nullopt;
    const std::string_view value = item.substr(colon + 1);
    int number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    if (error != std::errc() || end != value.data() + value.size()) return std::nullopt;
    controls.emplace_back(item.substr(0, colon), number);
  }
  return controls;
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_v4l2(const std::string& address, const std::string& uri) {
  DeviceUri given(address, uri);
  V4l2Settings s;
  s.path = given.device;
  given.read_pictures(s, 32);
  const std::uint64_t frames = given.frames();
  const auto controls = controls_of(given.options.word("controls", ""));
  if (!controls) given.options.note("controls are <name>:<whole number>, with commas between");
  if (Result<void> ok = given.options.finish(kV4l2Usage); !ok) return forward(ok);
  s.controls = *controls;
  return {std::make_unique<V4l2Source>(std::move(s), frames)};
}

}  // namespace floatstage::capture
