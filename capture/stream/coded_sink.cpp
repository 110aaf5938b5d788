#include <atomic>
#include <cerrno>
#include <chrono>
#include <filesystem>

#include "capture/libav.h"
#include "capture/stream/fitted_picture.h"
#include "capture/stream/stream_sink.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

using Kind = StreamAddress::Kind;
using Clock = std::chrono::steady_clock;

constexpr int kEncoderThreads = 2;
constexpr double kKeySeconds = 1;                        // whoever comes late waits so long at most
constexpr auto kPatience = std::chrono::seconds(3);      // for a receiver that does not take what it is sent
constexpr auto kCallPatience = std::chrono::seconds(5);  // for one that is called
constexpr const char* kDatagram = "1316";                // bytes: seven packets of MPEG-TS, as players expect

const char* muxer_of(Kind kind) {
  return kind == Kind::Rtsp ? "rtsp" : kind == Kind::Rtp ? "rtp_mpegts" : "mpegts";
}

class CodedSink final : public StreamSink {
 public:
  CodedSink(const StreamAddress& address, const StreamFormat& format, std::function<bool()> stop)
      : address_(address),
        format_(format),
        stop_(std::move(stop)),
        fitted_(format.width, format.height, AV_PIX_FMT_YUV420P) {}
  ~CodedSink() override { close(); }

  Result<void> open_encoder();
  Result<void> connect() override;
  Result<std::size_t> write(const Image& rgb, std::int64_t instant, bool fresh) override;
  void close() override;
  bool returns() const override { return address_.kind != Kind::File; }

 private:
  static int interrupted(void* self) { return static_cast<const CodedSink*>(self)->give_up() ? 1 : 0; }
  // What has begun to be sent is sent when the program ends: only who waits for a receiver is stopped.
  bool give_up() const { return (!header_ && stop_ && stop_()) || Clock::now() > deadline_; }
  void wait_at_most(Clock::duration patience) { deadline_ = Clock::now() + patience; }
  Result<void> open_protocol();
  Unexpected not_connected(int error);

  const StreamAddress address_;
  const StreamFormat format_;
  const std::function<bool()> stop_;
  FittedPicture fitted_;
  Clock::time_point deadline_ = Clock::time_point::max();
  libav::Owned<AVCodecContext> encoder_;
  libav::Owned<AVPacket> packet_ = libav::new_packet();
  libav::Format muxer_;
  bool header_ = false;
};

