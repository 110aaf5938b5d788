#include "capture/take_check.h"

#include <atomic>
#include <optional>

#include "capture/manifest_file.h"
#include "capture/sha256.h"
#include "capture/sound/sound_reader.h"
#include "capture/take.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/take_layout.h"
#include "core/text.h"

namespace floatstage::capture {
namespace {

namespace fs = std::filesystem;

// A camera that never delivered has no media file.
std::vector<std::string> recorded_files(const TakeLayout& layout, const TakeManifest& manifest) {
  std::vector<std::string> names;
  for (const TakeManifest::Camera& camera : manifest.cameras) {
    names.push_back(layout.frames_csv(camera.serial).filename().string());
    std::error_code error;
    if (fs::exists(layout.folder() / camera.media, error)) names.push_back(camera.media);
  }
  std::error_code error;
  if (fs::exists(sound_file(layout), error)) names.push_back(sound_file(layout).filename().string());
  if (const Result<std::vector<SoundTrack>> tracks = load_sound_tracks(layout))
    for (const SoundTrack& track : *tracks) {
      names.push_back(track.side_file());
      names.push_back(track.media());
    }
  return names;
}

// What of a sealed file is not as it was, which another size tells without reading it; `bytes` were read.
Result<std::optional<std::string>> difference(const fs::path& file, const TakeManifest::File& sealed,
                                              const ReadWatch& watch, std::uint64_t& bytes) {
  std::error_code error;
  const std::uint64_t size = fs::file_size(file, error);
  if (error == std::errc::no_such_file_or_directory) return std::optional(text(file.string(), " is missing"));
  if (!error && size != sealed.bytes)
    return std::optional(text(file.string(), " has ", size, " bytes; ", sealed.bytes, " were recorded"));
  const Result<FileHash> now = sha256_of_file(file, watch);
  if (!now && now.error().code == ErrorCode::Cancelled) return forward(now);
  if (!now) return std::optional(now.error().message);
  bytes = now->bytes;
  if (now->sha256 == sealed.sha256) return std::optional<std::string>();
  return std::optional(
      text(file.string(), " is not as it was recorded: its SHA-256 differs from take.json's"));
}

Result<void> compare_with_seal(const TakeLayout& layout, const TakeManifest& manifest, const ReadWatch& watch,
                               TakeCheck& check) {
  const std::vector<TakeManifest::File>& files = manifest.files;
  std::vector<Result<std::optional<std::string>>> changed(files.size(), std::optional<std::string>());
  std::vector<std::uint64_t> bytes(files.size());
  parallel_for(files.size(), 0, [&](std::size_t i) {
    changed[i] = difference(layout.folder() / files[i].name, files[i], watch, bytes[i]);
  });
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!changed[i]) return forward(changed[i]);
    if (*changed[i]) check.problems.push_back(**changed[i]);
    check.bytes += bytes[i];
  }
  check.files = static_cast<int>(files.size());
  return {};
}

Result<void> decode_all(TakeReader& take, const ReadWatch& watch, TakeCheck& check) {
  const std::vector<TakeManifest::Camera>& cameras = take.manifest().cameras;
  std::vector<std::int64_t> pictures(cameras.size());
  std::vector<std::vector<std::string>> problems(cameras.size());
  std::atomic<bool> stopped = false;
  parallel_for(cameras.size(), 0, [&](std::size_t c) {
    const int camera = static_cast<int>(c);
    std::error_code error;
    const std::uint64_t size = fs::file_size(take.layout().folder() / cameras[c].media, error);
    const std::size_t rows = take.rows(camera).size();
    for (std::size_t row = 0; row < rows && !stopped; ++row) {
      if (!take.rows(camera)[row].media_index) continue;
      const Result<Frame> frame = take.frame(camera, static_cast<int>(row));
      const fs::path media = take.layout().folder() / cameras[c].media;
      if (!frame) problems[c].push_back(frame.error().message);
      if (frame && frame->empty())
        problems[c].push_back(text(media.string(), ": the picture of row ", row, " is damaged"));
      ++pictures[c];
      if (!error && !watch(size / rows)) stopped = true;
    }
  });
  if (stopped) return fail(ErrorCode::Cancelled, text("interrupted in ", take.layout().folder().string()));
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    check.pictures += pictures[c];
    check.problems.insert(check.problems.end(), problems[c].begin(), problems[c].end());
  }
  return {};
}

