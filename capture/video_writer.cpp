#include <algorithm>
#include <cstring>
#include <optional>

#include "capture/libav.h"
#include "capture/media_file.h"
#include "core/claim.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;

// x264's bytes depend on its number of threads, so that is no matter of the machine.
constexpr int kEncoderThreads = 4;

class Mp4Writer final : public VideoWriter {
 public:
  Mp4Writer(const fs::path& file, int width, int height)
      : file_(file), temporary_(temporary_name(file)), width_(width), height_(height) {}
  ~Mp4Writer() override;

  Result<void> open(double frame_rate);
  Result<void> write(const Image& rgb) override;
  Result<void> finish() override;

 private:
  enum class State { Closed, Open, Failed, Finished };
  Result<void> open_encoder(AVRational rate);
  Result<void> drain();
  Result<void> close_file();
  Unexpected io_failure(int error) {
    state_ = State::Failed;
    return fail(ErrorCode::Io, text("cannot write ", file_.string(), ": ", libav::reason(error)));
  }

  const fs::path file_, temporary_;
  const int width_, height_;
  std::optional<Claim> claim_;
  State state_ = State::Closed;
  libav::Owned<SwsContext> scaler_;
  libav::Owned<AVCodecContext> encoder_;
  libav::Owned<AVFrame> picture_ = libav::new_frame();
  libav::Owned<AVPacket> packet_ = libav::new_packet();
  libav::Format muxer_;
  AVStream* stream_ = nullptr;
  Image padded_;  // only for odd sizes
  std::int64_t pictures_ = 0;
};

