#include "pipeline/matte/matte_take.h"

#include <algorithm>
#include <chrono>
#include <mutex>

#include "capture/take.h"
#include "core/file.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/keying.h"
#include "pipeline/matte/camera_matting.h"
#include "pipeline/matte/consistent_take.h"
#include "pipeline/matte/matting_record.h"
#include "pipeline/matte/spectral_take.h"
#include "pipeline/progress.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// One camera of this run.
struct Job {
  int camera = 0;
  std::string serial;
  std::optional<CameraMatting> matting;
  CameraRecord record;
  CameraMattes report;
  std::vector<std::pair<int, std::string>> failures;
  std::string old_key;
  bool clear = false;  // what is there was made otherwise
};

// What all threads share: the first error that stops the run, and the counts.
class Run {
 public:
  explicit Run(Progress* watch) : progress(watch) {}

  Progress* const progress;

  bool stopped() {
    std::lock_guard lock(mutex_);
    return fatal_.has_value() || is_cancelled(progress);
  }
  void stop(const Error& e) {
    std::lock_guard lock(mutex_);
    if (!fatal_) fatal_ = e;
  }
  void count(int& counter) {
    std::lock_guard lock(mutex_);
    ++counter;
  }
  void failed(Job& job, int frame, const Error& e) {
    std::lock_guard lock(mutex_);
    if (e.code == ErrorCode::Io && !fatal_) fatal_ = e;
    job.failures.emplace_back(frame, text("camera '", job.serial, "', frame ", frame, ": ", e.message));
  }
  Result<void> result() {
    if (fatal_) return Unexpected{*fatal_};
    if (is_cancelled(progress)) return cancelled();
    return {};
  }

 private:
  std::mutex mutex_;
  std::optional<Error> fatal_;
};

