#include "capture/sound/sound_reader.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <mutex>

#include <unistd.h>

#include "capture/libav.h"
#include "capture/matroska_index.h"
#include "core/file.h"
#include "core/file_descriptor.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;

constexpr int kStreamInfoBytes = 34;  // of FLAC (RFC 9639, section 8.2)

class FlacTrack final : public SoundReader {
 public:
  FlacTrack(const TakeLayout& take, const SoundTrack& track)
      : track_(track), media_(take.folder() / track.media()), side_file_(take.folder() / track.side_file()) {}

  Result<void> open();
  const SoundTrack& track() const override { return track_; }
  std::int64_t samples() const override { return samples_; }
  const SoundClock& clock() const override { return clock_; }
  const std::vector<std::string>& warnings() const override { return warnings_; }
  Result<void> read(std::int64_t first, std::span<float> interleaved) override;
  Result<std::vector<std::string>> damage(const std::function<bool(std::uint64_t)>& go_on) override;

 private:
  Unexpected bad(const std::string& what) const {
    return fail(ErrorCode::BadData, text(media_.string(), ": ", what));
  }
  Result<void> read_header();
  Result<void> count_samples();
  Result<bool> decode(std::int64_t block);

  const SoundTrack track_;
  const fs::path media_, side_file_;
  FileDescriptor file_;
  MatroskaIndex index_;
  SoundClock clock_;
  std::vector<std::string> warnings_;
  std::int64_t samples_ = 0;
  int block_ = 0;  // samples

  std::mutex mutex_;  // guards everything below
  libav::Owned<AVCodecContext> decoder_;
  libav::Owned<AVFrame> decoded_ = libav::new_frame();
  libav::Owned<AVPacket> packet_ = libav::new_packet();
  std::int64_t cached_ = -1;   // the block in `levels_`
  std::vector<float> levels_;  // empty where it is damaged
};

Result<void> FlacTrack::read_header() {
  AVFormatContext* opened = nullptr;
  libav::Options options;
  options.set("protocol_whitelist", "file");
  if (const int error = avformat_open_input(&opened, libav::file_url(media_).c_str(),
                                            av_find_input_format("matroska"), options.get());
      error < 0)
    return bad(text("the header is not that of a Matroska file (", libav::reason(error),
                    "); the sound is cut, damaged, or not of this take"));
  const libav::Format format(opened);
  if (format->nb_streams < 1 || format->streams[0]->codecpar->codec_id != AV_CODEC_ID_FLAC)
    return bad("holds no FLAC sound; was the file exchanged?");
  const AVCodecParameters& stream = *format->streams[0]->codecpar;
  if (stream.sample_rate != track_.rate || stream.ch_layout.nb_channels != track_.channels)
    return bad(text(stream.ch_layout.nb_channels, " channels of ", stream.sample_rate,
                    " samples a second, but sound.json says ", track_.channels, " of ", track_.rate));
  if (stream.extradata_size < kStreamInfoBytes) return bad("FLAC without a header");
  // "fLaC" and a block header may stand before.
  const std::uint8_t* info = stream.extradata + (stream.extradata_size - kStreamInfoBytes);
  block_ = info[2] << 8 | info[3];
  if (block_ < 16 || (info[0] << 8 | info[1]) > block_) return bad("FLAC blocks of no size");

  decoder_.reset(avcodec_alloc_context3(avcodec_find_decoder(AV_CODEC_ID_FLAC)));
  FLOATSTAGE_CHECK(decoder_ != nullptr, "libavcodec without FLAC");
  if (avcodec_parameters_to_context(decoder_.get(), &stream) < 0) return bad("the header makes no sense");
  decoder_->thread_count = 1;
  decoder_->err_recognition = AV_EF_CRCCHECK | AV_EF_EXPLODE;
  if (const int error = avcodec_open2(decoder_.get(), decoder_->codec, nullptr); error < 0)
    return bad(text("the header makes no sense (", libav::reason(error), ")"));
  return {};
}

// All blocks have one size but the last.
Result<void> FlacTrack::count_samples() {
  const auto blocks = static_cast<std::int64_t>(index_.pictures.size());
  if (blocks == 0) return {};
  const Result<bool> whole = decode(blocks - 1);
  if (!whole) return forward(whole);
  samples_ =
      (blocks - 1) * block_ + (*whole ? static_cast<std::int64_t>(levels_.size()) / track_.channels : 0);
  return {};
}

Result<void> FlacTrack::open() {
  const Result<std::string> csv = read_file(side_file_);
  if (!csv)
    return fail(csv.error().code, text(csv.error().message, "; without it nobody knows when sound '",
                                       track_.name, "' was recorded"));
  const Result<std::vector<SoundStamp>> stamps = parse_sound_csv(*csv, side_file_.string());
  if (!stamps) return forward(stamps);
  Result<FileDescriptor> opened = open_to_read(media_);
  if (!opened)
    return fail(opened.error().code, text(opened.error().message, "; sound '", track_.name, "' is in it"));
  file_ = std::move(*opened);
  if (Result<void> ok = read_header(); !ok) return ok;
  Result<MatroskaIndex> index = index_matroska(file_.get());
  if (!index) return fail(index.error().code, text(media_.string(), ": ", index.error().message));
  index_ = std::move(*index);
  if (Result<void> ok = count_samples(); !ok) return ok;
  if (!stamps->empty() && stamps->back().sample >= samples_)
    warnings_.push_back(text(media_.string(), " ends after ", samples_, " samples; ", side_file_.string(),
                             " has times of ", stamps->back().sample, ": it plays up to there"));
  if (stamps->empty() && samples_ > 0)
    warnings_.push_back(text(side_file_.string(), " has no row: nobody knows when sound '", track_.name,
                             "' was recorded, so it is not played"));
  clock_ = SoundClock(*stamps, track_.rate, samples_);
  return {};
}

