#include "capture/track_reader.h"

extern "C" {
#include <libavutil/imgutils.h>
}

#include <cerrno>
#include <cstring>
#include <mutex>

#include <unistd.h>

#include "capture/ffv1_slices.h"
#include "capture/libav.h"
#include "capture/matroska_index.h"
#include "capture/picture_packing.h"
#include "capture/take_codec.h"
#include "core/file_descriptor.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

AVCodecID codec_id(TakeCodec codec) {
  switch (codec) {
    case TakeCodec::Ffv1:
      return AV_CODEC_ID_FFV1;
    case TakeCodec::Raw:
      return AV_CODEC_ID_RAWVIDEO;
    case TakeCodec::H264:
      return AV_CODEC_ID_H264;
  }
  return AV_CODEC_ID_NONE;
}

/// libav reads the header (what is the codec, and its private data); we find and fetch the pictures
/// ourselves.
class MatroskaTrack final : public TrackReader {
 public:
  MatroskaTrack(const std::filesystem::path& file, TakeCodec codec, PicturePacking packing)
      : name_(file.string()), codec_(codec), packing_(std::move(packing)) {}

  Result<void> open(const TakeManifest::Camera& camera);
  std::int64_t pictures() const override { return static_cast<std::int64_t>(index_.pictures.size()); }
  bool cut() const override { return index_.cut; }
  const ImageLayout& layout() const override { return packing_.layout(); }
  Result<std::shared_ptr<const std::byte[]>> picture(std::int64_t index) override;
  Result<std::shared_ptr<const std::byte[]>> part(std::int64_t index,
                                                  std::span<const PixelBox> boxes) override;

 private:
  Result<void> read_header(const TakeManifest::Camera& camera);
  Result<void> fetch(std::int64_t index);
  Result<void> decode_up_to(std::int64_t index);
  Result<void> decode_one(std::int64_t index, bool is_wanted);
  int decode_packet();
  Result<bool> decode_slices(std::int64_t index, std::span<const PixelBox> boxes);
  void forget();
  Unexpected bad(const std::string& what) const { return fail(ErrorCode::BadData, text(name_, ": ", what)); }
  Unexpected damaged(std::int64_t index, const std::string& why) const {
    return bad(text("picture ", index, " is damaged (", why, ")"));
  }

  const std::string name_;
  FileDescriptor file_;
  const TakeCodec codec_;
  const PicturePacking packing_;
  MatroskaIndex index_;

  std::mutex mutex_;  // guards everything below
  libav::Owned<AVCodecContext> decoder_;
  std::optional<Ffv1Slices> slices_;  // of FFV1
  libav::Owned<AVFrame> decoded_ = libav::new_frame();
  libav::Owned<AVPacket> packet_ = libav::new_packet();
  std::int64_t decoder_at_ = -1;  // the picture that the decoder saw last; -1: none since a flush
  std::int64_t cached_index_ = -1;
  std::shared_ptr<const std::byte[]> cached_;
};

Result<void> MatroskaTrack::read_header(const TakeManifest::Camera& camera) {
  AVFormatContext* opened = nullptr;
  libav::Options options;
  options.set("protocol_whitelist", "file");
  const AVInputFormat* matroska = av_find_input_format("matroska");
  if (const int error = avformat_open_input(&opened, libav::file_url(name_).c_str(), matroska, options.get());
      error < 0)
    return bad(text("the header is not that of a Matroska file (", libav::reason(error),
                    "); the file is cut, damaged, or not of this take"));
  const libav::Format format(opened);
  const AVDictionaryEntry* title = av_dict_get(format->metadata, "title", nullptr, 0);
  if (title && camera.serial != title->value)
    return bad(text("this file was recorded by camera '", title->value, "', not '", camera.serial,
                    "'; were the files renamed?"));
  if (format->nb_streams < 1 || format->streams[0]->codecpar->codec_type != AVMEDIA_TYPE_VIDEO)
    return bad("no video track");
  const AVCodecParameters& track = *format->streams[0]->codecpar;
  if (track.codec_id != codec_id(codec_))
    return bad(text("coded as ", avcodec_get_name(track.codec_id), ", but take.json says ", camera.codec));
  if (track.width != camera.width || track.height != camera.height)
    return bad(text("pictures of ", track.width, "x", track.height, ", but take.json says ", camera.width,
                    "x", camera.height));
  if (codec_ == TakeCodec::Raw) return {};

  const AVCodec* found = avcodec_find_decoder(track.codec_id);
  if (!found)
    return fail(ErrorCode::Unsupported, text(name_, ": this libavcodec has no ", camera.codec, " decoder"));
  decoder_.reset(avcodec_alloc_context3(found));
  FLOATSTAGE_CHECK(decoder_ != nullptr, "out of memory");
  if (avcodec_parameters_to_context(decoder_.get(), &track) < 0)
    return bad("the codec's private data make no sense");
  decoder_->thread_count = 1;  // cameras are decoded side by side instead
  decoder_->flags |= AV_CODEC_FLAG_LOW_DELAY;
  decoder_->max_pixels = std::int64_t{camera.width + 64} * (camera.height + 64);
  if (const int error = avcodec_open2(decoder_.get(), found, nullptr); error < 0)
    return bad(text("the codec's private data make no sense (", libav::reason(error), ")"));
  if (codec_ == TakeCodec::Ffv1 && track.extradata_size > 0)
    slices_ = Ffv1Slices::of({track.extradata, static_cast<std::size_t>(track.extradata_size)}, camera.width,
                             camera.height);
  return {};
}

