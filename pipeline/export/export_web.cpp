#include "pipeline/export/export_web.h"

#include <cmath>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "core/file.h"
#include "core/text.h"
#include "pipeline/export/instant.h"
#include "pipeline/export/page_start.h"
#include "pipeline/export/web_frame.h"
#include "pipeline/export/web_page.h"
#include "pipeline/film_sound.h"
#include "pipeline/subject.h"
#include "pipeline/undistort.h"
#include "pipeline/unfinished_folder.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kPathRate = 50;   // keys a second that a path is sampled at
constexpr double kUsualRate = 25;  // frames a second of takes that state none

json numbers(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

json cameras_of(const Rig& rig) {
  json cameras = json::array();
  for (const RigCamera& camera : rig.cameras) {
    const CameraModel m = straight(camera.model);
    const Eigen::Matrix4d matrix = camera.cam_from_world.matrix();  // by columns, as WebGL wants it
    cameras.push_back({{"serial", camera.serial},
                       {"fx", m.fx},
                       {"fy", m.fy},
                       {"cx", m.cx},
                       {"cy", m.cy},
                       {"width", m.width},
                       {"height", m.height},
                       {"matrix", std::vector<double>(matrix.data(), matrix.data() + matrix.size())},
                       {"center", numbers(camera.cam_from_world.center())}});
  }
  return cameras;
}

json start_of(const Rig& rig, const Eigen::AlignedBox3d& subject) {
  const PageStart start = page_start(rig, subject);
  return {{"target", numbers(start.target)},
          {"up", numbers(start.up)},
          {"east", numbers(start.east)},
          {"azimuth", 0},
          {"elevation", start.elevation},
          {"distance", start.distance},
          {"fov_y", start.fov_y}};
}

// Each with the frame that is shown then, as a place in `frames`.
json path_of(const std::optional<CameraPath>& path, const SubjectTrack& subject, double take_rate,
             const std::vector<int>& frames) {
  json keys = json::array();
  if (!path) return keys;
  for (int i = 0; i <= static_cast<int>(path->duration() * kPathRate); ++i) {
    const PathKey key = sample(*path, i / kPathRate, subject);
    keys.push_back({{"eye", numbers(key.eye)},
                    {"target", numbers(key.target)},
                    {"up", numbers(key.up)},
                    {"fov_y", key.fov_y},
                    {"frame", shown_at(*path, i / kPathRate, take_rate, frames)}});
  }
  return keys;
}

// Frames of the page a second: every second frame of a take stands for two.
double page_rate(const capture::TakeReader& take, const std::vector<int>& frames) {
  const double rate = take.manifest().frame_rate > 0 ? take.manifest().frame_rate : kUsualRate;
  const int step = frames.size() > 1 ? frames[1] - frames[0] : 1;
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (frames[i] - frames[i - 1] != step) return rate;
  return step > 0 ? rate / step : rate;
}

// "soundLoaded("…")" beside the frames, and how many seconds of it are heard; nothing where there is no
// sound.
Result<double> write_sound_of(const capture::TakeReader& take, const ExportWebOptions& options,
                              const fs::path& folder) {
  const Result<std::unique_ptr<FilmSounds>> sounds =
      FilmSounds::open(take, options.frames, page_rate(take, options.frames), options.sound_track);
  if (!sounds) return forward(sounds);
  if (!*sounds) return 0.0;
  const fs::path coded = folder / "sound.m4a";
  if (Result<void> ok = capture::write_sound((*sounds)->sound(), coded); !ok) return forward(ok);
  const Result<std::string> bytes = read_file(coded);
  if (!bytes) return forward(bytes);
  const Result<void> written = write_file(folder / "sound.js", "soundLoaded(\"" + base64(*bytes) + "\");\n");
  if (!written) return forward(written);
  std::error_code error;
  if (!fs::remove(coded, error))
    return fail(ErrorCode::Io, text("cannot remove ", coded.string(), ": ", error.message()));
  return (*sounds)->seconds();
}

std::string take_script(const capture::TakeReader& take, const ExportWebOptions& options, bool has_sound,
                        const Eigen::AlignedBox3d& subject, const SubjectTrack& track) {
  const TakeManifest& manifest = take.manifest();
  const json about = {{"title", manifest.label.empty() ? "Floatstage" : manifest.label},
                      {"frame_rate", page_rate(take, options.frames)},
                      {"sound", has_sound ? json("sound.js") : json()},
                      {"frames", options.frames},
                      {"blend", options.blend},
                      {"background", options.background},
                      {"cameras", cameras_of(take.rig())},
                      {"start", start_of(take.rig(), subject)},
                      {"path", path_of(options.path, track, manifest.frame_rate, options.frames)},
                      {"path_rate", kPathRate}};
  return "const floatstageTake = " + about.dump() + ";\n";
}

Result<void> check(const ExportWebOptions& options) {
  if (options.frames.empty()) return fail(ErrorCode::InvalidArgument, "there is no frame to export");
  if (options.quality < 1 || options.quality > 100)
    return fail(ErrorCode::InvalidArgument, "--quality is from 1 to 100");
  if (options.blend < 1 || options.blend > 3)
    return fail(ErrorCode::InvalidArgument, "the page blends 1 to 3 photographs; say so with --blend");
  return {};
}

std::uintmax_t bytes_below(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder, ignored))
    if (entry.is_regular_file(ignored)) bytes += entry.file_size(ignored);
  return bytes;
}

}  // namespace

