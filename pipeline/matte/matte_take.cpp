#include "pipeline/matte/matte_take.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iterator>
#include <mutex>

#include "core/file.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/matte/all_cameras_instead.h"
#include "pipeline/matte/camera_doubts.h"
#include "pipeline/matte/consistent_take.h"
#include "pipeline/matte/heal_take.h"
#include "pipeline/matte/matte_checks.h"
#include "pipeline/matte/matte_doubts.h"
#include "pipeline/matte/matte_job.h"
#include "pipeline/matte/settle_added.h"
#include "pipeline/matte/spectral_take.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// What all threads share: the first error that stops the run, and the counts.
class Run {
 public:
  Run(MatteStore& mattes, Progress* watch) : store(mattes), progress(watch) {}

  MatteStore& store;
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
  void made(MatteJob& job, int frame, const Image& matte) {
    const MatteShape shape = shape_of(matte);
    std::lock_guard lock(mutex_);
    ++job.report.made;
    job.shapes[frame] = shape;
  }
  void guided(MatteJob& job, const CameraMatting::Link& made) {
    std::lock_guard lock(mutex_);
    job.report.idle.insert(job.report.idle.end(), made.idle.begin(), made.idle.end());
    if (made.guided || !made.ended.empty())
      job.guidance.push_back({.frame = made.frame, .matte = {}, .ended = made.ended, .guided = made.guided});
  }
  void failed(MatteJob& job, int frame, const Error& e) {
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

// Makes one matte, or reads it where it is needed and there. Nothing for a gap or a failure.
CameraMatting::Link make(Run& run, MatteJob& job, int frame, const CameraMatting::Link& previous) {
  using Link = CameraMatting::Link;
  const std::size_t f = static_cast<std::size_t>(frame);
  const bool follows = job.matting->follows();
  if (!job.todo[f] && !follows) return {};
  if (!job.todo[f]) {
    // Only what leads to a matte that is made; what nobody asked for is made to be followed, not kept.
    if (const auto [first, last] = job.reach(); !job.matting->leads_to(frame, first, last)) return {};
    if (job.there[f]) {
      Result<Image> matte = load_png(run.store.layout().matte(job.serial, frame));
      return matte ? link_of(run.store.find(job.serial), frame, std::move(*matte)) : Link();
    }
    Result<Link> matte = job.matting->matte(frame, previous);
    return matte ? std::move(*matte) : Link();
  }
  Result<Link> made = job.matting->matte(frame, previous);
  if (!made) return run.failed(job, frame, made.error()), Link();
  if (made->matte.empty()) return run.count(job.report.gaps), Link();
  if (job.strokes_only && job.ours[f] && heals_on(run.store, job.serial, job.edits, *made)) {
    run.store.stands(job.serial, frame);
    run.count(job.report.kept);
    run.guided(job, *made);
    return std::move(*made);
  }
  if (Result<bool> ok = run.store.put(job.serial, frame, made->matte); !ok)
    return run.failed(job, frame, ok.error()), Link();
  run.made(job, frame, made->matte);
  run.guided(job, *made);
  return std::move(*made);
}

// Spectral matting works through a camera as a whole and uses all threads for it.
Result<void> make_spectral(capture::TakeReader& take, Run& run, MatteJob& job, int threads) {
  const auto [first, last] = job.reach();
  ProgressPart progress(run.progress, text("mattes of ", job.serial),
                        static_cast<std::size_t>(last - first + 1));
  Result<SpectralTake> spectral = SpectralTake::create(take, job.camera, job.matting->key(),
                                                       spectral_cache(take.layout(), job.serial), threads);
  if (!spectral) return forward(spectral);
  const auto go_on = [&](int) { return !is_cancelled(run.progress); };
  if (Result<void> ok = spectral->prepare(go_on); !ok) return ok;
  if (Result<void> ok = spectral->say(*job.matting); !ok) return ok;
  job.report.idle = spectral->idle();
  const std::vector<bool> reached = spectral->reached(take.frame_count());
  if (Result<void> ok = spectral->propagate(go_on, first, last); !ok) return ok;
  for (int frame = first; frame <= last && !is_cancelled(run.progress); ++frame) {
    progress.advance();
    if (!job.todo[static_cast<std::size_t>(frame)]) continue;
    Result<Image> matte = spectral->matte(*job.matting, frame);
    if (!matte) return forward(matte);
    if (matte->empty()) {
      run.count(job.report.gaps);
      continue;
    }
    if (Result<bool> ok = run.store.put(job.serial, frame, *matte); !ok) return forward(ok);
    run.made(job, frame, *matte);
    run.guided(job, {.frame = frame, .matte = {}, .guided = reached[static_cast<std::size_t>(frame)]});
  }
  return {};
}

// A camera that is worked through as a whole is one run's, of those that share the job.
void give_to_one_run(const MatteTakeOptions& options, MatteJob& job) {
  if (options.of_frames.empty() || !job.matting || !job.matting->spectral()) return;
  const bool mine = job.wanted[static_cast<std::size_t>(options.of_frames.front())];
  for (const int frame : options.of_frames) {
    const std::size_t f = static_cast<std::size_t>(frame);
    job.todo[f] = mine && (job.todo[f] || !job.there[f]);
  }
}

bool is_spectral(const MatteJob& job) { return job.matting && job.matting->spectral(); }
bool by_frames(const MatteJob& job) { return job.matting && !job.matting->spectral(); }

// A camera whose parts are followed is one item, in its order; of the others every frame is one.
struct Item {
  MatteJob* job;
  int frame;  // -1: all of them
};

void make_items(const capture::TakeReader& take, Run& run, std::vector<MatteJob>& jobs, int threads) {
  std::vector<Item> items;
  std::size_t mattes = 0;
  for (MatteJob& job : jobs)
    if (by_frames(job) && job.matting->follows()) {
      mattes += static_cast<std::size_t>(take.frame_count());
      items.push_back({&job, -1});
    }
  for (int f = 0; f < take.frame_count(); ++f)
    for (MatteJob& job : jobs)
      if (by_frames(job) && !job.matting->follows() && job.todo[static_cast<std::size_t>(f)]) {
        ++mattes;
        items.push_back({&job, f});
      }
  if (items.empty()) return;
  ProgressPart progress(run.progress, "mattes", mattes);
  parallel_for(items.size(), threads, [&](std::size_t i) {
    MatteJob& job = *items[i].job;
    if (items[i].frame >= 0) {
      if (!run.stopped()) make(run, job, items[i].frame, {});
      return progress.advance();
    }
    job.matting->follow([&] { return !run.stopped(); },
                        [&](int frame, const CameraMatting::Link& previous) {
                          progress.advance();
                          return make(run, job, frame, previous);
                        });
  });
}

// All cameras at once, instant after instant.
Result<void> make_consistent(capture::TakeReader& take, const MatteTakeOptions& options,
                             const MatteEdits& edits, Run& run, std::vector<MatteJob>& jobs,
                             MatteReport& report) {
  ConsistentTakeOptions consistent{.matting = {.threads = options.threads}, .progress = options.progress};
  std::vector<MatteJob*> cameras;
  for (MatteJob& job : jobs)
    if (job.together && !job.nothing_to_do()) {
      cameras.push_back(&job);
      consistent.cameras.push_back({job.camera, job.todo});
    }
  if (cameras.empty()) return {};
  Result<ConsistentTakeReport> made = consistent_take(take, edits, consistent, run.store);
  if (!made) return forward(made);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    CameraMattes& c = cameras[i]->report;
    c.made = made->cameras[i].made, c.gaps = made->cameras[i].gaps;
    if (c.made > 0) c.consistent = made->cameras[i].mean;
  }
  std::move(made->remarks.begin(), made->remarks.end(), std::back_inserter(report.remarks));
  report.distrusted = made->distrusted;
  return {};
}

Result<void> prepare_all(capture::TakeReader& take, const MatteTakeOptions& options, const MatteEdits& edits,
                         Run& run, std::vector<MatteJob>& jobs, std::vector<std::string>& remarks) {
  std::vector<CameraRecord*> records(jobs.size());
  for (std::size_t i = 0; i < jobs.size(); ++i)
    if (!jobs[i].nothing_to_do()) records[i] = &run.store.camera(jobs[i].serial);
  const auto for_each_job = [&](const char* what, const auto& work) -> Result<void> {
    std::vector<Result<void>> done(jobs.size());
    ProgressPart progress(options.progress, what, jobs.size());
    parallel_for(jobs.size(), options.threads, [&](std::size_t i) {
      if (run.stopped()) return;
      if (records[i]) done[i] = work(*records[i], jobs[i]);
      if (!done[i]) run.stop(done[i].error());
      progress.advance();
    });
    for (const Result<void>& ok : done)  // the first camera's, whichever thread was quicker
      if (!ok) return ok;
    return run.result();
  };
  if (Result<void> ok = for_each_job(
          "keys", [&](CameraRecord& record, MatteJob& job) { return prepare(take, options, record, job); });
      !ok)
    return ok;
  Result<std::string> together = all_cameras_instead(take, options, run.store, edits, jobs);
  if (!together) return forward(together);
  if (!together->empty()) {
    remarks.push_back(std::move(*together));
    for (std::size_t i = 0; i < jobs.size(); ++i)
      if (jobs[i].undecided()) make_together(*records[i], jobs[i]);
  }
  if (Result<void> ok = for_each_job("methods", choose_method); !ok) return ok;
  // Only now that every camera has a key, the record says that mattes are old.
  std::vector<std::string> known;
  for (MatteJob& job : jobs) {
    if (!run.store.find(job.serial)) continue;
    known.push_back(job.serial);
    begin(job, run.store.camera(job.serial));
    if (Result<void> ok = make_folder(take.layout().mattes() / job.serial); !ok) return ok;
  }
  return known.empty() ? Result<void>() : run.store.save(known);
}

// Strokes in frames of which there is no photograph.
void say_unmet(const capture::TakeReader& take, const MatteJob& job, std::vector<std::string>& remarks) {
  const std::vector<FrameRow>& rows = take.rows(job.camera);
  for (const MatteKeyframe& keyframe : job.edits.keyframes) {
    const auto f = static_cast<std::size_t>(keyframe.frame);
    if (!keyframe.strokes.empty() && (f >= rows.size() || !rows[f].media_index))
      remarks.push_back(text("camera '", job.serial, "', frame ", keyframe.frame,
                             ": there is no photograph, so its strokes change nothing"));
  }
}

void say_how(const capture::TakeReader& take, const MatteStore& store, std::vector<MatteJob>& jobs,
             std::vector<std::string>& remarks) {
  for (MatteJob& job : jobs) {
    say_unmet(take, job, remarks);
    const CameraRecord* record = store.find(job.serial);
    job.report.key = record && !record->key.empty() ? record->key : "given";
    job.report.method = record && !record->method.empty() ? record->method : "given";
    for (std::size_t f = 0; f < job.todo.size(); ++f)
      job.report.kept += job.wanted[f] && job.there[f] && !job.todo[f];
    if (job.report.others > 0 && job.edits != CameraEdits())
      remarks.push_back(text("camera '", job.serial, "': ", job.report.others,
                             " mattes of unknown origin are used without what mattes/edits.json says; the "
                             "editor in `play` changes them when it is allowed to"));
  }
}

Result<void> make_all(capture::TakeReader& take, const MatteTakeOptions& options, const MatteEdits& edits,
                      Run& run, std::vector<MatteJob>& jobs, MatteReport& report) {
  if (Result<void> ok = make_consistent(take, options, edits, run, jobs, report); !ok) return ok;
  make_items(take, run, jobs, options.threads);
  for (MatteJob& job : jobs) {
    if (!is_spectral(job) || job.nothing_to_do() || run.stopped()) continue;
    const Result<void> ok = make_spectral(take, run, job, options.threads);
    if (!ok && ok.error().code == ErrorCode::Io) run.stop(ok.error());
    if (!ok && ok.error().code != ErrorCode::Cancelled) run.failed(job, 0, ok.error());
  }
  return run.result();
}

// What the mattes of all cameras say of one another.
Result<void> heal_all(capture::TakeReader& take, const MatteTakeOptions& options, std::vector<MatteJob>& jobs,
                      MatteReport& report) {
  std::vector<int> frames = options.frames;
  for (int f = 0; options.frames.empty() && f < take.frame_count(); ++f) frames.push_back(f);
  Result<std::vector<std::string>> cameras = camera_doubts(take, frames, options.threads, options.progress);
  if (!cameras) return forward(cameras);
  report.camera_doubts = *std::move(cameras);
  if (!report.camera_doubts.empty()) return {};
  Result<std::vector<HealedCamera>> healed = heal_take(take, frames, options.threads, options.progress);
  if (!healed) return forward(healed);
  report.healed = std::move(*healed);
  for (const HealedCamera& camera : report.healed)
    for (MatteJob& job : jobs)
      if (job.serial == camera.serial)  // what the key refused to make is there now
        std::erase_if(job.failures, [&](const auto& failure) {
          return std::count(camera.filled.begin(), camera.filled.end(), failure.first) > 0;
        });
  return {};
}

}  // namespace

