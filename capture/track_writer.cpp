#include "capture/track_writer.h"

extern "C" {
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
}

#include <algorithm>
#include <thread>

#include "capture/libav.h"
#include "capture/picture_packing.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

// Slices let one picture be coded by several cores, and a part of it be read for less than the whole (ADR
// 361). Their number depends on nothing but the picture's size, so the bytes do not depend on the machine.
int slices_of(int width, int height) {
  constexpr int kMostASide = 8, kLeastWidth = 64, kLeastHeight = 40;  // px, of a slice
  int a_side = kMostASide;
  while (a_side > 1 && (width < a_side * kLeastWidth || height < a_side * kLeastHeight)) a_side /= 2;
  return a_side * a_side;
}

// libav's encoder takes 148 bytes a pixel, up to 2 GB, as long as a camera's track is open. (In four slices
// it takes no larger pictures.)
bool is_too_large(PixelFormat format, int width, int height) {
  constexpr std::int64_t kMost = 30'000'000, kMostOfOneChannel = 60'000'000;  // px
  const bool one = format == PixelFormat::Gray8 || format == PixelFormat::BayerRggb8;
  return std::int64_t{width} * height > (one ? kMostOfOneChannel : kMost);
}

/// Turns pictures into packets: one in, one out, so that nothing waits inside an encoder when the program is
/// killed.
class PictureCoder {
 public:
  Result<void> open(TakeCodec codec, const PicturePacking& packing, AVRational time_base,
                    AVRational frame_rate);
  Result<void> code(const AVFrame& picture, AVPacket& packet);
  void describe(AVCodecParameters& stream) const;

 private:
  int open_encoder(const AVCodec& codec, TakeCodec kind, const PicturePacking& packing, AVRational time_base,
                   AVRational frame_rate, int slices);
  libav::Owned<AVCodecContext> encoder_;  // none for raw pictures
  AVPixelFormat raw_format_ = AV_PIX_FMT_NONE;
  int width_ = 0, height_ = 0;
};

Result<void> PictureCoder::open(TakeCodec codec, const PicturePacking& packing, AVRational time_base,
                                AVRational frame_rate) {
  width_ = packing.layout().width;
  height_ = packing.layout().height;
  if (codec == TakeCodec::Raw) {
    raw_format_ = packing.pixel_format();
    return {};
  }
  const bool ffv1 = codec == TakeCodec::Ffv1;
  const AVCodec* found =
      ffv1 ? avcodec_find_encoder(AV_CODEC_ID_FFV1) : avcodec_find_encoder_by_name("libx264");
  if (!found)
    return fail(ErrorCode::Unsupported,
                text("this libavcodec has no ", ffv1 ? "FFV1" : "libx264", " encoder"));
  if (ffv1 && is_too_large(packing.layout().format, width_, height_))
    return fail(ErrorCode::Unsupported,
                text(width_, "x", height_, " ", name_of(packing.layout().format),
                     " pictures are too large for FFV1, which has up to 30 Mpx of colour and 60 Mpx of one "
                     "channel; record them raw"));
  int error = open_encoder(*found, codec, packing, time_base, frame_rate, slices_of(width_, height_));
  // libav cannot cut some small or odd-sized pictures with shared chroma.
  if (error < 0 && codec == TakeCodec::Ffv1)
    error = open_encoder(*found, codec, packing, time_base, frame_rate, 1);
  if (error < 0)
    return fail(ErrorCode::Unsupported,
                text("the ", ffv1 ? "FFV1" : "H.264", " encoder refuses ", width_, "x", height_, " ",
                     name_of(packing.layout().format), " pictures (", libav::reason(error), "); ",
                     ffv1 ? "record them raw" : "it wants even sizes: record as FFV1 or raw"));
  return {};
}