Result<ExportWebReport> export_web(const ExportWebOptions& options) {
  if (Result<void> ok = check(options); !ok) return forward(ok);
  Result<std::unique_ptr<capture::TakeReader>> take = open_chosen(options.take, options.labels);
  if (!take) return forward(take);
  Result<UnfinishedFolder> out = UnfinishedFolder::begin(options.out);
  if (!out) return forward(out);
  if (Result<void> ok = make_folder(out->folder() / "frames"); !ok) return forward(ok);
  SceneLoader loader(**take, true);
  Eigen::AlignedBox3d subject;
  ExportWebReport report;
  {
    ProgressPart progress(options.progress, "frames", options.frames.size());
    for (const int frame : options.frames) {
      if (is_cancelled(options.progress)) return cancelled_unwritten();
      const Result<StraightInstant> instant = load_straight_instant(**take, loader, frame);
      if (!instant) return forward(instant);
      for (const Eigen::Vector3f& p : instant->mesh.positions) subject.extend(p.cast<double>());
      char name[24] = "";
      std::snprintf(name, sizeof name, "%06d.js", frame);
      const std::string script = web_frame(*instant, (*take)->rig(), frame, options.quality);
      if (Result<void> ok = write_file(out->folder() / "frames" / name, script); !ok) return forward(ok);
      ++report.frames;
      progress.advance();
    }
  }
  if (subject.isEmpty())
    return fail(ErrorCode::NotFound, text(options.take.string(),
                                          " shows no subject in these frames; look at "
                                          "its mattes, or name others with --frames"));
  Result<Subject> whole = Subject();
  if (options.path && options.path->follows()) whole = find_subject(**take);
  if (!whole) return forward(whole);
  if (options.sound) {
    const Result<double> heard = write_sound_of(**take, options, out->folder());
    if (!heard) return forward(heard);
    report.sound = *heard;
  }
  const std::string script = take_script(**take, options, report.sound > 0, subject, whole->track);
  if (Result<void> ok = write_file(out->folder() / "take.js", script); !ok) return forward(ok);
  for (const WebPageFile& file : web_page_files())
    if (Result<void> ok = write_file(out->folder() / file.name, file.content); !ok) return forward(ok);
  report.bytes = bytes_below(out->folder());
  if (Result<void> ok = out->publish(); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::pipeline
