#include "capture/sound/sound_writer.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <deque>

#include <fcntl.h>
#include <unistd.h>

#include "capture/libav.h"
#include "core/file_descriptor.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;

/// FLAC blocks in Matroska, a cluster each.
class FlacFile {
 public:
  FlacFile(fs::path file, const SoundTrack& track) : file_(std::move(file)), track_(track) {}

  Result<void> open() {
    if (Result<void> ok = open_encoder(); !ok) return ok;
    muxer_ = libav::new_muxer("matroska", file_);
    stream_ = avformat_new_stream(muxer_.get(), nullptr);
    FLOATSTAGE_CHECK(
        stream_ != nullptr && avcodec_parameters_from_context(stream_->codecpar, encoder_.get()) >= 0,
        "out of memory");
    stream_->time_base = {1, 1000};
    av_dict_set(&muxer_->metadata, "title", track_.name.c_str(), 0);
    // Whoever put a file there keeps it.
    const FileDescriptor ours(::open(file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
    if (ours.get() < 0)
      return fail(ErrorCode::Io, text("cannot create ", file_.string(), ": ", std::strerror(errno)));
    if (const int error = avio_open(&muxer_->pb, muxer_->url, AVIO_FLAG_WRITE); error < 0)
      return io_failure(error);
    libav::Options options;
    options.set("write_crc32", "0");  // FLAC has checksums of its own
    if (const int error = avformat_write_header(muxer_.get(), options.get()); error < 0)
      return io_failure(error);
    avio_flush(muxer_->pb);
    if (muxer_->pb->error < 0) return io_failure(muxer_->pb->error);
    return {};
  }

  // One block: kSoundBlock samples, fewer only at the end.
  Result<void> write(std::span<const float> samples) {
    const auto channels = static_cast<std::size_t>(track_.channels);
    av_frame_unref(block_.get());
    block_->format = encoder_->sample_fmt;
    block_->nb_samples = static_cast<int>(samples.size() / channels);
    block_->sample_rate = track_.rate;
    FLOATSTAGE_CHECK(av_channel_layout_copy(&block_->ch_layout, &encoder_->ch_layout) >= 0 &&
                         av_frame_get_buffer(block_.get(), 0) >= 0,
                     "out of memory");
    const int unused = 32 - track_.bits;
    const double full = std::ldexp(1.0, track_.bits - 1);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double wanted = std::isfinite(samples[i]) ? std::round(samples[i] * full) : 0;
      const auto level = static_cast<std::int32_t>(std::clamp(wanted, -full, full - 1));
      if (track_.bits == 16)
        reinterpret_cast<std::int16_t*>(block_->data[0])[i] = static_cast<std::int16_t>(level);
      else
        reinterpret_cast<std::int32_t*>(block_->data[0])[i] =
            static_cast<std::int32_t>(static_cast<std::uint32_t>(level) << unused);
    }
    block_->pts = samples_;
    samples_ += block_->nb_samples;
    return code(block_.get());
  }

  Result<void> finish() {
    if (Result<void> ok = code(nullptr); !ok) return ok;
    if (const int error = libav::finish_file(*muxer_); error < 0) return io_failure(error);
    return {};
  }

 private:
  Result<void> open_encoder() {
    const AVCodec* encoder = avcodec_find_encoder(AV_CODEC_ID_FLAC);
    if (!encoder) return fail(ErrorCode::Unsupported, "this libavcodec has no FLAC encoder");
    encoder_.reset(avcodec_alloc_context3(encoder));
    FLOATSTAGE_CHECK(encoder_ != nullptr, "out of memory");
    encoder_->sample_rate = track_.rate;
    encoder_->time_base = {1, track_.rate};
    encoder_->sample_fmt = track_.bits == 16 ? AV_SAMPLE_FMT_S16 : AV_SAMPLE_FMT_S32;
    encoder_->bits_per_raw_sample = track_.bits;
    encoder_->frame_size = kSoundBlock;
    encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
    av_channel_layout_default(&encoder_->ch_layout, track_.channels);
    if (const int error = avcodec_open2(encoder_.get(), encoder, nullptr); error < 0)
      return fail(ErrorCode::Unsupported,
                  text(file_.string(), ": FLAC refuses ", track_.channels, " channels of ", track_.rate,
                       " samples a second (", libav::reason(error), ")"));
    FLOATSTAGE_CHECK(encoder_->frame_size == kSoundBlock, "FLAC blocks of another size");
    return {};
  }

  Result<void> code(const AVFrame* block) {
    int error = avcodec_send_frame(encoder_.get(), block);
    while (error >= 0) {
      error = avcodec_receive_packet(encoder_.get(), packet_.get());
      if (error == AVERROR(EAGAIN) || error == AVERROR_EOF) return {};
      if (error < 0) break;
      packet_->stream_index = 0;
      av_packet_rescale_ts(packet_.get(), encoder_->time_base, stream_->time_base);
      // The second call ends the cluster: the block is whole in the file.
      error = av_write_frame(muxer_.get(), packet_.get());
      if (error >= 0) error = av_write_frame(muxer_.get(), nullptr);
      if (error >= 0) avio_flush(muxer_->pb);
      if (error >= 0) error = muxer_->pb->error;
      av_packet_unref(packet_.get());
    }
    return io_failure(error);
  }

  Unexpected io_failure(int error) const {
    return fail(ErrorCode::Io, text("cannot write ", file_.string(), ": ", libav::reason(error),
                                    "; the sound before it is safe"));
  }

  const fs::path file_;
  const SoundTrack track_;
  libav::Owned<AVCodecContext> encoder_;
  libav::Owned<AVFrame> block_ = libav::new_frame();
  libav::Owned<AVPacket> packet_ = libav::new_packet();
  libav::Format muxer_;
  AVStream* stream_ = nullptr;
  std::int64_t samples_ = 0;
};

class TrackOfSound final : public SoundWriter {
 public:
  TrackOfSound(const TakeLayout& take, const SoundTrack& track)
      : track_(track),
        side_file_(take.folder() / track.side_file()),
        media_(take.folder() / track.media(), track) {}

