#include "capture/libav.h"
#include "capture/sound/film_sound.h"
#include "capture/sound/film_sound_track.h"
#include "core/claim.h"
#include "core/file.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;

Unexpected io_failure(const fs::path& file, int error) {
  return fail(ErrorCode::Io, text("cannot write ", file.string(), ": ", libav::reason(error)));
}

Result<void> mux(const FilmSound& sound, const fs::path& file, const fs::path& temporary) {
  const libav::Format muxer = libav::new_muxer(libav::muxer_of(file), temporary);
  FilmSoundTrack track(sound);
  if (Result<void> ok = track.open(*muxer, file); !ok) return ok;
  int error = avio_open(&muxer->pb, muxer->url, AVIO_FLAG_WRITE);
  if (error < 0) return io_failure(file, error);
  libav::Options options;
  if (!libav::is_matroska(file)) options.set("movflags", "+faststart");
  error = avformat_write_header(muxer.get(), options.get());
  if (error < 0) return io_failure(file, error);
  if (Result<void> ok = track.finish(); !ok) return ok;
  error = libav::finish_file(*muxer);
  return error < 0 ? io_failure(file, error) : Result<void>();
}

}  // namespace

Result<void> write_sound(const FilmSound& sound, const fs::path& file) {
  const Result<Claim> claim = claim_temporary_file(file);
  if (!claim) return forward(claim);
  const fs::path temporary = temporary_name(file);
  Result<void> written = mux(sound, file, temporary);
  if (written) written = rename_new(temporary, file);
  std::error_code ignored;
  if (!written) fs::remove(temporary, ignored);
  return written;
}

}  // namespace floatstage::capture