// Whether the block is as it was written; then it is in levels_.
Result<bool> FlacTrack::decode(std::int64_t block) {
  if (block == cached_) return !levels_.empty();
  cached_ = block;
  levels_.clear();
  const MatroskaIndex::Picture& where = index_.pictures[static_cast<std::size_t>(block)];
  constexpr std::int64_t kLargest = 1 << 24;
  if (where.size <= 0 || where.size > kLargest) return false;
  av_packet_unref(packet_.get());
  FLOATSTAGE_CHECK(av_new_packet(packet_.get(), static_cast<int>(where.size)) == 0, "out of memory");
  for (std::int64_t done = 0; done < where.size;) {
    const ssize_t n = ::pread(file_.get(), packet_->data + done, static_cast<std::size_t>(where.size - done),
                              where.offset + done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail(ErrorCode::Io, text("cannot read ", media_.string(), ": ", std::strerror(errno)));
    if (n == 0) return false;
    done += n;
  }
  avcodec_flush_buffers(decoder_.get());
  int error = avcodec_send_packet(decoder_.get(), packet_.get());
  if (error >= 0) error = avcodec_receive_frame(decoder_.get(), decoded_.get());
  const bool last = block + 1 == static_cast<std::int64_t>(index_.pictures.size());
  if (error < 0 || decoded_->ch_layout.nb_channels != track_.channels || decoded_->nb_samples > block_ ||
      (decoded_->nb_samples != block_ && !last) || decoded_->nb_samples < 1)
    return false;
  const auto values = static_cast<std::size_t>(decoded_->nb_samples * track_.channels);
  if (decoded_->format == AV_SAMPLE_FMT_S16) {
    const auto* from = reinterpret_cast<const std::int16_t*>(decoded_->data[0]);
    for (std::size_t i = 0; i < values; ++i) levels_.push_back(std::ldexp(static_cast<float>(from[i]), -15));
  } else if (decoded_->format == AV_SAMPLE_FMT_S32) {
    const auto* from = reinterpret_cast<const std::int32_t*>(decoded_->data[0]);
    for (std::size_t i = 0; i < values; ++i) levels_.push_back(std::ldexp(static_cast<float>(from[i]), -31));
  }
  return !levels_.empty();
}

Result<void> FlacTrack::read(std::int64_t first, std::span<float> out) {
  const std::lock_guard lock(mutex_);
  const auto channels = static_cast<std::int64_t>(track_.channels);
  const std::int64_t end = first + static_cast<std::int64_t>(out.size()) / channels;
  std::fill(out.begin(), out.end(), 0.f);
  for (std::int64_t at = std::max<std::int64_t>(first, 0); at < std::min(end, samples_);) {
    const std::int64_t block = at / block_;
    const Result<bool> whole = decode(block);
    if (!whole) return forward(whole);
    const std::int64_t stop = std::min({end, samples_, (block + 1) * block_});
    if (*whole)
      for (std::int64_t i = (at - block * block_) * channels, n = (stop - block * block_) * channels; i < n;
           ++i)
        out[static_cast<std::size_t>((block * block_ - first) * channels + i)] =
            levels_[static_cast<std::size_t>(i)];
    at = stop;
  }
  return {};
}

Result<std::vector<std::string>> FlacTrack::damage(const std::function<bool(std::uint64_t)>& go_on) {
  const std::lock_guard lock(mutex_);
  std::vector<std::string> out;
  const auto blocks = static_cast<std::int64_t>(index_.pictures.size());
  for (std::int64_t block = 0; block < blocks; ++block) {
    const std::int64_t begin = block;
    for (; block < blocks; ++block) {
      if (!go_on(static_cast<std::uint64_t>(index_.pictures[static_cast<std::size_t>(block)].size)))
        return fail(ErrorCode::Cancelled, text("interrupted in ", media_.string()));
      const Result<bool> whole = decode(block);
      if (!whole) return forward(whole);
      if (*whole) break;
    }
    if (block > begin)
      out.push_back(text(media_.string(), ": samples ", begin * block_, " to ", block * block_,
                         " are damaged: they are silent"));
  }
  return out;
}

}  // namespace

Result<std::unique_ptr<SoundReader>> SoundReader::open(const TakeLayout& take, const SoundTrack& track) {
  libav::be_quiet();
  auto reader = std::make_unique<FlacTrack>(take, track);
  if (Result<void> ok = reader->open(); !ok) return forward(ok);
  return std::unique_ptr<SoundReader>(std::move(reader));
}

}  // namespace floatstage::capture