int PictureCoder::open_encoder(const AVCodec& codec, TakeCodec kind, const PicturePacking& packing,
                               AVRational time_base, AVRational frame_rate, int slices) {
  encoder_.reset(avcodec_alloc_context3(&codec));
  FLOATSTAGE_CHECK(encoder_ != nullptr, "out of memory");
  encoder_->width = width_;
  encoder_->height = height_;
  encoder_->pix_fmt = packing.pixel_format();
  encoder_->time_base = time_base;
  encoder_->framerate = frame_rate;
  encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  libav::Options options;
  if (kind == TakeCodec::Ffv1) {
    // Version 3 with a checksum a slice; every picture a key picture. Golomb-Rice codes with the small
    // context are twice as fast as the range coder for 2-5 % more bytes (docs/adr/0020).
    encoder_->level = 3;
    encoder_->gop_size = 1;
    encoder_->slices = slices;
    encoder_->thread_type = FF_THREAD_SLICE;
    encoder_->thread_count = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, slices);
    options.set("slicecrc", "1").set("coder", "rice").set("context", "0");
  } else {
    encoder_->gop_size = 25;
    encoder_->max_b_frames = 0;
    encoder_->thread_count = 1;  // x264's bytes depend on it
    if (encoder_->pix_fmt == AV_PIX_FMT_YUV444P) {
      encoder_->color_range = AVCOL_RANGE_JPEG;
      encoder_->colorspace = AVCOL_SPC_BT709;
    }
    options.set("preset", "veryfast").set("tune", "zerolatency").set("crf", "16");
  }
  return avcodec_open2(encoder_.get(), &codec, options.get());
}

Result<void> PictureCoder::code(const AVFrame& picture, AVPacket& packet) {
  av_packet_unref(&packet);
  if (!encoder_) {
    const int size = av_image_get_buffer_size(raw_format_, width_, height_, 1);
    FLOATSTAGE_CHECK(size > 0 && av_new_packet(&packet, size) == 0, "out of memory");
    av_image_copy_to_buffer(packet.data, size, picture.data, picture.linesize, raw_format_, width_, height_,
                            1);
    packet.flags |= AV_PKT_FLAG_KEY;
    return {};
  }
  int error = avcodec_send_frame(encoder_.get(), &picture);
  if (error >= 0) error = avcodec_receive_packet(encoder_.get(), &packet);
  if (error < 0) return fail(ErrorCode::Unsupported, text("the encoder failed: ", libav::reason(error)));
  return {};
}

void PictureCoder::describe(AVCodecParameters& stream) const {
  if (encoder_) {
    FLOATSTAGE_CHECK(avcodec_parameters_from_context(&stream, encoder_.get()) >= 0, "out of memory");
    return;
  }
  stream.codec_type = AVMEDIA_TYPE_VIDEO;
  stream.codec_id = AV_CODEC_ID_RAWVIDEO;
  stream.codec_tag = raw_format_ == AV_PIX_FMT_BGR24 ? 0 : avcodec_pix_fmt_to_codec_tag(raw_format_);
  stream.format = raw_format_;
  stream.width = width_;
  stream.height = height_;
  stream.bits_per_coded_sample = raw_format_ == AV_PIX_FMT_BGR24 ? 24 : 0;
}

class MatroskaTrack final : public TrackWriter {
 public:
  MatroskaTrack(std::filesystem::path file, TakeCodec codec, PicturePacking packing)
      : file_(std::move(file)), codec_(codec), packing_(std::move(packing)) {}

  Result<void> open(const std::string& serial, double frame_rate);
  Result<void> write(const Frame& frame) override;
  Result<void> finish() override;

 private:
  Unexpected io_failure(int error) const {
    return fail(ErrorCode::Io, text("cannot write ", file_.string(), ": ", libav::reason(error),
                                    "; the pictures before it are safe"));
  }

  const std::filesystem::path file_;
  const TakeCodec codec_;
  const PicturePacking packing_;
  PictureCoder coder_;
  libav::Format muxer_;
  AVStream* stream_ = nullptr;
  AVRational tick_ = {1, 25};
  libav::Owned<AVFrame> picture_;
  libav::Owned<AVPacket> packet_;
  std::int64_t pictures_ = 0, last_time_ = -1;
};

