#pragma once

// Private to capture/: the sound of a film that is being muxed.

#include "capture/libav.h"
#include "capture/sound/film_sound.h"

namespace floatstage::capture {

/// Codes a film's sound as its container has it: AAC in MP4, PCM of 24 bits in MOV, FLAC in Matroska.
class FilmSoundTrack {
 public:
  explicit FilmSoundTrack(const FilmSound& sound) : sound_(sound) {}
  /// Adds its stream to a muxer whose header is not written yet.
  Result<void> open(AVFormatContext& muxer, const std::filesystem::path& film);
  /// Writes what is heard before `seconds` of the film, in blocks.
  Result<void> write_until(double seconds);
  Result<void> finish();

 private:
  Result<void> code(const AVFrame* block);

  const FilmSound& sound_;
  AVFormatContext* muxer_ = nullptr;
  AVStream* stream_ = nullptr;
  std::filesystem::path film_;
  int block_ = 0;  // samples that are coded at once
  std::int64_t coded_ = 0;
  libav::Owned<AVCodecContext> encoder_;
  libav::Owned<AVFrame> frame_ = libav::new_frame();
  libav::Owned<AVPacket> packet_ = libav::new_packet();
  std::vector<float> levels_;
};

}  // namespace floatstage::capture