  Result<void> open() {
    fd_ =
        FileDescriptor(::open(side_file_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644));
    if (fd_.get() < 0)
      return fail(ErrorCode::Io, text("cannot create ", side_file_.string(), ": ", std::strerror(errno)));
    if (Result<void> ok = append(sound_csv_header()); !ok) return ok;
    return media_.open();
  }

  Result<void> stamp(std::int64_t sample, Timestamp time, bool new_run) override {
    const bool first = last_.sample < 0;
    const bool follows = first || (sample > last_.sample && (new_run || time > last_.time));
    if (!follows || sample < 0) return {};
    last_ = {sample, time, first ? 0 : last_.run + (new_run ? 1 : 0)};
    waiting_.push_back(last_);
    return put_stamps();
  }

  Result<void> write(std::span<const float> interleaved) override {
    const auto channels = static_cast<std::size_t>(track_.channels);
    FLOATSTAGE_CHECK(interleaved.size() % channels == 0, "a sample of some channels");
    samples_ += static_cast<std::int64_t>(interleaved.size() / channels);
    const std::size_t block = channels * kSoundBlock;
    while (!interleaved.empty()) {
      const std::size_t some = std::min(block - pending_.size(), interleaved.size());
      pending_.insert(pending_.end(), interleaved.begin(),
                      interleaved.begin() + static_cast<std::ptrdiff_t>(some));
      interleaved = interleaved.subspan(some);
      if (pending_.size() == block)
        if (Result<void> ok = put_block(); !ok) return ok;
    }
    return {};
  }

  std::int64_t samples() const override { return samples_; }

  Result<void> finish() override {
    if (!pending_.empty())
      if (Result<void> ok = put_block(); !ok) return ok;
    if (Result<void> ok = media_.finish(); !ok) return ok;
    stored_ = coded_;
    return put_stamps();
  }

 private:
  Result<void> put_block() {
    if (Result<void> ok = media_.write(pending_); !ok) return ok;
    stored_ = coded_;  // libav's Matroska keeps the last block back until the next one comes
    coded_ += static_cast<std::int64_t>(pending_.size()) / track_.channels;
    pending_.clear();
    return put_stamps();
  }

  // Of samples that are in the file.
  Result<void> put_stamps() {
    for (; !waiting_.empty() && waiting_.front().sample < stored_; waiting_.pop_front())
      if (Result<void> ok = append(to_csv(waiting_.front())); !ok) return ok;
    return {};
  }

  Result<void> append(const std::string& line) {
    for (std::size_t done = 0; done < line.size();) {
      const ssize_t n = ::write(fd_.get(), line.data() + done, line.size() - done);
      if (n < 0 && errno == EINTR) continue;
      if (n < 0)
        return fail(ErrorCode::Io, text("cannot write ", side_file_.string(), ": ", std::strerror(errno),
                                        "; the rows before it are safe"));
      done += static_cast<std::size_t>(n);
    }
    return {};
  }

  const SoundTrack track_;
  const fs::path side_file_;
  FileDescriptor fd_;
  FlacFile media_;
  std::vector<float> pending_;  // less than a block
  std::int64_t samples_ = 0, coded_ = 0, stored_ = 0;
  SoundStamp last_{-1, {}, 0};
  std::deque<SoundStamp> waiting_;
};

}  // namespace

Result<std::unique_ptr<SoundWriter>> SoundWriter::create(const TakeLayout& take, const SoundTrack& track) {
  libav::be_quiet();
  if (Result<void> ok = check(track); !ok) return forward(ok);
  auto writer = std::make_unique<TrackOfSound>(take, track);
  if (Result<void> ok = writer->open(); !ok) return forward(ok);
  return std::unique_ptr<SoundWriter>(std::move(writer));
}

}  // namespace floatstage::capture
