#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <utility>

#include "capture/alpha_video.h"
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

// Below this width x264 (164, with its vectors) reads beyond what it has written of a macroblock tree: 64x48
// pictures came out coded in two ways, 134 and 66 times of 200, decoded alike; without the tree in one. Not
// seen from 80 px on; its vectors hold sixteen macroblocks. A finer crf makes up for the tree.
constexpr int kNarrowestTree = 16 * 16;

/// What a file holds its pictures as.
struct Kind {
  const char *name, *encoder, *missing;
  int channels;
  AVPixelFormat given, stored;
  int multiple;  ///< px: sizes that it can hold
  std::array<std::pair<const char*, const char*>, 2> coding, writing;
};
constexpr Kind kMp4 = {"H.264",
                       "libx264",
                       "this libavcodec has no libx264 encoder; install libavcodec-extra or record PNGs",
                       3,
                       AV_PIX_FMT_RGB24,
                       AV_PIX_FMT_YUV420P,
                       2,
                       {{{"preset", "veryfast"}, {"crf", "18"}}},
                       {{{"movflags", "+faststart"}, {nullptr, nullptr}}}};
constexpr Kind kProRes = {"ProRes 4444",
                          "prores_ks",
                          "this libavcodec has no ProRes encoder; install libavcodec-extra or write PNGs",
                          4,
                          AV_PIX_FMT_RGBA,
                          AV_PIX_FMT_YUVA444P10LE,
                          1,
                          {{{"profile", "4444"}, {"alpha_bits", "16"}}},
                          {{{nullptr, nullptr}, {nullptr, nullptr}}}};

void set_all(const std::array<std::pair<const char*, const char*>, 2>& from, libav::Options& options) {
  for (const auto& [key, value] : from)
    if (key != nullptr) options.set(key, value);
}

class FileWriter final : public VideoWriter {
 public:
  FileWriter(const Kind& kind, const fs::path& file, int width, int height)
      : kind_(kind), file_(file), temporary_(temporary_name(file)), width_(width), height_(height) {}
  ~FileWriter() override;

  Result<void> open(double frame_rate);
  Result<void> write(const Image& given) override;
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

  const Kind& kind_;
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
  libav::RoomyCopy roomy_;
  Image padded_;  // only for sizes that the kind cannot hold
  std::int64_t pictures_ = 0;
};

FileWriter::~FileWriter() {
  muxer_.reset();
  if (!claim_ || state_ == State::Finished) return;
  std::error_code ignored;
  fs::remove(temporary_, ignored);
}

Result<void> FileWriter::open_encoder(AVRational rate) {
  const AVCodec* encoder = avcodec_find_encoder_by_name(kind_.encoder);
  if (!encoder) return fail(ErrorCode::Unsupported, kind_.missing);
  const int width = width_ + width_ % kind_.multiple, height = height_ + height_ % kind_.multiple;
  encoder_.reset(avcodec_alloc_context3(encoder));
  FLOATSTAGE_CHECK(encoder_ != nullptr, "out of memory");
  encoder_->width = width;
  encoder_->height = height;
  encoder_->pix_fmt = kind_.stored;
  encoder_->time_base = av_inv_q(rate);
  encoder_->framerate = rate;
  encoder_->color_range = AVCOL_RANGE_MPEG;
  encoder_->colorspace = AVCOL_SPC_BT709;
  encoder_->color_primaries = AVCOL_PRI_BT709;
  encoder_->color_trc = AVCOL_TRC_BT709;
  encoder_->thread_count = kEncoderThreads;
  encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  libav::Options options;
  set_all(kind_.coding, options);
  if (encoder->id == AV_CODEC_ID_H264 && width < kNarrowestTree) options.set("mbtree", "0").set("crf", "16");
  if (const int error = avcodec_open2(encoder_.get(), encoder, options.get()); error < 0)
    return fail(ErrorCode::Unsupported,
                text(kind_.name, " cannot hold ", width_, "x", height_, " pictures: ", libav::reason(error)));

  constexpr int kExact = SWS_ACCURATE_RND | SWS_FULL_CHR_H_INP | SWS_BILINEAR;
  scaler_.reset(sws_getContext(width, height, kind_.given, width, height, kind_.stored, kExact, nullptr,
                               nullptr, nullptr));
  FLOATSTAGE_CHECK(scaler_ != nullptr, "libswscale converts RGB");
  libav::set_bt709(scaler_.get(), true, false);
  picture_->format = kind_.stored;
  picture_->width = width;
  picture_->height = height;
  picture_->color_range = encoder_->color_range;  // ProRes writes what the picture says
  picture_->colorspace = encoder_->colorspace;
  picture_->color_primaries = encoder_->color_primaries;
  picture_->color_trc = encoder_->color_trc;
  FLOATSTAGE_CHECK(av_frame_get_buffer(picture_.get(), 0) >= 0, "out of memory");
  if (width != width_ || height != height_) padded_ = Image(width, height, kind_.channels);
  return {};
}

