#pragma once

// Private to capture/: ownership and error text for libav's C objects.

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libswscale/swscale.h>
}

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/result.h"

namespace floatstage::capture::libav {

struct Deleter {
  void operator()(AVFrame* frame) const { av_frame_free(&frame); }
  void operator()(AVPacket* packet) const { av_packet_free(&packet); }
  void operator()(AVCodecContext* codec) const { avcodec_free_context(&codec); }
  void operator()(AVCodecParameters* parameters) const { avcodec_parameters_free(&parameters); }
  void operator()(SwsContext* scaler) const { sws_freeContext(scaler); }
};
template <class T>
using Owned = std::unique_ptr<T, Deleter>;

/// A demuxer or muxer. Closes what it opened: an input with its file, an output's file without a trailer.
struct FormatDeleter {
  void operator()(AVFormatContext* format) const;
};
using Format = std::unique_ptr<AVFormatContext, FormatDeleter>;

/// Options for a codec or a muxer.
class Options {
 public:
  Options() = default;
  Options(const Options&) = delete;
  Options& operator=(const Options&) = delete;
  ~Options() { av_dict_free(&dictionary_); }
  Options& set(const char* key, const char* value) {
    av_dict_set(&dictionary_, key, value, 0);
    return *this;
  }
  AVDictionary** get() { return &dictionary_; }

 private:
  AVDictionary* dictionary_ = nullptr;
};

Owned<AVFrame> new_frame();
Owned<AVPacket> new_packet();

/// libav's sentence for one of its error numbers.
std::string reason(int error);

/// What kind of failure an error number is: BadData for libav's own verdicts, Io for the operating system's.
ErrorCode code_of(int error);

/// "file:<path>": a URL that libav cannot take for a protocol or a numbered pattern.
std::string file_url(const std::filesystem::path& file);

/// The container of a film, by the ending of its name: Matroska (.mkv), MOV (.mov), else MP4.
bool is_matroska(const std::filesystem::path& film);
const char* muxer_of(const std::filesystem::path& film);

/// A muxer of the container `name` that will write `file`, with the same bytes for the same pictures (no
/// random identifiers). The file is not open yet.
Format new_muxer(const char* name, const std::filesystem::path& file);
/// Ends the file of `muxer` with what belongs behind its packets, and closes it. libav's error, or 0 and
/// above.
int finish_file(AVFormatContext& muxer);

/// libav writes to standard error by itself; our sentences say what matters, so it is told to be quiet.
void be_quiet();

/// A copy with room behind it, kept until the next: libswscale reads a few bytes beyond the last pixel that
/// it is given, and what lies there is nobody's.
class RoomyCopy {
 public:
  const std::uint8_t* of(const std::uint8_t* bytes, std::size_t size);

 private:
  std::vector<std::uint8_t> copy_;
};

/// The colour matrix and range that a scaler assumes: RGB on one side, BT.709 on the other.
void set_bt709(SwsContext* scaler, bool source_full_range, bool target_full_range);

}  // namespace floatstage::capture::libav
