// New takes that share the media of old ones. docs/adr/0239-derived-takes-share-media.md

#include "pipeline/derive/derived_take.h"

#include <algorithm>

#include "capture/added_file.h"
#include "capture/derivation.h"
#include "capture/sha256.h"
#include "capture/sound/time_code.h"
#include "capture/time_offsets.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/derive/carried_files.h"
#include "pipeline/occluders.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

class Deriving {
 public:
  Deriving(const capture::TakeReader& from, const DerivedTake& other, const fs::path& folder)
      : from_(from), other_(other), to_(folder), end_(other.end < 0 ? from.frame_count() : other.end) {}

  Result<DerivedReport> run() {
    report_.frames = end_ - other_.first;
    manifest_ = from_.manifest();
    if (!other_.label.empty()) manifest_.label = other_.label;
    for (std::size_t c = 0; c < manifest_.cameras.size(); ++c)
      if (Result<void> ok = media(c); !ok) return forward(ok);
    if (Result<void> ok = share_sound(from_, to_, report_); !ok) return forward(ok);
    if (other_.sound)
      if (Result<void> ok = add_sound(*other_.sound); !ok) return forward(ok);
    const Result<void> coded = other_.time_code ? capture::save_time_code(*other_.time_code, to_)
                                                : share_if_there(capture::time_code_file(from_.layout()),
                                                                 capture::time_code_file(to_), report_);
    if (!coded) return forward(coded);
    if (Result<void> ok = derived(); !ok) return forward(ok);
    const std::string rig = to_json(other_.rig ? *other_.rig : from_.rig());
    if (other_.rig) {
      if (Result<void> ok = write_file(to_.rig(), rig); !ok) return forward(ok);
      manifest_.rig_sha256 = capture::sha256(rig);
    } else if (Result<void> ok = share(from_.layout().rig(), to_.rig(), report_); !ok) {
      return forward(ok);
    }
    if (Result<void> ok =
            capture::save_derivation({from_.layout().folder().string(), other_.how}, to_.folder());
        !ok)
      return forward(ok);
    if (Result<void> ok = write_file(to_.manifest(), to_json(manifest_)); !ok) return forward(ok);
    return report_;
  }

 private:
  bool all() const { return other_.first == 0 && end_ == from_.frame_count(); }

  Result<void> media(std::size_t c) {
    const TakeManifest::Camera& camera = manifest_.cameras[c];
    if (Result<void> ok =
            share_if_there(from_.layout().folder() / camera.media, to_.folder() / camera.media, report_);
        !ok)
      return ok;
    const fs::path side_file = from_.layout().frames_csv(camera.serial);
    // One that is still being recorded grows on: what is there now is taken.
    if (all() && manifest_.complete) return share(side_file, to_.frames_csv(camera.serial), report_);
    const std::vector<FrameRow>& rows = from_.rows(static_cast<int>(c));
    std::string csv = frames_csv_header();
    for (int i = other_.first; i < std::min(end_, static_cast<int>(rows.size())); ++i)
      csv += to_csv(rows[static_cast<std::size_t>(i)]);
    for (TakeManifest::File& sealed : manifest_.files)
      if (sealed.name == side_file.filename().string()) {
        sealed.bytes = csv.size();
        sealed.sha256 = capture::sha256(csv);
      }
    return write_file(to_.frames_csv(camera.serial), csv);
  }

  // A track beside those that there are, and in the seal where there is one.
  Result<void> add_sound(const AddedSound& added) {
    Result<std::vector<capture::SoundTrack>> tracks = capture::load_sound_tracks(from_.layout());
    if (!tracks) return forward(tracks);
    tracks->insert(tracks->begin(), added.track);
    if (Result<void> ok = capture::save_sound_tracks(*tracks, to_); !ok) return ok;
    for (const std::string& file : {added.track.side_file(), added.track.media()})
      if (Result<void> ok = share(added.folder / file, to_.folder() / file, report_); !ok) return ok;
    if (manifest_.files.empty()) return {};
    for (const fs::path& file : {capture::sound_file(to_), to_.folder() / added.track.side_file(),
                                 to_.folder() / added.track.media()}) {
      const Result<capture::FileHash> hash =
          capture::sha256_of_file(file, [](std::uint64_t) { return true; });
      if (!hash) return forward(hash);
      const std::string name = file.filename().string();
      std::erase_if(manifest_.files, [&](const TakeManifest::File& sealed) { return sealed.name == name; });
      manifest_.files.push_back({name, hash->bytes, hash->sha256});
    }
    return {};
  }

