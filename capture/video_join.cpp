#include <cstring>
#include <optional>

#include "capture/libav.h"
#include "capture/media_file.h"
#include "capture/media_input.h"
#include "capture/sound/film_sound_track.h"
#include "core/claim.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;

// What must be the same in all parts: the decoder is set up once.
bool coded_alike(const AVCodecParameters& a, const AVCodecParameters& b) {
  return a.codec_id == b.codec_id && a.width == b.width && a.height == b.height &&
         a.extradata_size == b.extradata_size &&
         std::memcmp(a.extradata, b.extradata, static_cast<std::size_t>(a.extradata_size)) == 0;
}

// A film that takes packets as they are. Times are counted in pictures.
class Joined {
 public:
  Joined(fs::path file, double frame_rate, const FilmSound* sound)
      : file_(std::move(file)), temporary_(temporary_name(file_)), rate_(av_d2q(frame_rate, 100'000)) {
    if (sound) sound_.emplace(*sound);
  }
  ~Joined() {
    muxer_.reset();
    std::error_code ignored;
    if (claim_ && !finished_) fs::remove(temporary_, ignored);
  }

  Result<void> append(const fs::path& part) {
    Result<std::unique_ptr<libav::Input>> input = libav::Input::open(part);
    if (!input) return forward(input);
    AVFormatContext& from = (*input)->format();
    if (from.nb_streams != 1 || from.streams[0]->codecpar->codec_type != AVMEDIA_TYPE_VIDEO)
      return fail(ErrorCode::BadData, text(part.string(), " is not a film of pictures alone"));
    const AVStream& source = *from.streams[0];
    if (!muxer_)
      if (Result<void> ok = open(source); !ok) return ok;
    if (!coded_alike(*source.codecpar, *stream_->codecpar))
      return fail(ErrorCode::BadData, text(part.string(), " is coded otherwise than the part before it"));
    std::int64_t here = 0;
    for (int error = 0;; ++here) {
      error = av_read_frame(&from, packet_.get());
      if (error == AVERROR_EOF) break;
      if (error < 0)
        return fail(libav::code_of(error), text("cannot read ", part.string(), ": ", libav::reason(error)));
      if (Result<void> ok = put(part, source.time_base, here); !ok) return ok;
    }
    pictures_ += here;
    return {};
  }

  std::int64_t pictures() const { return pictures_; }

  Result<void> finish() {
    if (sound_)
      if (Result<void> ok = sound_->finish(); !ok) return ok;
    if (const int error = libav::finish_file(*muxer_); error < 0) return io_failure(error);
    if (Result<void> ok = rename_new(temporary_, file_); !ok) return forward(ok);
    finished_ = true;
    return {};
  }

 private:
  Result<void> open(const AVStream& like) {
    Result<Claim> claim = claim_temporary_file(file_);
    if (!claim) return forward(claim);
    claim_ = std::move(*claim);
    muxer_ = libav::new_muxer(libav::muxer_of(file_), temporary_);
    if (libav::is_matroska(file_)) muxer_->avoid_negative_ts = 0;  // its times are when pictures are shown
    stream_ = avformat_new_stream(muxer_.get(), nullptr);
    FLOATSTAGE_CHECK(stream_ != nullptr && avcodec_parameters_copy(stream_->codecpar, like.codecpar) >= 0,
                     "out of memory");
    stream_->time_base = av_inv_q(rate_);
    stream_->avg_frame_rate = rate_;
    if (sound_)
      if (Result<void> ok = sound_->open(*muxer_, file_); !ok) return ok;
    int error = avio_open(&muxer_->pb, muxer_->url, AVIO_FLAG_WRITE);
    if (error < 0) return io_failure(error);
    libav::Options options;
    if (!libav::is_matroska(file_)) options.set("movflags", "+faststart");
    error = avformat_write_header(muxer_.get(), options.get());
    if (error < 0) return io_failure(error);
    return {};
  }

  // A part's packet, the `here`-th to be decoded, is shown later by the pictures before that part. It is
  // decoded one picture after the one before, as early as the codec may need it: by its own times a part
  // whose pictures lean on later ones would begin before the end of one whose pictures do not.
  Result<void> put(const fs::path& part, AVRational time_base, std::int64_t here) {
    const AVRational picture = av_inv_q(rate_);
    const std::int64_t shown = av_rescale_q(packet_->pts, time_base, picture) + pictures_,
                       decoded = pictures_ + here - stream_->codecpar->video_delay;
    if (packet_->pts == AV_NOPTS_VALUE || shown < decoded)
      return fail(ErrorCode::BadData, text(part.string(), ": picture ", here, " would be decoded too late"));
    packet_->pts = av_rescale_q(shown, picture, stream_->time_base);
    packet_->dts = av_rescale_q(decoded, picture, stream_->time_base);
    packet_->duration = av_rescale_q(1, picture, stream_->time_base);
    packet_->pos = -1;
    packet_->stream_index = 0;
    if (sound_)
      if (Result<void> ok = sound_->write_until(static_cast<double>(decoded) * av_q2d(picture)); !ok)
        return ok;
    int error = av_interleaved_write_frame(muxer_.get(), packet_.get());
    if (error >= 0) error = muxer_->pb->error;
    if (error < 0) return io_failure(error);
    return {};
  }

  Unexpected io_failure(int error) const {
    return fail(ErrorCode::Io, text("cannot write ", file_.string(), ": ", libav::reason(error)));
  }

  const fs::path file_, temporary_;
  const AVRational rate_;
  std::optional<Claim> claim_;
  libav::Format muxer_;
  AVStream* stream_ = nullptr;
  std::optional<FilmSoundTrack> sound_;
  libav::Owned<AVPacket> packet_ = libav::new_packet();
  std::int64_t pictures_ = 0;
  bool finished_ = false;
};

}  // namespace

Result<void> join_videos(const std::vector<fs::path>& parts, double frame_rate, std::int64_t pictures,
                         const fs::path& file, const FilmSound* sound) {
  libav::be_quiet();
  if (parts.empty() || !(frame_rate > 0))
    return fail(ErrorCode::InvalidArgument, text(file.string(), ": a film of no parts, or of no frame rate"));
  Joined joined(file, frame_rate, sound);
  for (const fs::path& part : parts)
    if (Result<void> ok = joined.append(part); !ok) return ok;
  if (joined.pictures() != pictures)
    return fail(ErrorCode::BadData,
                text(file.string(), ": its parts have ", joined.pictures(), " pictures and not ", pictures));
  return joined.finish();
}

}  // namespace floatstage::capture
