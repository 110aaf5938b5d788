#include "capture/libav.h"

#include <algorithm>
#include <cerrno>

#include "core/check.h"

namespace floatstage::capture::libav {

void FormatDeleter::operator()(AVFormatContext* format) const {
  if (format->iformat) {
    avformat_close_input(&format);
    return;
  }
  if (format->pb) avio_closep(&format->pb);
  avformat_free_context(format);
}

Owned<AVFrame> new_frame() {
  Owned<AVFrame> frame(av_frame_alloc());
  FLOATSTAGE_CHECK(frame != nullptr, "out of memory");
  return frame;
}

Owned<AVPacket> new_packet() {
  Owned<AVPacket> packet(av_packet_alloc());
  FLOATSTAGE_CHECK(packet != nullptr, "out of memory");
  return packet;
}

std::string reason(int error) {
  char buffer[AV_ERROR_MAX_STRING_SIZE] = {};
  av_strerror(error, buffer, sizeof buffer);
  return buffer;
}

ErrorCode code_of(int error) {
  switch (AVUNERROR(error)) {
    case ENOENT:
      return ErrorCode::NotFound;
    case ENOSPC:
    case EFBIG:
    case EDQUOT:
    case EIO:
    case EACCES:
    case EPERM:
    case EROFS:
    case EISDIR:
    case EMFILE:
      return ErrorCode::Io;
    default:
      return ErrorCode::BadData;
  }
}

std::string file_url(const std::filesystem::path& file) { return "file:" + file.string(); }

bool is_matroska(const std::filesystem::path& film) { return film.extension() == ".mkv"; }
const char* muxer_of(const std::filesystem::path& film) {
  return is_matroska(film) ? "matroska" : film.extension() == ".mov" ? "mov" : "mp4";
}

Format new_muxer(const char* name, const std::filesystem::path& file) {
  AVFormatContext* made = nullptr;
  FLOATSTAGE_CHECK(avformat_alloc_output_context2(&made, nullptr, name, file_url(file).c_str()) >= 0,
                   "libavformat without MP4, MOV and Matroska");
  made->flags |= AVFMT_FLAG_BITEXACT;
  return Format(made);
}

int finish_file(AVFormatContext& muxer) {
  int error = av_write_trailer(&muxer);
  if (error >= 0) error = muxer.pb->error;
  const int closed = avio_closep(&muxer.pb);
  return error >= 0 ? closed : error;
}

void be_quiet() {
  if (av_log_get_level() != AV_LOG_QUIET) av_log_set_level(AV_LOG_QUIET);
}

const std::uint8_t* RoomyCopy::of(const std::uint8_t* bytes, std::size_t size) {
  copy_.resize(size + AV_INPUT_BUFFER_PADDING_SIZE);  // 0 behind, from the first time on
  std::copy_n(bytes, size, copy_.begin());
  return copy_.data();
}

void set_bt709(SwsContext* scaler, bool source_full_range, bool target_full_range) {
  const int* bt709 = sws_getCoefficients(SWS_CS_ITU709);
  sws_setColorspaceDetails(scaler, bt709, source_full_range, bt709, target_full_range, 0, 1 << 16, 1 << 16);
}

}  // namespace floatstage::capture::libav