Mp4Writer::~Mp4Writer() {
  muxer_.reset();
  if (!claim_ || state_ == State::Finished) return;
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

Result<void> Mp4Writer::open_encoder(AVRational rate) {
  const AVCodec* x264 = avcodec_find_encoder_by_name("libx264");
  if (!x264)
    return fail(ErrorCode::Unsupported,
                "this libavcodec has no libx264 encoder; install libavcodec-extra or record PNGs");
  const int width = width_ + width_ % 2, height = height_ + height_ % 2;
  encoder_.reset(avcodec_alloc_context3(x264));
  FLOATSTAGE_CHECK(encoder_ != nullptr, "out of memory");
  encoder_->width = width;
  encoder_->height = height;
  encoder_->pix_fmt = AV_PIX_FMT_YUV420P;
  encoder_->time_base = av_inv_q(rate);
  encoder_->framerate = rate;
  encoder_->color_range = AVCOL_RANGE_MPEG;
  encoder_->colorspace = AVCOL_SPC_BT709;
  encoder_->color_primaries = AVCOL_PRI_BT709;
  encoder_->color_trc = AVCOL_TRC_BT709;
  encoder_->thread_count = kEncoderThreads;
  encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  libav::Options options;
  options.set("preset", "veryfast").set("crf", "18");
  if (const int error = avcodec_open2(encoder_.get(), x264, options.get()); error < 0)
    return fail(ErrorCode::Unsupported,
                text("H.264 cannot hold ", width_, "x", height_, " pictures: ", libav::reason(error)));

  constexpr int kExact = SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_BILINEAR;
  scaler_.reset(sws_getContext(width, height, AV_PIX_FMT_RGB24, width, height, AV_PIX_FMT_YUV420P, kExact,
                               nullptr, nullptr, nullptr));
  FLOATSTAGE_CHECK(scaler_ != nullptr, "libswscale converts RGB");
  libav::set_bt709(scaler_.get(), true, false);
  picture_->format = AV_PIX_FMT_YUV420P;
  picture_->width = width;
  picture_->height = height;
  FLOATSTAGE_CHECK(av_frame_get_buffer(picture_.get(), 0) >= 0, "out of memory");
  if (width != width_ || height != height_) padded_ = Image(width, height, 3);
  return {};
}

Result<void> Mp4Writer::open(double frame_rate) {
  if (Result<void> ok = open_encoder(av_d2q(frame_rate, 100'000)); !ok) return ok;
  Result<Claim> claim = claim_temporary_file(file_, IfThere::Replace);
  if (!claim) return forward(claim);
  claim_ = std::move(*claim);
  AVFormatContext* made = nullptr;
  const std::string url = libav::file_url(temporary_);
  FLOATSTAGE_CHECK(avformat_alloc_output_context2(&made, nullptr, "mp4", url.c_str()) >= 0,
                   "libavformat without MP4");
  muxer_.reset(made);
  muxer_->flags |= AVFMT_FLAG_BITEXACT;
  stream_ = avformat_new_stream(muxer_.get(), nullptr);
  FLOATSTAGE_CHECK(
      stream_ != nullptr && avcodec_parameters_from_context(stream_->codecpar, encoder_.get()) >= 0,
      "out of memory");
  stream_->time_base = encoder_->time_base;
  stream_->avg_frame_rate = encoder_->framerate;
  if (const int error = avio_open(&muxer_->pb, url.c_str(), AVIO_FLAG_WRITE); error < 0)
    return fail(ErrorCode::Io, text("cannot write ", file_.string(), ": ", libav::reason(error)));
  state_ = State::Open;
  libav::Options options;
  options.set("movflags", "+faststart");
  if (const int error = avformat_write_header(muxer_.get(), options.get()); error < 0)
    return io_failure(error);
  return {};
}

// Writes every packet that the encoder has ready.
Result<void> Mp4Writer::drain() {
  for (;;) {
    int error = avcodec_receive_packet(encoder_.get(), packet_.get());
    if (error == AVERROR(EAGAIN) || error == AVERROR_EOF) return {};
    if (error < 0) return io_failure(error);
    av_packet_rescale_ts(packet_.get(), encoder_->time_base, stream_->time_base);
    packet_->stream_index = 0;
    error = av_interleaved_write_frame(muxer_.get(), packet_.get());
    if (error >= 0) error = muxer_->pb->error;
    if (error < 0) return io_failure(error);
  }
}

Result<void> Mp4Writer::write(const Image& rgb) {
  if (state_ != State::Open)
    return fail(ErrorCode::InvalidArgument,
                text(file_.string(), ": the video is finished or could not be written"));
  if (rgb.width != width_ || rgb.height != height_ || rgb.channels != 3)
    return fail(ErrorCode::InvalidArgument,
                text(file_.string(), ": a picture of ", rgb.width, "x", rgb.height, " with ", rgb.channels,
                     " channels in a video of ", width_, "x", height_, " RGB"));
  const Image& source = padded_.empty() ? rgb : padded_;
  if (!padded_.empty())
    for (int y = 0; y < padded_.height; ++y) {
      std::memcpy(padded_.at(0, y), rgb.at(0, std::min(y, height_ - 1)),
                  static_cast<std::size_t>(width_) * 3);
      if (padded_.width != width_) std::copy_n(padded_.at(width_ - 1, y), 3, padded_.at(width_, y));
    }
  FLOATSTAGE_CHECK(av_frame_make_writable(picture_.get()) >= 0, "out of memory");
  const std::uint8_t* planes[4] = {source.pixels.data(), nullptr, nullptr, nullptr};
  const int strides[4] = {3 * source.width, 0, 0, 0};
  sws_scale(scaler_.get(), planes, strides, 0, source.height, picture_->data, picture_->linesize);
  picture_->pts = pictures_;
  if (const int error = avcodec_send_frame(encoder_.get(), picture_.get()); error < 0)
    return io_failure(error);
  ++pictures_;
  return drain();
}

Result<void> Mp4Writer::close_file() {
  int error = avcodec_send_frame(encoder_.get(), nullptr);
  if (error < 0) return io_failure(error);
  if (Result<void> ok = drain(); !ok) return ok;
  error = av_write_trailer(muxer_.get());
  if (error >= 0) error = muxer_->pb->error;
  const int closed = avio_closep(&muxer_->pb);
  if (error >= 0) error = closed;
  if (error < 0) return io_failure(error);
  return {};
}

Result<void> Mp4Writer::finish() {
  if (state_ != State::Open)
    return fail(ErrorCode::InvalidArgument,
                text(file_.string(), ": the video is finished or could not be written"));
  if (pictures_ == 0)
    return fail(ErrorCode::InvalidArgument, text(file_.string(), ": a video needs at least one picture"));
  if (Result<void> ok = close_file(); !ok) return ok;
  std::error_code error;
  fs::rename(temporary_, file_, error);
  if (error) {
    state_ = State::Failed;
    return fail(ErrorCode::Io, text("cannot write ", file_.string(), ": ", error.message()));
  }
  state_ = State::Finished;
  return {};
}

}  // namespace

Result<std::unique_ptr<VideoWriter>> VideoWriter::create(const std::filesystem::path& file, int width,
                                                         int height, double frame_rate) {
  libav::be_quiet();
  if (width < 1 || height < 1 || width > 16384 || height > 16384 || !(frame_rate > 0 && frame_rate <= 1000))
    return fail(ErrorCode::InvalidArgument, text(file.string(), ": a video of ", width, "x", height, " at ",
                                                 frame_rate, " pictures per second"));
  auto writer = std::make_unique<Mp4Writer>(file, width, height);
  if (Result<void> ok = writer->open(frame_rate); !ok) return forward(ok);
  return {std::move(writer)};
}

}  // namespace floatstage::capture
