#include "capture/sound/media_sound.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "capture/libav.h"
#include "capture/media_input.h"
#include "capture/sound/sound_record.h"
#include "capture/sound/wav_length.h"
#include "core/text.h"
#include "core/working_on.h"

namespace floatstage::capture {
namespace {

// One sample as libav holds it, at full scale ±1.
float level(const std::uint8_t* at, AVSampleFormat packed) {
  const auto as = [at](auto value) {
    std::memcpy(&value, at, sizeof value);
    return value;
  };
  switch (packed) {
    case AV_SAMPLE_FMT_U8:
      return std::ldexp(static_cast<float>(*at) - 128.f, -7);
    case AV_SAMPLE_FMT_S16:
      return std::ldexp(static_cast<float>(as(std::int16_t{})), -15);
    case AV_SAMPLE_FMT_S32:
      return static_cast<float>(std::ldexp(static_cast<double>(as(std::int32_t{})), -31));
    case AV_SAMPLE_FMT_S64:
      return static_cast<float>(std::ldexp(static_cast<double>(as(std::int64_t{})), -63));
    case AV_SAMPLE_FMT_FLT:
      return as(float{});
    case AV_SAMPLE_FMT_DBL:
      return static_cast<float>(as(double{}));
    default:
      return 0;
  }
}

class LibavSound final : public MediaSound {
 public:
  LibavSound(std::string name, std::unique_ptr<libav::Input> input, int stream)
      : name_(std::move(name)), input_(std::move(input)), stream_(input_->format().streams[stream]) {}

  Result<void> open() {
    const AVCodecParameters& p = *stream_->codecpar;
    const AVCodec* codec = avcodec_find_decoder(p.codec_id);
    if (!codec) return bad("is coded in a way that is not known here");
    if (p.ch_layout.nb_channels < 1 || p.ch_layout.nb_channels > kMostSoundChannels)
      return bad(text("has ", p.ch_layout.nb_channels, " channels; a take holds 1 to ", kMostSoundChannels));
    if (p.sample_rate < kLowestSoundRate || p.sample_rate > kHighestSoundRate)
      return bad(text("has ", p.sample_rate, " samples a second; a take holds ", kLowestSoundRate, " to ",
                      kHighestSoundRate));
    channels_ = p.ch_layout.nb_channels;
    rate_ = p.sample_rate;
    decoder_.reset(avcodec_alloc_context3(codec));
    FLOATSTAGE_CHECK(decoder_ != nullptr, "out of memory");
    int error = avcodec_parameters_to_context(decoder_.get(), &p);
    decoder_->pkt_timebase = stream_->time_base;
    decoder_->thread_count = 1;
    if (error >= 0) error = avcodec_open2(decoder_.get(), codec, nullptr);
    if (error < 0) return bad(text("cannot be decoded: ", libav::reason(error)));
    const int stated = std::max(p.bits_per_raw_sample, p.bits_per_coded_sample);
    const AVSampleFormat packed = av_get_packed_sample_fmt(decoder_->sample_fmt);
    // Lossy codecs come as floats, finer than 16 bits.
    bits_ = packed == AV_SAMPLE_FMT_U8 || packed == AV_SAMPLE_FMT_S16 ||
                    (stated > 0 && stated <= 16 && packed == AV_SAMPLE_FMT_S32)
                ? 16
                : 24;
    return {};
  }

  int rate() const override { return rate_; }
  int channels() const override { return channels_; }
  int bits() const override { return bits_; }

  std::optional<double> since_midnight() const override {
    const std::string_view stated = tag("time_reference");
    std::int64_t samples = 0;
    const char* const end = stated.data() + stated.size();
    const auto [next, error] = std::from_chars(stated.data(), end, samples);
    if (error != std::errc() || next != end || samples < 0) return std::nullopt;
    return static_cast<double>(samples) / rate_;
  }

  std::optional<std::string> time_code() const override {
    const std::string_view stated = tag("timecode");
    return stated.empty() ? std::nullopt : std::optional(std::string(stated));
  }

