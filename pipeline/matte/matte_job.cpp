#include "pipeline/matte/matte_job.h"

#include <algorithm>
#include <filesystem>

#include "capture/added_file.h"
#include "capture/sha256.h"
#include "core/file_presence.h"
#include "core/parallel.h"
#include "core/text.h"
#include "pipeline/matte/affected_frames.h"
#include "pipeline/matte/matte_how.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

bool any(const std::vector<bool>& frames) {
  return std::find(frames.begin(), frames.end(), true) != frames.end();
}

Result<std::vector<MatteJob>> cameras_asked_for(const capture::TakeReader& take,
                                                const MatteTakeOptions& options) {
  const std::size_t frames = static_cast<std::size_t>(take.frame_count());
  std::vector<bool> wanted(frames, options.frames.empty());
  for (const int frame : options.frames) {
    if (frame < 0 || static_cast<std::size_t>(frame) >= frames)
      return fail(ErrorCode::InvalidArgument, text(take.layout().folder().string(), " has no frame ", frame));
    wanted[static_cast<std::size_t>(frame)] = true;
  }
  std::vector<MatteJob> jobs;
  const auto add = [&](int camera) {
    MatteJob job;
    job.camera = camera;
    job.frame_rate = take.manifest().frame_rate;
    job.serial = job.report.serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
    job.wanted = wanted;
    jobs.push_back(std::move(job));
  };
  if (options.cameras.empty())
    for (std::size_t i = 0; i < take.rig().cameras.size(); ++i) add(static_cast<int>(i));
  for (const std::string& serial : options.cameras) {
    const int camera = camera_index(take.rig(), serial);
    if (camera < 0)
      return fail(ErrorCode::InvalidArgument,
                  text(take.layout().folder().string(), " has no camera '", serial, "'"));
    add(camera);
  }
  return jobs;
}

Result<void> look_at_files(const MatteStore& store, MatteJob& job) {
  const Result<std::vector<MatteOrigin>> origins =
      store.origins(job.serial, static_cast<int>(job.wanted.size()));
  if (!origins) return forward(origins);
  for (std::size_t f = 0; f < origins->size(); ++f) {
    job.there.push_back((*origins)[f] != MatteOrigin::Missing);
    job.ours.push_back((*origins)[f] == MatteOrigin::Ours);
    job.report.others += (*origins)[f] == MatteOrigin::Others && job.wanted[f];
  }
  return {};
}

// Frames of ours that differ now from what the record says of them.
Result<std::vector<bool>> outdated(const capture::TakeReader& take, const CameraRecord& before, MatteJob& job,
                                   bool redo) {
  const std::size_t count = job.ours.size();
  const Result<std::string> inputs = hash_of_inputs(take, job.serial, job.guide);
  if (!inputs) return forward(inputs);
  const bool same_way = before.how == job.how && before.guide == job.guide;
  if (!same_way && any(job.ours) && !redo)
    return fail(ErrorCode::AlreadyExists,
                text((take.layout().mattes() / job.serial).string(), " was made by --matte ", before.how,
                     before.guide.empty() ? "" : text(" with the guide ", before.guide), ", not by ", job.how,
                     "; add --redo to make it again"));
  const bool anew = redo || !same_way || before.inputs != *inputs;
  job.settled = !anew && !before.method.empty();
  job.together = job.together || (!anew && before.method == "consistent");
  std::vector<bool> frames(count, anew);
  job.explained = anew || before.edits != without_subjects(job.edits);
  job.strokes_only = !anew && before.stale.empty() && before.edits.masks == job.edits.masks;
  std::vector<bool> edited =
      frames_made_otherwise(before.method, before.key, before.edits, job.edits, static_cast<int>(count));
  if (before.method != "spectral" && before.method != "consistent")
    edited = downstream_of(std::move(edited), job.edits);
  for (std::size_t f = 0; f < count; ++f)
    frames[f] = frames[f] || edited[f] || before.stale.contains(static_cast<int>(f));
  return frames;
}

