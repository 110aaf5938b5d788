extern "C" {
#include <libavutil/display.h>
#include <libavutil/pixdesc.h>
}

#include "capture/media_file.h"
#include "capture/media_input.h"
#include "capture/picture_turn.h"
#include "core/text.h"
#include "core/working_on.h"

namespace floatstage::capture {
namespace {

/// Brings whatever a decoder returns to packed 8-bit RGB.
class ToRgb {
 public:
  Result<Image> convert(const AVFrame& picture);

 private:
  libav::Owned<SwsContext> scaler_;
  int width_ = 0, height_ = 0, format_ = -1;
};

// 16-bit RGB goes by its upper bytes: libswscale would dither, and pictures used for measuring must not be.
bool is_rgb48(int format) {
  return format == AV_PIX_FMT_RGB48BE || format == AV_PIX_FMT_RGB48LE || format == AV_PIX_FMT_RGBA64BE ||
         format == AV_PIX_FMT_RGBA64LE;
}
bool is_gray16(int format) {
  return format == AV_PIX_FMT_GRAY16BE || format == AV_PIX_FMT_GRAY16LE || format == AV_PIX_FMT_YA16BE ||
         format == AV_PIX_FMT_YA16LE;
}

Image from_16_bits(const AVFrame& picture) {
  const AVPixFmtDescriptor* description = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(picture.format));
  const bool gray = description->nb_components <= 2;
  const std::size_t high = (description->flags & AV_PIX_FMT_FLAG_BE) ? 0 : 1;
  const auto step = static_cast<std::size_t>(description->comp[0].step);
  Image out(picture.width, picture.height, 3);
  for (int y = 0; y < picture.height; ++y) {
    const std::uint8_t* row = picture.data[0] + static_cast<std::ptrdiff_t>(y) * picture.linesize[0];
    for (int x = 0; x < picture.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const std::uint8_t* sample =
            row + static_cast<std::size_t>(x) * step + (gray ? 0u : static_cast<std::size_t>(2 * c));
        // 65535 / 257 = 255, rounded to the nearest.
        const unsigned value = static_cast<unsigned>(sample[high]) << 8 | sample[1 - high];
        out.at(x, y)[c] = static_cast<std::uint8_t>((value + 128) / 257);
      }
  }
  return out;
}

Result<Image> ToRgb::convert(const AVFrame& picture) {
  if (is_rgb48(picture.format) || is_gray16(picture.format)) return from_16_bits(picture);
  const auto format = static_cast<AVPixelFormat>(picture.format);
  const AVPixFmtDescriptor* description = av_pix_fmt_desc_get(format);
  if (!description) return fail(ErrorCode::Unsupported, "an unknown pixel format");
  if (!scaler_ || picture.width != width_ || picture.height != height_ || picture.format != format_) {
    constexpr int kExact = SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP | SWS_BILINEAR;
    scaler_.reset(sws_getContext(picture.width, picture.height, format, picture.width, picture.height,
                                 AV_PIX_FMT_RGB24, kExact, nullptr, nullptr, nullptr));
    if (!scaler_)
      return fail(ErrorCode::Unsupported, text("no conversion from ", description->name, " to RGB"));
    width_ = picture.width;
    height_ = picture.height;
    format_ = picture.format;
  }
  // JPEG is BT.601 and full range; video says what it is, or is guessed by its size as players do.
  const bool jpeg_format = format == AV_PIX_FMT_YUVJ420P || format == AV_PIX_FMT_YUVJ422P ||
                           format == AV_PIX_FMT_YUVJ444P || format == AV_PIX_FMT_YUVJ440P ||
                           format == AV_PIX_FMT_YUVJ411P;
  const bool full_range = jpeg_format || picture.color_range == AVCOL_RANGE_JPEG;
  const bool unspecified = picture.colorspace == AVCOL_SPC_UNSPECIFIED || picture.colorspace == AVCOL_SPC_RGB;
  const bool bt709 =
      picture.colorspace == AVCOL_SPC_BT709 || (unspecified && !full_range && picture.height >= 720);
  const bool bt2020 = picture.colorspace == AVCOL_SPC_BT2020_NCL;
  const int* matrix = sws_getCoefficients(bt2020 ? SWS_CS_BT2020 : bt709 ? SWS_CS_ITU709 : SWS_CS_ITU601);
  const bool yuv =
      !(description->flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL)) && description->nb_components >= 3;
  if (yuv) sws_setColorspaceDetails(scaler_.get(), matrix, full_range, matrix, 1, 0, 1 << 16, 1 << 16);
  Image out(picture.width, picture.height, 3);
  std::uint8_t* planes[4] = {out.pixels.data(), nullptr, nullptr, nullptr};
  const int strides[4] = {3 * picture.width, 0, 0, 0};
  if (sws_scale(scaler_.get(), picture.data, picture.linesize, 0, picture.height, planes, strides) !=
      picture.height)
    return fail(ErrorCode::BadData, "the picture could not be converted to RGB");
  return out;
}

class LibavReader final : public MediaReader {
 public:
  LibavReader(std::string name, std::unique_ptr<libav::Input> input)
      : name_(std::move(name)), input_(std::move(input)) {}