Result<void> MatroskaTrack::open(const std::string& serial, double frame_rate) {
  const AVRational rate = av_d2q(frame_rate > 0 ? frame_rate : 1.0, 1'000'000);
  tick_ = av_inv_q(rate);
  if (Result<void> ok = coder_.open(codec_, packing_, tick_, rate); !ok) return ok;

  picture_ = libav::new_frame();
  picture_->format = packing_.pixel_format();
  picture_->width = packing_.layout().width;
  picture_->height = packing_.layout().height;
  FLOATSTAGE_CHECK(av_frame_get_buffer(picture_.get(), 0) >= 0, "out of memory");
  packet_ = libav::new_packet();

  muxer_ = libav::new_muxer("matroska", file_);
  stream_ = avformat_new_stream(muxer_.get(), nullptr);
  FLOATSTAGE_CHECK(stream_ != nullptr, "out of memory");
  coder_.describe(*stream_->codecpar);
  stream_->time_base = {1, 1000};
  stream_->avg_frame_rate = rate;
  av_dict_set(&muxer_->metadata, "title", serial.c_str(), 0);  // tells a renamed file's camera

  if (const int error = avio_open(&muxer_->pb, muxer_->url, AVIO_FLAG_WRITE); error < 0)
    return io_failure(error);
  // FFV1 has its own checksums, and a second pass over raw pictures costs more than writing them.
  libav::Options options;
  options.set("allow_raw_vfw", "1").set("write_crc32", "0");
  if (const int error = avformat_write_header(muxer_.get(), options.get()); error < 0)
    return io_failure(error);
  avio_flush(muxer_->pb);
  if (muxer_->pb->error < 0) return io_failure(muxer_->pb->error);
  return {};
}

Result<void> MatroskaTrack::write(const Frame& frame) {
  FLOATSTAGE_CHECK(av_frame_make_writable(picture_.get()) >= 0, "out of memory");
  packing_.pack(frame, *picture_);
  picture_->pts = pictures_;
  if (Result<void> ok = coder_.code(*picture_, *packet_); !ok)
    return fail(ok.error().code, text(file_.string(), ": ", ok.error().message));
  // Container times are for players only; Matroska counts milliseconds and wants them to grow.
  last_time_ = std::max(last_time_ + 1, av_rescale_q(pictures_, tick_, stream_->time_base));
  packet_->pts = packet_->dts = last_time_;
  packet_->duration = 0;
  packet_->stream_index = 0;
  // The second call ends the cluster, so that every picture is whole in the file before its row is written.
  int error = av_write_frame(muxer_.get(), packet_.get());
  if (error >= 0) error = av_write_frame(muxer_.get(), nullptr);
  if (error >= 0) avio_flush(muxer_->pb);
  if (error >= 0) error = muxer_->pb->error;
  if (error < 0) return io_failure(error);
  ++pictures_;
  return {};
}

Result<void> MatroskaTrack::finish() {
  if (const int error = libav::finish_file(*muxer_); error < 0) return io_failure(error);
  return {};
}

}  // namespace

Result<std::unique_ptr<TrackWriter>> TrackWriter::create(const std::filesystem::path& file,
                                                         const std::string& serial, TakeCodec codec,
                                                         const ImageLayout& layout, double frame_rate) {
  libav::be_quiet();
  Result<PicturePacking> packing = PicturePacking::create(codec, layout.format, layout.width, layout.height);
  if (!packing) return fail(packing.error().code, text("camera '", serial, "': ", packing.error().message));
  auto track = std::make_unique<MatroskaTrack>(file, codec, std::move(*packing));
  if (Result<void> ok = track->open(serial, frame_rate); !ok)
    return fail(ok.error().code, text("camera '", serial, "': ", ok.error().message));
  return {std::move(track)};
}

}  // namespace floatstage::capture
