#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "capture/stream/fitted_picture.h"
#include "capture/stream/stream_sink.h"
#include "capture/stream/v4l2_output_buffers.h"
#include "core/file_descriptor.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

struct OutputFormat {
  std::uint32_t fourcc;
  AVPixelFormat format;
};
// In the order in which they are taken: what all programs read that take pictures of a camera, first.
constexpr std::array kFormats = {OutputFormat{V4L2_PIX_FMT_YUYV, AV_PIX_FMT_YUYV422},
                                 OutputFormat{V4L2_PIX_FMT_NV12, AV_PIX_FMT_NV12},
                                 OutputFormat{V4L2_PIX_FMT_YUV420, AV_PIX_FMT_YUV420P},
                                 OutputFormat{V4L2_PIX_FMT_RGB24, AV_PIX_FMT_RGB24}};

constexpr int kPatienceMs = 500;  // for a device that takes nothing: the picture is left out then

class V4l2Sink final : public StreamSink {
 public:
  V4l2Sink(const StreamAddress& address, const StreamFormat& format) : address_(address), wanted_(format) {}

  Result<void> connect() override;
  Result<std::size_t> write(const Image& rgb, std::int64_t instant, bool fresh) override;
  void close() override {
    buffers_.reset();
    device_ = {};
  }

 private:
  template <class... Parts>
  Unexpected failed(ErrorCode code, const Parts&... what) const {
    return fail(code, text("--stream ", address_.shown, ": ", what...));
  }
  int ask(unsigned long request, void* argument) const {
    for (;;) {
      if (::ioctl(device_.get(), request, argument) == 0) return 0;
      if (errno != EINTR) return errno;
    }
  }
  Result<void> open_device();
  Result<OutputFormat> choose_format() const;
  Result<void> agree(const OutputFormat& chosen);
  void copy(const AVFrame& frame);
  int hand_over();

  const StreamAddress address_;
  const StreamFormat wanted_;
  FileDescriptor device_;
  bool streams_ = false, writes_ = false;  // how it takes pictures
  bool write_failed_ = false;              // it says that it does, and does not
  std::unique_ptr<V4l2OutputBuffers> buffers_;
  v4l2_pix_format agreed_{};
  std::unique_ptr<FittedPicture> fitted_;
  std::vector<std::uint8_t> bytes_;  // one picture as the device wants it
};

Result<void> V4l2Sink::open_device() {
  device_ = FileDescriptor(::open(address_.path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  if (!device_) {
    const int error = errno;
    if (error == EACCES) return failed(ErrorCode::Io, "no permission; add yourself to the group 'video'");
    if (error == EBUSY) return failed(ErrorCode::Io, "another program writes to it");
    return failed(ErrorCode::NotFound, "it is not there (", std::strerror(error),
                  "); `modprobe v4l2loopback` makes one");
  }
  v4l2_capability capability{};
  if (ask(VIDIOC_QUERYCAP, &capability) != 0) return failed(ErrorCode::Unsupported, "it is no video device");
  const std::uint32_t has =
      capability.capabilities & V4L2_CAP_DEVICE_CAPS ? capability.device_caps : capability.capabilities;
  if (!(has & V4L2_CAP_VIDEO_OUTPUT))
    return failed(ErrorCode::Unsupported, "it takes no pictures",
                  has & V4L2_CAP_VIDEO_CAPTURE ? ": it is a camera" : "",
                  "; a device of v4l2loopback does until another program has it");
  streams_ = (has & V4L2_CAP_STREAMING) != 0;
  writes_ = (has & V4L2_CAP_READWRITE) != 0 && !write_failed_;
  if (!streams_ && !writes_)
    return failed(ErrorCode::Unsupported, "it takes pictures neither by write() nor in buffers of its own");
  return {};
}

Result<OutputFormat> V4l2Sink::choose_format() const {
  std::vector<std::uint32_t> offered;
  v4l2_fmtdesc description{};
  description.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  for (; ask(VIDIOC_ENUM_FMT, &description) == 0; ++description.index)
    offered.push_back(description.pixelformat);
  for (const OutputFormat& known : kFormats)
    if (std::find(offered.begin(), offered.end(), known.fourcc) != offered.end()) return known;
  return failed(ErrorCode::Unsupported, "it takes none of YUYV, NV12, YU12 and RGB3");
}

Result<void> V4l2Sink::agree(const OutputFormat& chosen) {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  ask(VIDIOC_G_FMT, &format);
  format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  v4l2_pix_format& pix = format.fmt.pix;
  pix.width = static_cast<std::uint32_t>(wanted_.width);
  pix.height = static_cast<std::uint32_t>(wanted_.height);
  pix.pixelformat = chosen.fourcc;
  pix.field = V4L2_FIELD_NONE;
  pix.bytesperline = 0;
  pix.colorspace = V4L2_COLORSPACE_REC709;
  pix.ycbcr_enc = V4L2_YCBCR_ENC_709;
  pix.quantization = V4L2_QUANTIZATION_LIM_RANGE;
  if (const int error = ask(VIDIOC_S_FMT, &format); error != 0)
    return failed(ErrorCode::Unsupported, "it refuses ", wanted_.width, "x", wanted_.height, " (",
                  std::strerror(error), error == EBUSY ? "): another program writes to it" : ")");
  if (pix.pixelformat != chosen.fourcc || pix.width < 2 || pix.height < 2)
    return failed(ErrorCode::Unsupported, "it takes another format than it says");
  agreed_ = pix;
  v4l2_streamparm rate{};
  rate.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
  rate.parm.output.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(1000 * wanted_.rate))};
  ask(VIDIOC_S_PARM, &rate);  // whoever reads may like to know
  return {};
}

