#include "capture/sound/film_sound_track.h"

#include <algorithm>
#include <cmath>

#include "core/text.h"

namespace floatstage::capture {
namespace {

constexpr int kPcmBlock = 1024;
constexpr int kAacBitsPerChannel = 96'000;  // a second: what stereo AAC needs to pass for the original

AVCodecID codec_for(const std::filesystem::path& film) {
  if (libav::is_matroska(film)) return AV_CODEC_ID_FLAC;
  return film.extension() == ".mov" ? AV_CODEC_ID_PCM_S24LE : AV_CODEC_ID_AAC;
}

}  // namespace

Result<void> FilmSoundTrack::open(AVFormatContext& muxer, const std::filesystem::path& film) {
  film_ = film;
  muxer_ = &muxer;
  const AVCodec* codec = avcodec_find_encoder(codec_for(film));
  if (!codec)
    return fail(
        ErrorCode::Unsupported,
        text(film.string(), ": this libavcodec has no encoder for its sound; render with --no-sound"));
  encoder_.reset(avcodec_alloc_context3(codec));
  FLOATSTAGE_CHECK(encoder_ != nullptr, "out of memory");
  const bool aac = codec->id == AV_CODEC_ID_AAC;
  encoder_->sample_rate = kPlayOutRate;
  encoder_->time_base = {1, kPlayOutRate};
  encoder_->sample_fmt = aac ? AV_SAMPLE_FMT_FLTP : AV_SAMPLE_FMT_S32;
  if (!aac) encoder_->bits_per_raw_sample = 24;
  if (aac) encoder_->bit_rate = std::int64_t{kAacBitsPerChannel} * sound_.channels;
  encoder_->thread_count = 1;
  encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  av_channel_layout_default(&encoder_->ch_layout, sound_.channels);
  if (const int error = avcodec_open2(encoder_.get(), codec, nullptr); error < 0)
    return fail(ErrorCode::Unsupported, text(film.string(), ": its sound: ", libav::reason(error)));
  block_ = encoder_->frame_size > 0 ? encoder_->frame_size : kPcmBlock;
  stream_ = avformat_new_stream(&muxer, nullptr);
  FLOATSTAGE_CHECK(
      stream_ != nullptr && avcodec_parameters_from_context(stream_->codecpar, encoder_.get()) >= 0,
      "out of memory");
  stream_->time_base = encoder_->time_base;
  return {};
}

Result<void> FilmSoundTrack::write_until(double seconds) {
  const auto channels = static_cast<std::size_t>(sound_.channels);
  const auto until = std::min(sound_.samples, static_cast<std::int64_t>(std::ceil(seconds * kPlayOutRate)));
  while (coded_ < until) {
    const auto count = static_cast<std::size_t>(std::min<std::int64_t>(block_, sound_.samples - coded_));
    levels_.resize(count * channels);
    if (Result<void> ok = sound_.read(coded_, levels_); !ok) return ok;
    av_frame_unref(frame_.get());
    frame_->format = encoder_->sample_fmt;
    frame_->nb_samples = static_cast<int>(count);
    frame_->sample_rate = kPlayOutRate;
    FLOATSTAGE_CHECK(av_channel_layout_copy(&frame_->ch_layout, &encoder_->ch_layout) >= 0 &&
                         av_frame_get_buffer(frame_.get(), 0) >= 0,
                     "out of memory");
    constexpr double kFull = 1 << 23;
    for (std::size_t i = 0; i < levels_.size(); ++i) {
      if (encoder_->sample_fmt == AV_SAMPLE_FMT_FLTP) {
        reinterpret_cast<float*>(frame_->data[i % channels])[i / channels] =
            std::clamp(levels_[i], -1.f, 1.f);
      } else {
        const double level = std::clamp(std::round(levels_[i] * kFull), -kFull, kFull - 1);
        reinterpret_cast<std::int32_t*>(frame_->data[0])[i] = static_cast<std::int32_t>(level) * 256;
      }
    }
    frame_->pts = coded_;
    coded_ += static_cast<std::int64_t>(count);
    if (Result<void> ok = code(frame_.get()); !ok) return ok;
  }
  return {};
}

Result<void> FilmSoundTrack::finish() {
  if (Result<void> ok = write_until(static_cast<double>(sound_.samples) / kPlayOutRate + 1); !ok) return ok;
  return code(nullptr);
}

Result<void> FilmSoundTrack::code(const AVFrame* block) {
  int error = avcodec_send_frame(encoder_.get(), block);
  while (error >= 0) {
    error = avcodec_receive_packet(encoder_.get(), packet_.get());
    if (error == AVERROR(EAGAIN) || error == AVERROR_EOF) return {};
    if (error < 0) break;
    av_packet_rescale_ts(packet_.get(), encoder_->time_base, stream_->time_base);
    packet_->stream_index = stream_->index;
    error = av_interleaved_write_frame(muxer_, packet_.get());
    if (error >= 0) error = muxer_->pb->error;
  }
  return fail(ErrorCode::Io, text("cannot write the sound of ", film_.string(), ": ", libav::reason(error)));
}

}  // namespace floatstage::capture
