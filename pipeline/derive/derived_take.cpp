// New takes that share the media of old ones. docs/adr/0239-derived-takes-share-media.md

#include "pipeline/derive/derived_take.h"

#include <algorithm>
#include <cmath>

#include "capture/added_file.h"
#include "capture/derivation.h"
#include "capture/sha256.h"
#include "capture/sound/time_code.h"
#include "core/file.h"
#include "core/file_presence.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/derive/carried_files.h"
#include "pipeline/matte_record.h"
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
  bool all() const { return other_.first == 0 && end_ == from_.frame_count() && other_.moved.empty(); }

  int moved(std::size_t camera) const { return other_.moved.empty() ? 0 : other_.moved[camera]; }

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
    const std::int64_t later = moved(c) == 0 ? 0 : std::llround(moved(c) * 1e9 / manifest_.frame_rate);
    for (int i = other_.first - moved(c); i < std::min(end_ - moved(c), static_cast<int>(rows.size())); ++i) {
      FrameRow row = rows[static_cast<std::size_t>(i)];
      row.info.exposure_start.ns += later;
      csv += to_csv(row);
    }
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
                                   std::pair(capture::added_file(from), capture::added_file(to_))})
      if (Result<void> ok = share_if_there(file, to, report_); !ok) return ok;
    const fs::path times = capture::times_file(to_);
    if (Result<void> ok = other_.times ? capture::save_time_offsets(*other_.times, times)
                                       : share_if_there(capture::times_file(from), times, report_);
        !ok)
      return ok;
    std::error_code error;
    const bool meshes = fs::is_directory(from.meshes(), error);
    if (all()) {
      if (Result<void> ok = share_folder(from.mattes(), to_.mattes(), report_); !ok) return ok;
      if (meshes) report_.notes.push_back("its hulls were left out: run `floatstage process` again");
      return {};
    }
    if (Result<void> ok = mattes_by_frame(); !ok) return ok;
    if (is_there(from.edits()))
      report_.notes.push_back(
          "corrections of mattes were left out, since their frames have other numbers now");
    return {};
  }

  // Those of instants that come along, under their new numbers.
  Result<void> mattes_by_frame() {
    const TakeLayout& from = from_.layout();
    MatteRecord ours;
    if (!other_.moved.empty()) {
      Result<MatteRecord> record = load_matte_record(from);
      if (!record) return forward(record);
      ours = *std::move(record);
    }
    bool some = false, left_out = false;
    for (std::size_t c = 0; c < from_.rig().cameras.size(); ++c) {
      const std::string& serial = from_.rig().cameras[c].serial;
      const auto record = ours.find(serial);
      for (int f = other_.first; f < end_; ++f) {
        const int was = f - moved(c);
        if (!is_there(from.matte(serial, was))) continue;
        const bool stays = record != ours.end() && record->second.files.contains(was);
        (stays ? left_out : some) = true;
        if (stays) continue;
        if (Result<void> ok =
                share_if_there(from.matte(serial, was), to_.matte(serial, f - other_.first), report_);
            !ok)
          return ok;
      }
    }
    if (some) report_.notes.push_back("its mattes came along as given ones: they are used as they are");
    if (left_out)
      report_.notes.push_back(
          "mattes that were made with cameras of other instants were left out: run `floatstage process` "
          "again");
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
  if (!other.moved.empty() && other.moved.size() != from.rig().cameras.size())
    return fail(ErrorCode::InvalidArgument, text(other.moved.size(), " cameras' pictures to be moved, of ",
                                                 from.rig().cameras.size(), " cameras"));
  for (std::size_t c = 0; c < other.moved.size(); ++c)
    if (other.first < other.moved[c] || end - other.moved[c] > from.frame_count())
      return fail(ErrorCode::InvalidArgument,
                  text("camera '", from.rig().cameras[c].serial, "' has no pictures for frames ", other.first,
                       ":", end, " when they are moved by ", other.moved[c]));
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