Result<std::vector<Job>> jobs_of(const capture::TakeReader& take, const MatteTakeOptions& options) {
  const std::vector<MatteMethod>& methods = matte_methods();
  std::string names;
  for (const MatteMethod& m : methods) names += text(names.empty() ? "" : ", ", m.name);
  if (std::none_of(methods.begin(), methods.end(),
                   [&](const MatteMethod& m) { return m.name == options.method; }))
    return fail(ErrorCode::InvalidArgument,
                text("no method is called '", options.method, "'; there are ", names));
  std::vector<Job> jobs;
  const auto add = [&](int camera) {
    Job job;
    job.camera = camera;
    job.serial = job.report.serial = take.rig().cameras[static_cast<std::size_t>(camera)].serial;
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

// Mattes that are there were made as this run would make them, or --redo lets them be cleared.
Result<void> settle(const capture::TakeReader& take, Job& job,
                    const std::map<std::string, CameraRecord>& before, bool redo) {
  const fs::path folder = take.layout().mattes() / job.serial;
  std::error_code none;
  const bool there = fs::exists(folder) && !fs::is_empty(folder, none);
  const auto old = before.find(job.serial);
  const bool same = old != before.end() && old->second.method == job.record.method &&
                    old->second.guide == job.record.guide && old->second.edits == job.record.edits;
  if (same) job.record = old->second, job.old_key = old->second.key;
  job.clear = there && !same;
  if (job.clear && !redo)
    return fail(ErrorCode::AlreadyExists,
                text(folder.string(), " was made otherwise (",
                     old == before.end() ? "not by `matte`"
                                         : text("method ", old->second.method, ", or other edits or guide"),
                     "); add --redo to make it again"));
  return {};
}

// What an editor had not made again when it was interrupted is made like what is missing.
Result<void> remove_stale(const capture::TakeReader& take, Job& job) {
  for (const int frame : job.record.stale) {
    const fs::path file = take.layout().matte(job.serial, frame);
    std::error_code error;
    fs::remove(file, error);
    if (error) return fail(ErrorCode::Io, text("cannot remove ", file.string(), ": ", error.message()));
  }
  job.record.stale.clear();
  return {};
}

Result<void> prepare(capture::TakeReader& take, const MatteTakeOptions& options, const MatteEdits& edits,
                     Job& job) {
  const auto found = edits.cameras.find(job.serial);
  const CameraEdits mine = found == edits.cameras.end() ? CameraEdits() : found->second;
  const MatteEffort effort = effort_of(mine);
  job.report.keyframes = effort.keyframes;
  job.report.clicks = effort.clicks + effort.scribbles;
  Result<CameraKey> key = CameraKey::for_method(take, job.camera, options.method, options.guide, mine,
                                                [&] { return !is_cancelled(options.progress); });
  if (!key) return forward(key);
  if (!job.old_key.empty() &&
      job.old_key != key->spec()) {  // a plate was shot since, or this program keys otherwise now
    if (!options.redo)
      return fail(ErrorCode::AlreadyExists,
                  text("the mattes of camera '", job.serial, "' were made from the key ", job.old_key,
                       ", which is now ", key->spec(), "; add --redo to make them again"));
    job.clear = true;
    job.record.chosen.clear();
    job.record.stale.clear();
  }
  if (job.record.chosen.empty() || job.clear)  // else mattes may all be there, and nobody asks
    if (Result<void> ok = key->ready(); !ok) return ok;
  job.report.key = job.record.key = key->spec();
  job.matting.emplace(take, job.camera, std::move(*key), mine, options.method);
  if (job.record.chosen.empty()) {
    Result<std::string> chosen = job.matting->chosen_method();
    if (!chosen) return forward(chosen);
    job.record.chosen = std::move(*chosen);
  }
  job.matting->set_method(job.record.chosen);
  job.report.method = job.record.chosen;
  return {};
}

// Makes one matte, or reads it where it is needed and there. Nothing for a gap or a failure.
Image make(const capture::TakeReader& take, Run& run, Job& job, int frame, const Image& previous) {
  const fs::path file = take.layout().matte(job.serial, frame);
  if (fs::exists(file)) {
    run.count(job.report.kept);
    if (!job.matting->follows()) return {};
    Result<Image> matte = load_png(file);
    return matte ? std::move(*matte) : Image();
  }
  Result<Image> matte = job.matting->matte(frame, previous);
  if (!matte) return run.failed(job, frame, matte.error()), Image();
  if (matte->empty()) return run.count(job.report.gaps), Image();
  if (Result<void> ok = save_png(*matte, file); !ok) return run.failed(job, frame, ok.error()), Image();
  run.count(job.report.made);
  return std::move(*matte);
}

// Spectral matting works through a camera as a whole and uses all threads for it.
void make_spectral(capture::TakeReader& take, Run& run, Job& job, int threads) {
  bool all_there = true;
  for (int f = 0; f < take.frame_count(); ++f)
    all_there = all_there && fs::exists(take.layout().matte(job.serial, f));
  if (all_there) {
    job.report.kept = take.frame_count();
    return;
  }
  ProgressPart progress(run.progress, text("mattes of ", job.serial),
                        static_cast<std::size_t>(take.frame_count()));
  const auto make_all = [&]() -> Result<void> {
    Result<SpectralTake> spectral = SpectralTake::create(take, job.camera, job.matting->key(),
                                                         spectral_cache(take.layout(), job.serial), threads);
    if (!spectral) return forward(spectral);
    if (Result<void> ok = spectral->say(*job.matting); !ok) return ok;
    const auto go_on = [&](int) { return !is_cancelled(run.progress); };
    if (Result<void> ok = spectral->prepare(go_on); !ok) return ok;
    if (Result<void> ok = spectral->propagate(go_on, 0, take.frame_count() - 1); !ok) return ok;
    for (int frame = 0; frame < take.frame_count() && !is_cancelled(run.progress); ++frame) {
      progress.advance();
      const fs::path file = take.layout().matte(job.serial, frame);
      if (fs::exists(file)) {
        run.count(job.report.kept);
        continue;
      }
      Result<Image> matte = spectral->matte(*job.matting, frame);
      if (!matte) return forward(matte);
      if (Result<void> ok = matte->empty() ? Result<void>() : save_png(*matte, file); !ok) return ok;
      run.count(matte->empty() ? job.report.gaps : job.report.made);
    }
    return {};
  };
  const Result<void> ok = make_all();
  if (!ok && ok.error().code == ErrorCode::Io) return run.stop(ok.error());
  if (!ok && ok.error().code != ErrorCode::Cancelled) run.failed(job, 0, ok.error());
}

// A camera whose parts are followed is one item, in its order; of the others every frame is one.
struct Item {
  Job* job;
  int frame;  // -1: all of them
};

void make_items(const capture::TakeReader& take, Run& run, std::vector<Job>& jobs, int threads) {
  std::vector<Item> items;
  std::size_t mattes = 0;
  for (Job& job : jobs)
    if (!job.matting->spectral()) {
      mattes += static_cast<std::size_t>(take.frame_count());
      if (job.matting->follows()) items.push_back({&job, -1});
    }
  if (mattes == 0) return;
  for (int f = 0; f < take.frame_count(); ++f)
    for (Job& job : jobs)
      if (!job.matting->spectral() && !job.matting->follows()) items.push_back({&job, f});
  ProgressPart progress(run.progress, "mattes", mattes);
  parallel_for(items.size(), threads, [&](std::size_t i) {
    Job& job = *items[i].job;
    if (items[i].frame >= 0) {
      if (!run.stopped()) make(take, run, job, items[i].frame, {});
      return progress.advance();
    }
    job.matting->follow([&] { return !run.stopped(); },
                        [&](int frame, const CameraMatting::Link& previous) {
                          progress.advance();
                          return CameraMatting::Link{make(take, run, job, frame, previous.matte)};
                        });
  });
}

// All cameras at once, instant after instant.
Result<void> make_consistent(capture::TakeReader& take, const MatteTakeOptions& options,
                             const MatteEdits& edits, std::vector<Job>& jobs, MatteReport& report) {
  ConsistentTakeOptions consistent{.matting = {.threads = options.threads}, .progress = options.progress};
  for (const Job& job : jobs) consistent.cameras.push_back(job.camera);
  Result<ConsistentTakeReport> made = consistent_take(take, edits, consistent);
  if (!made) return forward(made);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    CameraMattes& c = jobs[i].report;
    c.made = made->cameras[i].made, c.kept = made->cameras[i].kept, c.gaps = made->cameras[i].gaps;
    if (c.made > 0) c.consistent = made->cameras[i].mean;
  }
  report.remarks = std::move(made->remarks);
  report.distrusted = made->distrusted;
  return {};
}

double flicker_of(const capture::TakeReader& take, const std::string& serial, const Progress* progress) {
  Image before;
  double sum = 0;
  int pairs = 0;
  for (int f = 0; f < take.frame_count() && !is_cancelled(progress); ++f) {
    Result<Image> now = load_png(take.layout().matte(serial, f));
    if (now && now->pixels.size() == before.pixels.size()) {
      double change = 0;
      for (std::size_t p = 0; p < now->pixels.size(); ++p)
        change += std::abs(now->pixels[p] - before.pixels[p]);
      sum += change / (255.0 * static_cast<double>(now->pixels.size()));
      ++pairs;
    }
    before = now ? std::move(*now) : Image();
  }
  return pairs ? sum / pairs : 0;
}

Result<void> check_against_hull(const capture::TakeReader& take, const MatteTakeOptions& options,
                                MatteReport& report) {
  const int count = take.frame_count(), wanted = std::min(options.hull_frames, count);
  std::vector<int> frames;
  for (int i = 0; i < wanted; ++i) frames.push_back(static_cast<int>((2L * i + 1) * count / (2L * wanted)));
  if (frames.empty()) return {};
  Result<std::vector<SilhouetteAgreement>> worst =
      hull_agreement(take, frames, options.threads, options.progress);
  if (!worst) return forward(worst);
  report.worst = std::move(*worst);
  for (CameraMattes& camera : report.cameras) {
    double sum = 0;
    int seen = 0;
    for (const SilhouetteAgreement& a : report.worst)
      if (a.serial == camera.serial) sum += a.iou, ++seen;
    if (seen) camera.hull_agreement = sum / seen;
  }
  return {};
}

// What the other verbs read: with chroma keys they can take the spill off the photographs.
Result<void> save_keying_of(const capture::TakeReader& take, const std::vector<Job>& jobs,
                            const std::string& method) {
  KeyingRecord record{"matte:" + method, {}};
  const bool all_chroma =
      jobs.size() == take.rig().cameras.size() && std::all_of(jobs.begin(), jobs.end(), [](const Job& j) {
        return j.matting && j.matting->key().kind() == CameraKey::Kind::Chroma;
      });
  if (all_chroma)
    for (const Job& job : jobs) record.specs.push_back(job.record.key);
  return save_keying(record, take.layout(), take.rig());
}

}  // namespace