  Result<void> open();
  double frame_rate() const override { return frame_rate_; }
  std::optional<Nanoseconds> time() const override { return time_; }
  Result<Image> next() override;

 private:
  Result<void> decode();
  Unexpected bad(const std::string& what) const {
    return fail(ErrorCode::BadData, text(name_, ": picture ", pictures_, ": ", what));
  }
  std::optional<PictureTurn> turn() const;

  const std::string name_;
  const std::unique_ptr<libav::Input> input_;
  libav::Owned<AVCodecContext> decoder_;
  libav::Owned<AVFrame> picture_ = libav::new_frame();
  libav::Owned<AVPacket> packet_ = libav::new_packet();
  const AVStream* stream_ = nullptr;
  ToRgb to_rgb_;
  double frame_rate_ = 0;
  std::int64_t pictures_ = 0;
  std::optional<Nanoseconds> time_;
  bool drained_ = false;
};

Result<void> LibavReader::open() {
  AVFormatContext& format = input_->format();
  const AVCodec* codec = nullptr;
  const int index = av_find_best_stream(&format, AVMEDIA_TYPE_VIDEO, -1, -1, &codec, 0);
  if (index < 0 || !codec)
    return fail(ErrorCode::BadData, text(name_, " holds no picture that can be decoded"));
  stream_ = format.streams[index];
  decoder_.reset(avcodec_alloc_context3(codec));
  FLOATSTAGE_CHECK(decoder_ != nullptr, "out of memory");
  int error = avcodec_parameters_to_context(decoder_.get(), stream_->codecpar);
  decoder_->max_pixels = input_->most_pixels();
  decoder_->pkt_timebase = stream_->time_base;
  if (error >= 0) error = avcodec_open2(decoder_.get(), codec, nullptr);
  if (error < 0) return fail(ErrorCode::BadData, text(name_, " cannot be decoded: ", libav::reason(error)));
  if (!input_->is_still()) frame_rate_ = av_q2d(av_guess_frame_rate(&format, format.streams[index], nullptr));
  return {};
}

// The next decoded picture, in picture_.
Result<void> LibavReader::decode() {
  for (;;) {
    const int received = avcodec_receive_frame(decoder_.get(), picture_.get());
    if (received >= 0) {
      if (picture_->decode_error_flags != 0 || (picture_->flags & AV_FRAME_FLAG_CORRUPT))
        return bad("damaged or cut off");
      return {};
    }
    if (received == AVERROR_EOF)
      return fail(ErrorCode::EndOfStream, text(name_, " has ", pictures_, " pictures"));
    if (received != AVERROR(EAGAIN)) return bad(libav::reason(received));
    if (drained_) return bad("the decoder stopped");
    const int read = av_read_frame(&input_->format(), packet_.get());
    if (read >= 0 && packet_->stream_index != stream_->index) {
      av_packet_unref(packet_.get());
      continue;
    }
    if (read < 0 && read != AVERROR_EOF) return bad(libav::reason(read));
    drained_ = read < 0;
    const int sent = avcodec_send_packet(decoder_.get(), drained_ ? nullptr : packet_.get());
    av_packet_unref(packet_.get());
    if (sent < 0) return bad(libav::reason(sent));
  }
}

std::optional<PictureTurn> LibavReader::turn() const {
  const AVFrameSideData* on_frame = av_frame_get_side_data(picture_.get(), AV_FRAME_DATA_DISPLAYMATRIX);
  if (on_frame && on_frame->size >= 9 * sizeof(std::int32_t))
    return turn_of(reinterpret_cast<const std::int32_t*>(on_frame->data));
  std::size_t size = 0;
  const std::uint8_t* on_stream = av_stream_get_side_data(stream_, AV_PKT_DATA_DISPLAYMATRIX, &size);
  if (on_stream && size >= 9 * sizeof(std::int32_t))
    return turn_of(reinterpret_cast<const std::int32_t*>(on_stream));
  return std::nullopt;
}

Result<Image> LibavReader::next() {
  const WorkingOn here(name_);
  if (Result<void> ok = decode(); !ok) return forward(ok);
  Result<Image> image = to_rgb_.convert(*picture_);
  if (!image)
    return fail(image.error().code, text(name_, ": picture ", pictures_, ": ", image.error().message));
  ++pictures_;
  time_.reset();
  if (const std::int64_t shown = picture_->best_effort_timestamp; shown != AV_NOPTS_VALUE)
    time_ = Nanoseconds{av_rescale_q(shown, stream_->time_base, {1, 1'000'000'000})};
  const std::optional<PictureTurn> turn_by = turn();
  if (turn_by && *turn_by != PictureTurn{}) return turned(*image, *turn_by);
  return image;
}

}  // namespace

Result<std::unique_ptr<MediaReader>> MediaReader::open(const std::filesystem::path& file) {
  const WorkingOn here(file);
  Result<std::unique_ptr<libav::Input>> input = libav::Input::open(file);
  if (!input) return forward(input);
  auto reader = std::make_unique<LibavReader>(file.string(), std::move(*input));
  if (Result<void> ok = reader->open(); !ok) return forward(ok);
  return {std::move(reader)};
}

}  // namespace floatstage::capture