  // What was derived and still holds.
  Result<void> derived() {
    const TakeLayout& from = from_.layout();
    for (const RigCamera& c : from_.rig().cameras)
      for (const auto& [file, to] : {std::pair(from.plate(c.serial), to_.plate(c.serial)),
                                     std::pair(occluder_file(from, c.serial), occluder_file(to_, c.serial))})
        if (Result<void> ok = share_if_there(file, to, report_); !ok) return ok;
    for (const auto& [file, to] : {std::pair(from.colors(), to_.colors()),
                                   std::pair(capture::added_file(from), capture::added_file(to_)),
                                   std::pair(capture::times_file(from), capture::times_file(to_))})
      if (Result<void> ok = share_if_there(file, to, report_); !ok) return ok;
    std::error_code error;
    const bool meshes = fs::is_directory(from.meshes(), error);
    if (all()) {
      if (Result<void> ok = share_folder(from.mattes(), to_.mattes(), report_); !ok) return ok;
      if (meshes) report_.notes.push_back("its hulls were left out: run `floatstage process` again");
      return {};
    }
    bool some = false;
    for (const RigCamera& c : from_.rig().cameras)
      for (int f = other_.first; f < end_; ++f) {
        some = some || is_there(from.matte(c.serial, f));
        if (Result<void> ok =
                share_if_there(from.matte(c.serial, f), to_.matte(c.serial, f - other_.first), report_);
            !ok)
          return ok;
      }
    if (some) report_.notes.push_back("its mattes came along as given ones: they are used as they are");
    if (is_there(from.edits()))
      report_.notes.push_back(
          "corrections of mattes were left out, since their frames have other numbers now");
    return {};
  }

  const capture::TakeReader& from_;
  const DerivedTake& other_;
  const TakeLayout to_;
  const int end_;
  TakeManifest manifest_;
  DerivedReport report_;
};

}  // namespace

Result<DerivedReport> derive_take(const capture::TakeReader& from, const DerivedTake& other,
                                  const fs::path& out) {
  const int end = other.end < 0 ? from.frame_count() : other.end;
  if (other.first < 0 || other.first >= end || end > from.frame_count())
    return fail(ErrorCode::InvalidArgument,
                text("frames ", other.first, ":", end, " are not in ", from.layout().folder().string(),
                     ", which has ", from.frame_count()));
  Result<UnfinishedFolder> take = UnfinishedFolder::begin(out);
  if (!take) return forward(take);
  Result<DerivedReport> report = Deriving(from, other, take->folder()).run();
  if (!report) return report;
  if (const auto opens = capture::TakeReader::open(take->folder()); !opens) return forward(opens);
  if (Result<void> ok = take->publish(); !ok) return forward(ok);
  return report;
}

Result<Rig> rig_for(const capture::TakeReader& take, const Rig& known, const std::string& name) {
  Rig rig;
  std::string missing;
  for (const TakeManifest::Camera& camera : take.manifest().cameras) {
    const int index = camera_index(known, camera.serial);
    if (index < 0) {
      missing += text(missing.empty() ? "" : ", ", camera.serial);
      continue;
    }
    RigCamera c = known.cameras[static_cast<std::size_t>(index)];
    c.serial = camera.serial;
    if (c.model.width == 0) c.model.width = camera.width, c.model.height = camera.height;
    if (c.model.width != camera.width || c.model.height != camera.height)
      return fail(ErrorCode::BadData,
                  text(name, ": camera '", camera.serial, "' was calibrated at ", c.model.width, "x",
                       c.model.height, ", but the take's pictures are ", camera.width, "x", camera.height,
                       "; calibrate with pictures of that size"));
    rig.cameras.push_back(std::move(c));
  }
  if (!missing.empty())
    return fail(ErrorCode::NotFound, text(name, " lacks cameras of ", take.layout().folder().string(), ": ",
                                          missing, "; calibrate those too, or correct the serials"));
  if (Result<void> ok = check(rig); !ok)
    return fail(ErrorCode::BadData, text(name, ": ", ok.error().message));
  return rig;
}

}  // namespace floatstage::pipeline