const std::vector<MatteMethod>& matte_methods() {
  static const std::vector<MatteMethod> methods = {
      {"auto",
       "what explains a few photographs best: the key alone or closed form around it; spectral without a "
       "key"},
      {"chroma", "green or blue cloth"},
      {"plate", "against plates/, or the backdrop found behind the performance"},
      {"closed-form", "closed-form matting in the band around the key"},
      {"spectral", "spectral video matting from the key, from clicks, or from its own first guess"},
      {"consistent", "no key: what lies where the cameras look and is consistent across all their pictures"},
  };
  return methods;
}

Result<MatteReport> matte_take(const MatteTakeOptions& options) {
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(options.take);
  if (!opened) return forward(opened);
  capture::TakeReader& take = **opened;
  Result<std::vector<Job>> jobs = jobs_of(take, options);
  if (!jobs) return forward(jobs);
  Result<MatteEdits> edits = load_matte_edits(take.layout().edits());
  if (!edits) return forward(edits);
  for (const auto& [serial, camera] : edits->cameras)
    if (camera_index(take.rig(), serial) < 0)
      return fail(ErrorCode::BadData, text(take.layout().edits().string(), " speaks of a camera '", serial,
                                           "' that the take does not have"));
  Result<std::map<std::string, CameraRecord>> record = load_matting(take.layout());
  if (!record && !options.redo) return forward(record);
  std::map<std::string, CameraRecord> all =
      record ? std::move(*record) : std::map<std::string, CameraRecord>();

  const auto begin = std::chrono::steady_clock::now();
  sweep_temporaries(take.layout().mattes());
  for (Job& job : *jobs) {
    job.record = {
        options.method, "", "", options.guide.string(),
        fingerprint(edits->cameras.count(job.serial) ? edits->cameras.at(job.serial) : CameraEdits())};
    if (Result<void> ok = settle(take, job, all, options.redo); !ok) return forward(ok);
  }
  Run run(options.progress);
  const bool consistent = options.method == "consistent";
  if (consistent && !options.guide.empty())
    return fail(ErrorCode::InvalidArgument, "the method 'consistent' takes no guide");
  for (Job& job : *jobs)
    if (consistent) job.report.key = job.report.method = job.record.key = job.record.chosen = options.method;
  ProgressPart keys(options.progress, "keys", jobs->size());
  parallel_for(jobs->size(), options.threads, [&](std::size_t i) {
    if (run.stopped() || consistent) return;
    if (Result<void> ok = prepare(take, options, *edits, (*jobs)[i]); !ok) run.stop(ok.error());
    keys.advance();
  });
  if (Result<void> ok = run.result(); !ok) return forward(ok);
  // Only now that every camera has a key may old mattes go.
  for (Job& job : *jobs) {
    const fs::path folder = take.layout().mattes() / job.serial;
    if (Result<void> ok = job.clear ? clear_for_redo(folder) : remove_stale(take, job); !ok)
      return forward(ok);
    if (Result<void> ok = make_folder(folder); !ok) return forward(ok);
    all[job.serial] = job.record;
  }
  if (Result<void> ok = save_matting(all, take.layout()); !ok) return forward(ok);
  if (Result<void> ok = save_keying_of(take, *jobs, options.method); !ok) return forward(ok);
  MatteReport report;
  if (consistent) {
    if (Result<void> ok = make_consistent(take, options, *edits, *jobs, report); !ok) return forward(ok);
  } else {
    make_items(take, run, *jobs, options.threads);
  }
  for (Job& job : *jobs)
    if (!consistent && job.matting->spectral() && !run.stopped())
      make_spectral(take, run, job, options.threads);
  if (Result<void> ok = run.result(); !ok) return forward(ok);

  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::vector<double> flicker(jobs->size());
  parallel_for(jobs->size(), options.threads,
               [&](std::size_t i) { flicker[i] = flicker_of(take, (*jobs)[i].serial, options.progress); });
  for (std::size_t i = 0; i < jobs->size(); ++i) {
    Job& job = (*jobs)[i];
    std::sort(job.failures.begin(), job.failures.end());
    for (auto& [frame, sentence] : job.failures) job.report.failures.push_back(std::move(sentence));
    job.report.flicker = flicker[i];
    report.made += job.report.made;
    report.cameras.push_back(std::move(job.report));
  }
  if (report.made) report.seconds_per_frame = report.seconds / report.made;
  if (Result<void> ok = check_against_hull(take, options, report); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::pipeline