// Whether its sound opens, and, unless the seal says it already, whether every sample is as it was written.
Result<void> check_sound(const TakeLayout& layout, bool is_complete, const ReadWatch& watch,
                         TakeCheck& check) {
  const Result<std::vector<SoundTrack>> tracks = load_sound_tracks(layout);
  if (!tracks) check.problems.push_back(tracks.error().message);
  for (std::size_t i = 0; tracks && i < tracks->size(); ++i) {
    const Result<std::unique_ptr<SoundReader>> sound = SoundReader::open(layout, (*tracks)[i]);
    if (!sound) {
      check.problems.push_back(sound.error().message);
      continue;
    }
    std::vector<std::string>& said = is_complete ? check.problems : check.remarks;
    said.insert(said.end(), (*sound)->warnings().begin(), (*sound)->warnings().end());
    if (check.sealed) continue;
    const Result<std::vector<std::string>> damage = (*sound)->damage(watch);
    if (!damage && damage.error().code == ErrorCode::Cancelled) return forward(damage);
    if (!damage) check.problems.push_back(damage.error().message);
    if (damage) check.problems.insert(check.problems.end(), damage->begin(), damage->end());
  }
  return {};
}

}  // namespace

std::uint64_t recorded_bytes(const fs::path& take) {
  const TakeLayout layout(take);
  std::uint64_t bytes = 0;
  if (const Result<TakeManifest> manifest = load_manifest(layout))
    for (const std::string& name : recorded_files(layout, *manifest)) {
      std::error_code error;
      const std::uint64_t size = fs::file_size(take / name, error);
      if (!error) bytes += size;
    }
  return bytes;
}

Result<void> seal_take(const fs::path& take, const ReadWatch& watch) {
  const TakeLayout layout(take);
  Result<TakeManifest> manifest = load_manifest(layout);
  if (!manifest) return forward(manifest);
  if (!manifest->files.empty()) return {};
  if (!manifest->complete)
    return fail(ErrorCode::InvalidArgument,
                text(take.string(), ": the recording was cut off; there is nothing whole to seal"));
  const std::vector<std::string> names = recorded_files(layout, *manifest);
  std::vector<Result<FileHash>> hashes(names.size(), FileHash{});
  parallel_for(names.size(), 0, [&](std::size_t i) { hashes[i] = sha256_of_file(take / names[i], watch); });
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!hashes[i]) return forward(hashes[i]);
    manifest->files.push_back({names[i], hashes[i]->bytes, hashes[i]->sha256});
  }
  return write_file(layout.manifest(), to_json(*manifest));
}

Result<TakeCheck> check_take(const fs::path& folder, const ReadWatch& watch) {
  const TakeLayout layout(folder);
  const Result<TakeManifest> manifest = load_manifest(layout);
  if (!manifest) return forward(manifest);
  TakeCheck check;
  check.sealed = !manifest->files.empty();
  if (check.sealed)
    if (Result<void> ok = compare_with_seal(layout, *manifest, watch, check); !ok) return forward(ok);
  const Result<std::unique_ptr<TakeReader>> take = TakeReader::open(folder);
  if (!take) {
    check.problems.push_back(take.error().message);
    return check;
  }
  std::vector<std::string>& said = (*take)->manifest().complete ? check.problems : check.remarks;
  said.insert(said.end(), (*take)->warnings().begin(), (*take)->warnings().end());
  if (Result<void> ok = check_sound(layout, manifest->complete, watch, check); !ok) return forward(ok);
  if (check.sealed) return check;
  check.files = static_cast<int>(recorded_files(layout, *manifest).size());
  check.bytes = recorded_bytes(folder);
  if (manifest->complete)
    check.remarks.push_back(text(folder.string(),
                                 " is not sealed: its pictures were decoded instead; `take "
                                 "seal` notes what the files are now"));
  if (Result<void> ok = decode_all(**take, watch, check); !ok) return forward(ok);
  return check;
}

}  // namespace floatstage::capture