Result<void> settle(const capture::TakeReader& take, const MatteStore& store, const MatteTakeOptions& options,
                    MatteJob& job) {
  if (Result<void> ok = look_at_files(store, job); !ok) return ok;
  const std::size_t count = job.wanted.size();
  job.together = job.how == "consistent";
  std::vector<bool> old(count);
  if (const CameraRecord* before = store.find(job.serial)) {
    Result<std::vector<bool>> frames = outdated(take, *before, job, options.redo);
    if (!frames) return forward(frames);
    old = std::move(*frames);
  }
  job.todo.assign(count, false);
  for (std::size_t f = 0; f < count; ++f)
    job.todo[f] = job.wanted[f] && (!job.there[f] || (job.ours[f] && old[f]));
  // What is not this run's to make stays as it is, and the record says so.
  for (std::size_t f = 0; f < count; ++f)
    if (job.ours[f] && old[f] && !job.wanted[f]) job.stale.insert(static_cast<int>(f));
  const bool nothing_given =
      job.how == "given" && job.guide.empty() && !is_folder(take.layout().given_mattes(job.serial));
  if (!nothing_given) return {};
  for (std::size_t f = 0; f < count; ++f) {
    if (job.todo[f] && job.ours[f])
      return fail(ErrorCode::NotFound, text("nobody gave mattes of camera '", job.serial, "': put them into ",
                                            (take.layout().mattes() / job.serial).string(),
                                            ", or name their folder with --guide"));
    job.report.gaps += job.todo[f];
    job.todo[f] = false;
  }
  return {};
}

}  // namespace

bool MatteJob::nothing_to_do() const { return !any(todo); }

std::pair<int, int> MatteJob::reach() const {
  int first = -1, last = -1;
  for (int f = 0; f < static_cast<int>(todo.size()); ++f)
    if (todo[static_cast<std::size_t>(f)]) first = first < 0 ? f : first, last = f;
  return {first, last};
}

Result<std::string> hash_of_inputs(const capture::TakeReader& take, const std::string& serial,
                                   const std::string& guide) {
  const TakeLayout& layout = take.layout();
  std::vector<fs::path> files = {layout.frames_csv(serial), layout.plate(serial)};
  std::vector<fs::path> folders = {layout.plate(serial).parent_path() / serial, layout.given_mattes(serial)};
  if (!guide.empty()) folders.push_back(fs::path(guide) / serial);
  for (const fs::path& folder : folders) {
    std::vector<fs::path> inside;
    std::error_code none;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, none))
      if (entry.path().extension() == ".png") inside.push_back(entry.path());
    std::sort(inside.begin(), inside.end());
    files.insert(files.end(), inside.begin(), inside.end());
  }
  std::string all;
  for (const fs::path& file : files) {
    const Result<std::optional<std::string>> hash = hash_of(file);
    if (!hash) return forward(hash);
    // The take's own name says nothing: a copy has another.
    const bool beside = file.parent_path() == take.layout().folder();
    all += text(beside ? "" : text(file.parent_path().filename().string(), "/"), file.filename().string(),
                " ", hash->value_or("none"), "\n");
  }
  const Result<capture::AddedFile> added = capture::load_added(layout);
  if (!added) return forward(added);
  if (const AddedContent hidden = added->of(serial); !hidden.none())
    all += text("without ", describe(hidden), "\n");
  return capture::sha256(all);
}

Result<bool> anything_given(const capture::TakeReader& take, const MatteStore& store) {
  for (const RigCamera& camera : take.rig().cameras)
    for (const int frame : take.layout().frames_with_mattes(camera.serial)) {
      if (frame >= take.frame_count()) break;
      const Result<MatteOrigin> origin = store.origin(camera.serial, frame);
      if (!origin) return forward(origin);
      if (*origin == MatteOrigin::Others) return true;
    }
  return false;
}

Result<std::string> usual_way(const capture::TakeReader& take, const MatteStore& store) {
  std::optional<std::string> common;
  for (const auto& [serial, camera] : store.record()) {
    if (common && *common != camera.how) return std::string("auto");
    common = camera.how;
  }
  if (common) return *common;
  const Result<bool> given = anything_given(take, store);
  if (!given) return forward(given);
  return std::string(*given ? "given" : "auto");
}