  Result<Block> next() override {
    const WorkingOn here(name_);
    if (Result<void> ok = decode(); !ok) return forward(ok);
    if (decoded_->ch_layout.nb_channels != channels_ || decoded_->sample_rate != rate_)
      return bad("changes its channels or its rate in the middle");
    Block block;
    const auto format = static_cast<AVSampleFormat>(decoded_->format);
    const AVSampleFormat packed = av_get_packed_sample_fmt(format);
    const bool planar = av_sample_fmt_is_planar(format) != 0;
    const auto bytes = static_cast<std::size_t>(av_get_bytes_per_sample(format));
    const auto channels = static_cast<std::size_t>(channels_);
    const auto count = static_cast<std::size_t>(decoded_->nb_samples);
    block.samples.resize(count * channels);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < channels; ++c) {
        const std::uint8_t* at = planar ? decoded_->extended_data[c] + i * bytes
                                        : decoded_->extended_data[0] + (i * channels + c) * bytes;
        const float value = level(at, packed);
        block.samples[i * channels + c] = std::isfinite(value) ? value : 0;
      }
    if (decoded_->pts != AV_NOPTS_VALUE)
      time_ = {av_rescale_q(decoded_->pts, stream_->time_base, {1, 1'000'000'000})};
    block.time = time_;
    time_ = time_ + Nanoseconds{av_rescale_q(decoded_->nb_samples, {1, rate_}, {1, 1'000'000'000})};
    any_ = true;
    samples_ += decoded_->nb_samples;
    return block;
  }

 private:
  // What the file, its sound track or any other track of it says.
  std::string_view tag(const char* key) const {
    AVFormatContext& format = input_->format();
    const AVDictionaryEntry* found = av_dict_get(format.metadata, key, nullptr, 0);
    if (!found) found = av_dict_get(stream_->metadata, key, nullptr, 0);
    for (unsigned i = 0; !found && i < format.nb_streams; ++i)
      found = av_dict_get(format.streams[i]->metadata, key, nullptr, 0);
    return found ? std::string_view(found->value) : std::string_view();
  }

  // Samples that a header states by itself, and that libav does not make up from the file's size.
  std::int64_t stated_samples() const {
    const bool flac = std::string_view(input_->format().iformat->name) == "flac";
    if (!flac || stream_->duration == AV_NOPTS_VALUE) return 0;
    return av_rescale_q(stream_->duration, stream_->time_base, {1, rate_});
  }

  Unexpected bad(const std::string& what) const {
    return fail(ErrorCode::BadData, text(name_, ": its sound track ", what));
  }

  Result<void> decode() {
    for (;;) {
      const int received = avcodec_receive_frame(decoder_.get(), decoded_.get());
      if (received >= 0 && decoded_->nb_samples > 0) return {};
      if (received >= 0) continue;
      if (received == AVERROR_EOF && !any_) return bad("holds no sound at all");
      if (received == AVERROR_EOF && samples_ < stated_samples())
        return bad(text("is cut off: ", stated_samples(), " samples are stated, ", samples_,
                        " are there; copy the file from its recorder again"));
      if (received == AVERROR_EOF) return fail(ErrorCode::EndOfStream, text(name_, " has no more sound"));
      if (received != AVERROR(EAGAIN) || drained_) return bad(text("is damaged: ", libav::reason(received)));
      const int read = av_read_frame(&input_->format(), packet_.get());
      if (read >= 0 && packet_->stream_index != stream_->index) {
        av_packet_unref(packet_.get());
        continue;
      }
      if (read < 0 && read != AVERROR_EOF) return bad(text("is damaged: ", libav::reason(read)));
      drained_ = read < 0;
      const int sent = avcodec_send_packet(decoder_.get(), drained_ ? nullptr : packet_.get());
      av_packet_unref(packet_.get());
      if (sent < 0 && sent != AVERROR_EOF) return bad(text("is damaged: ", libav::reason(sent)));
    }
  }

  const std::string name_;
  const std::unique_ptr<libav::Input> input_;
  const AVStream* const stream_;
  libav::Owned<AVCodecContext> decoder_;
  libav::Owned<AVFrame> decoded_ = libav::new_frame();
  libav::Owned<AVPacket> packet_ = libav::new_packet();
  int rate_ = 0, channels_ = 0, bits_ = 16;
  Nanoseconds time_{0};
  std::int64_t samples_ = 0;
  bool drained_ = false, any_ = false;
};

}  // namespace

Result<std::unique_ptr<MediaSound>> MediaSound::open(const std::filesystem::path& file) {
  const WorkingOn here(file);
  if (Result<void> ok = check_wav_length(file); !ok) return forward(ok);
  Result<std::unique_ptr<libav::Input>> input = libav::Input::open(file);
  if (!input) return forward(input);
  AVFormatContext& format = (*input)->format();
  int stream = av_find_best_stream(&format, AVMEDIA_TYPE_AUDIO, -1, -1, nullptr, 0);
  // One without a rate or channels is not among the best, and is not nothing.
  for (unsigned i = 0; stream < 0 && i < format.nb_streams; ++i)
    if (format.streams[i]->codecpar->codec_type == AVMEDIA_TYPE_AUDIO) stream = static_cast<int>(i);
  if (stream < 0) return std::unique_ptr<MediaSound>();
  auto sound = std::make_unique<LibavSound>(file.string(), std::move(*input), stream);
  if (Result<void> ok = sound->open(); !ok) return forward(ok);
  return std::unique_ptr<MediaSound>(std::move(sound));
}

}  // namespace floatstage::capture