Result<MatteReport> matte_take(const MatteTakeOptions& options) {
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(options.take);
  if (!opened) return forward(opened);
  const Result<Claim> claim = claim_take(options.take, options.progress);
  if (!claim) return forward(claim);
  Result<std::vector<std::string>> added = settle_added(*opened, options.hide_added, options.threads);
  if (!added) return forward(added);
  Result<MatteReport> report = matte_take(**opened, options);
  if (report) report->remarks.insert(report->remarks.begin(), added->begin(), added->end());
  return report;
}

Result<MatteReport> matte_take(capture::TakeReader& take, const MatteTakeOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  Result<MatteEdits> edits = load_matte_edits(take.layout().edits());
  if (!edits) return forward(edits);
  for (const auto& [serial, camera] : edits->cameras)
    if (camera_index(take.rig(), serial) < 0)
      return fail(ErrorCode::BadData, text(take.layout().edits().string(), " speaks of a camera '", serial,
                                           "' that the take does not have"));
  sweep_temporaries(take.layout().mattes());
  Result<std::unique_ptr<MatteStore>> store = MatteStore::open(take.layout());
  if (!store) return forward(store);
  Result<std::vector<MatteJob>> jobs = matte_jobs(take, **store, *edits, options);
  if (!jobs) return forward(jobs);
  Run run(**store, options.progress);
  MatteReport report;
  if (Result<void> ok = prepare_all(take, options, *edits, run, *jobs, report.remarks); !ok)
    return forward(ok);
  for (MatteJob& job : *jobs) give_to_one_run(options, job);
  say_how(take, **store, *jobs, report.remarks);
  Result<void> made = make_all(take, options, *edits, run, *jobs, report);
  std::vector<std::string> known;
  for (const MatteJob& job : *jobs)
    if (job.matting && !job.shapes.empty()) note_doubts(job, (*store)->camera(job.serial));
  for (const MatteJob& job : *jobs)
    for (const std::string& idle : job.report.idle)
      report.remarks.push_back(text("camera '", job.serial, "', ", idle));
  for (const MatteJob& job : *jobs)
    if (job.report.made > 0) known.push_back(job.serial);
  if (Result<void> ok = known.empty() ? Result<void>() : (*store)->save(known); !ok && made) made = ok;
  if (!made) return forward(made);
  if (options.heal && options.cameras.empty()) {
    if (Result<void> ok = heal_all(take, options, *jobs, report); !ok) return forward(ok);
    store = MatteStore::open(take.layout());
    if (!store) return forward(store);
  }

  Result<std::vector<MatteDoubt>> doubts = doubts_of(take, **store, *jobs);
  if (!doubts) return forward(doubts);
  report.doubts = std::move(*doubts);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  for (MatteJob& job : *jobs) {
    std::sort(job.failures.begin(), job.failures.end());
    for (auto& [frame, sentence] : job.failures) job.report.failures.push_back(std::move(sentence));
    report.made += job.report.made;
    report.cameras.push_back(std::move(job.report));
  }
  if (report.made) report.seconds_per_frame = report.seconds / report.made;
  if (options.check)
    if (Result<void> ok = check_mattes(take, options, report); !ok) return forward(ok);
  return report;
}

}  // namespace floatstage::pipeline