Result<std::vector<MatteJob>> matte_jobs(const capture::TakeReader& take, const MatteStore& store,
                                         const MatteEdits& edits, const MatteTakeOptions& options) {
  if (options.how)
    if (Result<void> ok = check_matte_how(*options.how); !ok) return forward(ok);
  Result<std::vector<MatteJob>> jobs = cameras_asked_for(take, options);
  if (!jobs) return jobs;
  std::string usual;
  for (MatteJob& job : *jobs) {
    const CameraRecord* before = store.find(job.serial);
    if (!options.how && !before && usual.empty()) {
      Result<std::string> way = usual_way(take, store);
      if (!way) return forward(way);
      usual = std::move(*way);
    }
    job.how = options.how ? *options.how : before ? before->how : usual;
    job.guide = !options.guide.empty()   ? fs::absolute(options.guide).lexically_normal().string()
                : !options.how && before ? before->guide
                                         : "";
    if (job.how == "consistent" && !job.guide.empty())
      return fail(ErrorCode::InvalidArgument, "--matte consistent takes no --guide");
    if (const auto mine = edits.cameras.find(job.serial); mine != edits.cameras.end())
      job.edits = mine->second;
    const MatteEffort effort = effort_of(job.edits);
    job.report.keyframes = effort.keyframes;
    job.report.clicks = effort.clicks + effort.scribbles;
  }
  std::vector<Result<void>> settled(jobs->size());
  parallel_for(jobs->size(), options.threads,
               [&](std::size_t i) { settled[i] = settle(take, store, options, (*jobs)[i]); });
  for (const Result<void>& ok : settled)
    if (!ok) return forward(ok);
  return jobs;
}

Result<void> prepare(capture::TakeReader& take, const MatteTakeOptions& options, CameraRecord& record,
                     MatteJob& job) {
  Result<std::string> inputs = hash_of_inputs(take, job.serial, job.guide);
  if (!inputs) return forward(inputs);
  if (record.how != job.how || record.guide != job.guide || record.inputs != *inputs || options.redo)
    record.method.clear(), record.key.clear();
  record.how = job.how;
  record.guide = job.guide;
  record.inputs = std::move(*inputs);
  if (job.together) return make_together(record, job), Result<void>();
  Result<CameraKey> key = CameraKey::for_how(take, job.camera, job.how, job.guide, job.edits,
                                             [&] { return !is_cancelled(options.progress); });
  if (!key) return forward(key);
  if (!record.key.empty() && record.key != key->spec()) {  // first clicks, or this program keys otherwise now
    job.strokes_only = false;
    if (any(job.ours) && !job.explained)
      return fail(ErrorCode::AlreadyExists,
                  text("the mattes of camera '", job.serial, "' were made from the key ", record.key,
                       ", which is now ", key->spec(), "; add --redo to make them again"));
    for (std::size_t f = 0; f < job.todo.size(); ++f) {
      job.todo[f] = job.todo[f] || (job.wanted[f] && job.ours[f]);
      if (job.ours[f] && !job.wanted[f]) job.stale.insert(static_cast<int>(f));
    }
    record.method.clear();
  }
  if (record.method.empty())  // else it is needed only where a matte is made
    if (Result<void> ok = key->ready(); !ok) return ok;
  record.key = key->spec();
  job.matting.emplace(take, job.camera, std::move(*key), job.edits, job.how);
  return {};
}

Result<void> choose_method(CameraRecord& record, MatteJob& job) {
  if (!job.matting) return {};
  if (record.method.empty()) {
    Result<std::string> chosen = job.matting->chosen_method();
    if (!chosen) return forward(chosen);
    record.method = std::move(*chosen);
  }
  job.matting->set_method(record.method);
  return {};
}

void make_together(CameraRecord& record, MatteJob& job) {
  record.method = record.key = "consistent";
  job.matting.reset();
  job.together = true;
}

void begin(const MatteJob& job, CameraRecord& record) {
  if (record.how != job.how || record.guide != job.guide)  // nothing was made so, or prepare() had said it
    record.method.clear(), record.key.clear(), record.inputs.clear();
  record.how = job.how;
  record.guide = job.guide;
  record.edits = without_subjects(job.edits);
  record.stale = job.stale;
  for (std::size_t f = 0; f < job.todo.size(); ++f) {
    const int frame = static_cast<int>(f);
    if (job.todo[f] && job.ours[f]) record.stale.insert(frame);
    if (!job.ours[f]) record.files.erase(frame);
  }
}

}  // namespace floatstage::pipeline