Result<void> CodedSink::open_encoder() {
  libav::be_quiet();
  const AVCodec* encoder = avcodec_find_encoder_by_name("libx264");
  if (!encoder)
    return fail(ErrorCode::Unsupported,
                "this libavcodec has no libx264 encoder, which --stream needs; install libavcodec-extra");
  encoder_.reset(avcodec_alloc_context3(encoder));
  FLOATSTAGE_CHECK(encoder_ != nullptr, "out of memory");
  encoder_->width = format_.width;
  encoder_->height = format_.height;
  encoder_->pix_fmt = AV_PIX_FMT_YUV420P;
  encoder_->framerate = av_d2q(format_.rate, 100'000);
  encoder_->time_base = av_inv_q(encoder_->framerate);
  encoder_->color_range = AVCOL_RANGE_MPEG;
  encoder_->colorspace = AVCOL_SPC_BT709;
  encoder_->color_primaries = AVCOL_PRI_BT709;
  encoder_->color_trc = AVCOL_TRC_BT709;
  encoder_->thread_count = kEncoderThreads;
  encoder_->gop_size = std::max(1, static_cast<int>(kKeySeconds * format_.rate));
  encoder_->max_b_frames = 0;
  encoder_->rc_max_rate = std::int64_t{1000} * format_.most_kbit;
  encoder_->rc_buffer_size = 250 * format_.most_kbit;
  libav::Options options;
  options.set("preset", "veryfast").set("tune", "zerolatency").set("crf", "20").set("forced-idr", "1");
  if (const int error = avcodec_open2(encoder_.get(), encoder, options.get()); error < 0)
    return fail(ErrorCode::Unsupported, text("H.264 cannot hold ", format_.width, "x", format_.height,
                                             " pictures: ", libav::reason(error)));
  return {};
}

Unexpected CodedSink::not_connected(int error) {
  close();
  if (stop_ && stop_()) return fail(ErrorCode::Cancelled, text("--stream ", address_.shown, ": interrupted"));
  if (address_.kind == Kind::File)
    return fail(libav::code_of(error),
                text("--stream ", address_.shown, ": it cannot be written (", libav::reason(error), ")"));
  const std::string why = error == AVERROR_EXIT        ? "no answer within 5 s"
                          : address_.kind == Kind::Srt ? "no answer"  // all that libav tells
                                                       : libav::reason(error);
  return fail(
      ErrorCode::Disconnected,
      text("--stream ", address_.shown, ": nobody receives there (", why, ")",
           address_.kind == Kind::Rtsp ? "; start an RTSP server that takes streams, or check the name"
           : address_.kind == Kind::Srt
               ? "; start the receiver first, or be called by it: srt://:PORT?mode=listener"
               : "; check host and network"));
}

Result<void> CodedSink::open_protocol() {
  std::string url = address_.url;
  if (address_.kind == Kind::File) {
    if (std::error_code ignored; std::filesystem::exists(address_.path, ignored))
      return fail(ErrorCode::AlreadyExists,
                  text("--stream ", address_.shown, ": the file is there; nothing was overwritten"));
    url = libav::file_url(address_.path);
  }
  libav::Options options;
  if (address_.kind == Kind::Udp && url.find("pkt_size=") == std::string::npos)
    options.set("pkt_size", kDatagram);
  const AVIOInterruptCB interrupt = muxer_->interrupt_callback;
  if (const int error = avio_open2(&muxer_->pb, url.c_str(), AVIO_FLAG_WRITE, &interrupt, options.get());
      error < 0)
    return not_connected(error);
  return {};
}

Result<void> CodedSink::connect() {
  close();
  AVFormatContext* made = nullptr;
  if (avformat_alloc_output_context2(&made, nullptr, muxer_of(address_.kind), address_.url.c_str()) < 0)
    return fail(ErrorCode::Unsupported, text("this libavformat cannot write ", muxer_of(address_.kind)));
  muxer_.reset(made);
  muxer_->interrupt_callback = {&CodedSink::interrupted, this};
  muxer_->flags |= AVFMT_FLAG_FLUSH_PACKETS;
  muxer_->max_delay = 0;
  AVStream* stream = avformat_new_stream(muxer_.get(), nullptr);
  FLOATSTAGE_CHECK(
      stream != nullptr && avcodec_parameters_from_context(stream->codecpar, encoder_.get()) >= 0,
      "out of memory");
  stream->time_base = encoder_->time_base;
  stream->avg_frame_rate = encoder_->framerate;
  deadline_ = Clock::time_point::max();
  if (!address_.listens) wait_at_most(kCallPatience);
  if ((muxer_->oformat->flags & AVFMT_NOFILE) == 0)
    if (Result<void> ok = open_protocol(); !ok) return ok;
  wait_at_most(kCallPatience);
  libav::Options options;
  options.set("omit_video_pes_length", "0");  // or receivers wait for the next picture to know where one ends
  if (const int error = avformat_write_header(muxer_.get(), options.get()); error < 0)
    return not_connected(error);
  header_ = true;
  return {};
}

Result<std::size_t> CodedSink::write(const Image& rgb, std::int64_t instant, bool fresh) {
  AVFrame* picture = fitted_.of(rgb);
  picture->pts = instant;
  picture->pict_type = fresh ? AV_PICTURE_TYPE_I : AV_PICTURE_TYPE_NONE;
  int error = avcodec_send_frame(encoder_.get(), picture);
  wait_at_most(kPatience);
  std::size_t bytes = 0;
  while (error >= 0) {
    error = avcodec_receive_packet(encoder_.get(), packet_.get());
    if (error == AVERROR(EAGAIN)) return bytes;
    if (error < 0) break;
    bytes += static_cast<std::size_t>(packet_->size);
    av_packet_rescale_ts(packet_.get(), encoder_->time_base, muxer_->streams[0]->time_base);
    packet_->stream_index = 0;
    error = av_write_frame(muxer_.get(), packet_.get());
    if (error >= 0 && muxer_->pb != nullptr) error = muxer_->pb->error;
    av_packet_unref(packet_.get());
  }
  return fail(address_.kind == Kind::File ? ErrorCode::Io : ErrorCode::Disconnected,
              text("--stream ", address_.shown, ": ",
                   address_.kind == Kind::File ? "it cannot be written any more" : "its receiver is gone",
                   " (", error == AVERROR_EXIT ? "it took nothing for 3 s" : libav::reason(error), ")"));
}

void CodedSink::close() {
  wait_at_most(std::chrono::seconds(1));
  if (muxer_ && header_) av_write_trailer(muxer_.get());
  header_ = false;
  muxer_.reset();
}

}  // namespace

Result<std::unique_ptr<StreamSink>> open_coded_sink(const StreamAddress& address, const StreamFormat& format,
                                                    std::function<bool()> stop) {
  if (address.listens)
    if (Result<void> ok = check_port_is_free(address); !ok) return forward(ok);
  auto sink = std::make_unique<CodedSink>(address, format, std::move(stop));
  if (Result<void> ok = sink->open_encoder(); !ok) return forward(ok);
  return std::unique_ptr<StreamSink>(std::move(sink));
}

}  // namespace floatstage::capture