Result<void> MatroskaTrack::open(const TakeManifest::Camera& camera) {
  Result<FileDescriptor> opened = open_to_read(name_);
  if (!opened && opened.error().code == ErrorCode::NotFound)
    return fail(ErrorCode::NotFound, text(name_, " is missing: camera '", camera.serial,
                                          "' has rows with pictures; put the file back under this name"));
  if (!opened) return forward(opened);
  file_ = std::move(*opened);
  if (Result<void> ok = read_header(camera); !ok) return ok;
  Result<MatroskaIndex> index = index_matroska(file_.get());
  if (!index) return fail(index.error().code, text(name_, ": ", index.error().message));
  index_ = std::move(*index);
  return {};
}

Result<void> MatroskaTrack::fetch(std::int64_t index) {
  const MatroskaIndex::Picture& where = index_.pictures[static_cast<std::size_t>(index)];
  av_packet_unref(packet_.get());
  if (where.size <= 0 || where.size > INT32_MAX / 2) return damaged(index, "empty");
  FLOATSTAGE_CHECK(av_new_packet(packet_.get(), static_cast<int>(where.size)) == 0, "out of memory");
  for (std::int64_t done = 0; done < where.size;) {
    const ssize_t n = ::pread(file_.get(), packet_->data + done, static_cast<std::size_t>(where.size - done),
                              where.offset + done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return fail(ErrorCode::Io, text("cannot read ", name_, ": ", std::strerror(errno)));
    if (n == 0)
      return fail(ErrorCode::Io,
                  text(name_, ": it became shorter while it was open; is its disk still there?"));
    done += n;
  }
  packet_->pts = packet_->dts = index;
  if (where.keyframe) packet_->flags |= AV_PKT_FLAG_KEY;
  return {};
}

// libav's error, negative, or 0.
int MatroskaTrack::decode_packet() {
  av_frame_unref(decoded_.get());
  const int error = avcodec_send_packet(decoder_.get(), packet_.get());
  return error < 0 ? error : std::min(0, avcodec_receive_frame(decoder_.get(), decoded_.get()));
}

// Whatever the decoder remembers must not colour another picture: it starts afresh from a key picture.
void MatroskaTrack::forget() {
  if (decoder_) avcodec_flush_buffers(decoder_.get());
  decoder_at_ = -1;
}

Result<void> MatroskaTrack::decode_one(std::int64_t index, bool is_wanted) {
  if (Result<void> ok = fetch(index); !ok) return ok;
  if (codec_ == TakeCodec::Raw) {
    av_frame_unref(decoded_.get());
    const ImageLayout& l = packing_.layout();
    if (packet_->size != av_image_get_buffer_size(packing_.pixel_format(), l.width, l.height, 1))
      return damaged(index, text(packet_->size, " bytes"));
    decoded_->format = packing_.pixel_format();
    decoded_->width = l.width;
    decoded_->height = l.height;
    av_image_fill_arrays(decoded_->data, decoded_->linesize, packet_->data, packing_.pixel_format(), l.width,
                         l.height, 1);
    return {};
  }
  if (codec_ == TakeCodec::Ffv1 && !ffv1_intact({packet_->data, static_cast<std::size_t>(packet_->size)}))
    return damaged(index, "a slice's checksum is wrong");
  if (const int error = decode_packet(); error < 0) return damaged(index, libav::reason(error));
  if (decoded_->decode_error_flags != 0 || (decoded_->flags & AV_FRAME_FLAG_CORRUPT) != 0)
    return damaged(index, "the decoder had to guess");
  if (is_wanted && decoded_->pts != index) return damaged(index, "the decoder returned another picture");
  return {};
}

// H.264 pictures need those before them back to a key picture; the others stand alone.
Result<void> MatroskaTrack::decode_up_to(std::int64_t index) {
  std::int64_t first = index;
  while (first > 0 && !index_.pictures[static_cast<std::size_t>(first)].keyframe) --first;
  const bool goes_on = decoder_at_ >= first && decoder_at_ < index;
  if (goes_on)
    first = decoder_at_ + 1;
  else if (codec_ == TakeCodec::H264)
    avcodec_flush_buffers(decoder_.get());
  for (std::int64_t i = first; i <= index; ++i) {
    if (Result<void> ok = decode_one(i, i == index); !ok) {
      forget();
      return ok;
    }
    decoder_at_ = i;
  }
  return {};
}

Result<std::shared_ptr<const std::byte[]>> MatroskaTrack::picture(std::int64_t index) {
  FLOATSTAGE_CHECK(index >= 0 && index < pictures(), text(name_, ": picture ", index, " of ", pictures()));
  const std::lock_guard lock(mutex_);
  if (index == cached_index_) return cached_;
  if (Result<void> ok = decode_up_to(index); !ok) return forward(ok);
  auto bytes = std::make_shared<std::byte[]>(packing_.layout().size_bytes);
  if (!packing_.unpack(*decoded_, bytes.get())) return damaged(index, "of another size or pixel format");
  cached_ = std::move(bytes);
  cached_index_ = index;
  return cached_;
}

// Whether decoded_ has what lies in the boxes, and nothing else that can be relied on.
Result<bool> MatroskaTrack::decode_slices(std::int64_t index, std::span<const PixelBox> boxes) {
  if (!slices_ || !index_.pictures[static_cast<std::size_t>(index)].keyframe) return false;
  if (Result<void> ok = fetch(index); !ok) return forward(ok);
  const std::size_t size = slices_->keep({packet_->data, static_cast<std::size_t>(packet_->size)}, boxes);
  if (size == 0) return false;
  av_shrink_packet(packet_.get(), static_cast<int>(size));
  const bool is_there = decode_packet() == 0 && decoded_->pts == index;
  forget();
  return is_there;
}

Result<std::shared_ptr<const std::byte[]>> MatroskaTrack::part(std::int64_t index,
                                                               std::span<const PixelBox> boxes) {
  FLOATSTAGE_CHECK(index >= 0 && index < pictures(), text(name_, ": picture ", index, " of ", pictures()));
  const std::lock_guard lock(mutex_);
  if (index == cached_index_) return std::shared_ptr<const std::byte[]>();
  const Result<bool> is_there = decode_slices(index, boxes);
  if (!is_there) return forward(is_there);
  if (!*is_there) return std::shared_ptr<const std::byte[]>();
  const PixelBox all = around(boxes);
  const ImageLayout layout = packed_layout(packing_.layout().format, all.width, all.height);
  auto bytes = std::make_shared<std::byte[]>(layout.size_bytes);
  for (const PixelBox& box : boxes)
    if (!packing_.unpack(*decoded_, box, {bytes.get(), layout, all.x, all.y}))
      return damaged(index, "of another size or pixel format");
  return std::shared_ptr<const std::byte[]>(std::move(bytes));
}

}  // namespace

Result<std::unique_ptr<TrackReader>> TrackReader::open(const std::filesystem::path& file,
                                                       const TakeManifest::Camera& camera) {
  libav::be_quiet();
  const std::optional<TakeCodec> codec = take_codec_named(camera.codec);
  if (!codec)
    return fail(ErrorCode::Unsupported, text(file.string(), ": unknown codec '", camera.codec, "'"));
  if (camera.width <= 0 || camera.height <= 0)
    return fail(ErrorCode::BadData, text(file.string(), ": take.json gives its pictures no size"));
  Result<PicturePacking> packing = PicturePacking::create(*codec, camera.format, camera.width, camera.height);
  if (!packing) return fail(packing.error().code, text(file.string(), ": ", packing.error().message));
  auto track = std::make_unique<MatroskaTrack>(file, *codec, std::move(*packing));
  if (Result<void> ok = track->open(camera); !ok) return forward(ok);
  return {std::move(track)};
}

}  // namespace floatstage::capture