Result<void> FileWriter::open(double frame_rate) {
  if (Result<void> ok = open_encoder(av_d2q(frame_rate, 100'000)); !ok) return ok;
  Result<Claim> claim = claim_temporary_file(file_, IfThere::Replace);
  if (!claim) return forward(claim);
  claim_ = std::move(*claim);
  muxer_ = libav::new_muxer(libav::muxer_of(file_), temporary_);
  if (libav::is_matroska(file_)) muxer_->avoid_negative_ts = 0;  // its times are when pictures are shown
  stream_ = avformat_new_stream(muxer_.get(), nullptr);
  FLOATSTAGE_CHECK(
      stream_ != nullptr && avcodec_parameters_from_context(stream_->codecpar, encoder_.get()) >= 0,
      "out of memory");
  stream_->time_base = encoder_->time_base;
  stream_->avg_frame_rate = encoder_->framerate;
  if (const int error = avio_open(&muxer_->pb, muxer_->url, AVIO_FLAG_WRITE); error < 0)
    return fail(ErrorCode::Io, text("cannot write ", file_.string(), ": ", libav::reason(error)));
  state_ = State::Open;
  libav::Options options;
  set_all(kind_.writing, options);
  if (const int error = avformat_write_header(muxer_.get(), options.get()); error < 0)
    return io_failure(error);
  return {};
}

// Writes every packet that the encoder has ready.
Result<void> FileWriter::drain() {
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

Result<void> FileWriter::write(const Image& given) {
  if (state_ != State::Open)
    return fail(ErrorCode::InvalidArgument,
                text(file_.string(), ": the video is finished or could not be written"));
  if (given.width != width_ || given.height != height_ || given.channels != kind_.channels)
    return fail(
        ErrorCode::InvalidArgument,
        text(file_.string(), ": a picture of ", given.width, "x", given.height, " with ", given.channels,
             " channels in a video of ", width_, "x", height_, kind_.channels == 4 ? " RGBA" : " RGB"));
  const Image& source = padded_.empty() ? given : padded_;
  if (!padded_.empty())
    for (int y = 0; y < padded_.height; ++y) {
      std::memcpy(padded_.at(0, y), given.at(0, std::min(y, height_ - 1)),
                  static_cast<std::size_t>(width_) * static_cast<std::size_t>(given.channels));
      if (padded_.width != width_)
        std::copy_n(padded_.at(width_ - 1, y), given.channels, padded_.at(width_, y));
    }
  FLOATSTAGE_CHECK(av_frame_make_writable(picture_.get()) >= 0, "out of memory");
  const std::uint8_t* planes[4] = {roomy_.of(source.pixels.data(), source.pixels.size()), nullptr, nullptr,
                                   nullptr};
  const int strides[4] = {source.channels * source.width, 0, 0, 0};
  sws_scale(scaler_.get(), planes, strides, 0, source.height, picture_->data, picture_->linesize);
  picture_->pts = pictures_;
  if (const int error = avcodec_send_frame(encoder_.get(), picture_.get()); error < 0)
    return io_failure(error);
  ++pictures_;
  return drain();
}

Result<void> FileWriter::close_file() {
  int error = avcodec_send_frame(encoder_.get(), nullptr);
  if (error < 0) return io_failure(error);
  if (Result<void> ok = drain(); !ok) return ok;
  error = libav::finish_file(*muxer_);
  if (error < 0) return io_failure(error);
  return {};
}

Result<void> FileWriter::finish() {
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

Result<std::unique_ptr<VideoWriter>> create(const Kind& kind, const fs::path& file, int width, int height,
                                            double frame_rate) {
  libav::be_quiet();
  if (width < 1 || height < 1 || width > 16384 || height > 16384 || !(frame_rate > 0 && frame_rate <= 1000))
    return fail(ErrorCode::InvalidArgument, text(file.string(), ": a video of ", width, "x", height, " at ",
                                                 frame_rate, " pictures per second"));
  auto writer = std::make_unique<FileWriter>(kind, file, width, height);
  if (Result<void> ok = writer->open(frame_rate); !ok) return forward(ok);
  return {std::move(writer)};
}

}  // namespace

Result<std::unique_ptr<VideoWriter>> VideoWriter::create(const std::filesystem::path& file, int width,
                                                         int height, double frame_rate) {
  return capture::create(kMp4, file, width, height, frame_rate);
}

Result<std::unique_ptr<VideoWriter>> create_alpha_video(const std::filesystem::path& file, int width,
                                                        int height, double frame_rate) {
  return capture::create(kProRes, file, width, height, frame_rate);
}

}  // namespace floatstage::capture