Result<void> V4l2Sink::connect() {
  close();
  if (Result<void> ok = open_device(); !ok) return ok;
  const Result<OutputFormat> chosen = choose_format();
  if (!chosen) return forward(chosen);
  if (Result<void> ok = agree(*chosen); !ok) return ok;
  fitted_ = std::make_unique<FittedPicture>(static_cast<int>(agreed_.width), static_cast<int>(agreed_.height),
                                            chosen->format);
  bytes_.assign(agreed_.sizeimage, 0);
  if (writes_) return {};
  buffers_ = std::make_unique<V4l2OutputBuffers>();
  if (const int error = buffers_->start(device_.get()); error != 0)
    return failed(ErrorCode::Io, "it lends no buffers (", std::strerror(error),
                  error == EBUSY ? "): another program writes to it" : ")");
  return {};
}

// Planes one behind the other, with the device's stride; that of chroma follows from luma's (V4L2's rule).
void V4l2Sink::copy(const AVFrame& frame) {
  const auto height = static_cast<int>(agreed_.height);
  const bool planar = agreed_.pixelformat == V4L2_PIX_FMT_YUV420,
             nv12 = agreed_.pixelformat == V4L2_PIX_FMT_NV12;
  std::size_t at = 0;
  for (int p = 0; p < (planar ? 3 : nv12 ? 2 : 1); ++p) {
    const std::size_t stride = agreed_.bytesperline / (p > 0 && planar ? 2 : 1);
    for (int y = 0; y < (p > 0 ? height / 2 : height); ++y, at += stride) {
      const std::size_t row = std::min(stride, static_cast<std::size_t>(frame.linesize[p]));
      if (at + row > bytes_.size()) return;
      std::memcpy(bytes_.data() + at, frame.data[p] + static_cast<std::ptrdiff_t>(y) * frame.linesize[p],
                  row);
    }
  }
}

// 0 or an errno.
int V4l2Sink::hand_over() {
  if (buffers_) return buffers_->put(bytes_);
  return ::write(device_.get(), bytes_.data(), bytes_.size()) >= 0 ? 0 : errno;
}

Result<std::size_t> V4l2Sink::write(const Image& rgb, std::int64_t, bool) {
  copy(*fitted_->of(rgb));
  for (;;) {
    const int error = hand_over();
    if (error == 0) return bytes_.size();
    if (error == EINTR) continue;
    if (error == EINVAL && !buffers_ && streams_) {
      // So with vivid, of which the kernel's write() prepares no buffer; what says its length it takes.
      write_failed_ = true;
      if (Result<void> ok = connect(); !ok) return forward(ok);
      copy(*fitted_->of(rgb));
      continue;
    }
    if (error != EAGAIN)
      return failed(ErrorCode::Disconnected, "it takes no more pictures (", std::strerror(error), ")");
    pollfd ready{device_.get(), POLLOUT, 0};
    if (::poll(&ready, 1, kPatienceMs) == 0) return std::size_t{0};
  }
}

}  // namespace

Result<std::unique_ptr<StreamSink>> open_v4l2_sink(const StreamAddress& address, const StreamFormat& format,
                                                   std::function<bool()> /*stop: never waits for long*/) {
  return std::unique_ptr<StreamSink>(std::make_unique<V4l2Sink>(address, format));
}

}  // namespace floatstage::capture
