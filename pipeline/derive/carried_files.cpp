#include "pipeline/derive/carried_files.h"

#include <algorithm>

#include "capture/sound/sound_record.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/text.h"

namespace floatstage::pipeline {

namespace fs = std::filesystem;

Result<void> share(const fs::path& from, const fs::path& to, DerivedReport& report) {
  std::error_code error;
  const fs::path file = fs::canonical(from, error);
  if (error) return fail(ErrorCode::Io, text(from.string(), ": ", error.message()));
  const std::uint64_t bytes = fs::file_size(file, error);
  fs::create_hard_link(file, to, error);
  if (!error) {
    report.shared += bytes;
    return {};
  }
  fs::copy_file(file, to, error);
  if (error)
    return fail(ErrorCode::Io,
                text("cannot copy ", from.string(), " to ", to.string(), ": ", error.message()));
  report.copied += bytes;
  return {};
}

Result<void> share_if_there(const fs::path& from, const fs::path& to, DerivedReport& report) {
  if (!is_there(from)) return {};
  if (Result<void> ok = make_folder(to.parent_path()); !ok) return ok;
  return share(from, to, report);
}

Result<void> share_folder(const fs::path& from, const fs::path& to, DerivedReport& report) {
  std::error_code error;
  if (!fs::is_directory(from, error)) return {};
  for (fs::recursive_directory_iterator entry(from, error), last; !error && entry != last;
       entry.increment(error)) {
    if (!entry->is_regular_file(error) || is_temporary(entry->path())) continue;
    // Logs grow in place: a second name would grow with them.
    const fs::path place = to / fs::relative(entry->path(), from, error);
    if (Result<void> ok = make_folder(place.parent_path()); !ok) return ok;
    if (entry->path().extension() == ".log") {
      fs::copy_file(entry->path(), place, error);
      continue;
    }
    if (Result<void> ok = share(entry->path(), place, report); !ok) return ok;
  }
  if (error) return fail(ErrorCode::Io, text("cannot read ", from.string(), ": ", error.message()));
  return {};
}

Result<void> share_sound(const capture::TakeReader& take, const TakeLayout& to, DerivedReport& report) {
  const TakeLayout& from = take.layout();
  const Result<std::vector<capture::SoundTrack>> tracks = capture::load_sound_tracks(from);
  if (!tracks) return forward(tracks);
  if (tracks->empty()) return {};
  if (Result<void> ok = share(capture::sound_file(from), capture::sound_file(to), report); !ok) return ok;
  for (const capture::SoundTrack& track : *tracks) {
    const fs::path side_file = from.folder() / track.side_file();
    if (Result<void> ok = share_if_there(from.folder() / track.media(), to.folder() / track.media(), report);
        !ok)
      return ok;
    // One that is still being recorded grows on: what is there now is taken.
    const bool complete = take.manifest().complete;
    const Result<std::string> now = complete ? std::string() : read_file(side_file);
    if (!now) return forward(now);
    const Result<void> ok = complete ? share_if_there(side_file, to.folder() / track.side_file(), report)
                                     : write_file(to.folder() / track.side_file(), *now);
    if (!ok) return ok;
  }
  return {};
}

capture::TakeCodec lossless_codec(std::span<const std::unique_ptr<capture::TakeReader>> takes,
                                  std::vector<std::string>& notes) {
  bool lossy = false;
  for (const auto& take : takes)
    for (const TakeManifest::Camera& c : take->manifest().cameras) lossy = lossy || c.codec == "h264";
  if (lossy) notes.push_back("its pictures are written as FFV1, so that H.264 costs them nothing twice");
  const bool raw = takes.front()->manifest().cameras.front().codec == "raw";
  return raw && !lossy ? capture::TakeCodec::Raw : capture::TakeCodec::Ffv1;
}

}  // namespace floatstage::pipeline
