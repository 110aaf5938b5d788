#include "pipeline/process/mesh_maker.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include <nlohmann/json.hpp>

#include "capture/added_file.h"
#include "core/bounded_queue.h"
#include "core/file.h"
#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/text.h"
#include "pipeline/chosen_take.h"
#include "pipeline/hull_inside_bars.h"
#include "pipeline/hull_record.h"
#include "pipeline/made_files.h"
#include "pipeline/matte/camera_doubts.h"
#include "pipeline/matte/contradiction.h"
#include "pipeline/matte/heal_mattes.h"
#include "pipeline/occluders.h"
#include "pipeline/process/denied_mattes.h"
#include "pipeline/process/silhouette_faults.h"
#include "pipeline/progress.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr double kMuchWithinProps = 0.01;  // of somebody: rims of masks are a tenth of it

// Collects what parallel items of one stage did; the first fatal error (disk, permission) stops the stage.
class Collector {
 public:
  explicit Collector(const Progress* progress) : progress_(progress) {}
  void made() {
    std::lock_guard lock(mutex_);
    ++report_.made;
  }
  void kept(bool others) {
    std::lock_guard lock(mutex_);
    ++report_.kept;
    report_.others += others;
  }
  void failed(const Error& e, int item) {
    std::lock_guard lock(mutex_);
    if (e.code == ErrorCode::Io && !fatal_) fatal_ = e;
    failures_.emplace_back(item, e.message);
  }
  bool stopped() const {
    std::lock_guard lock(mutex_);
    return fatal_.has_value() || is_cancelled(progress_);
  }
  /// The report with failures in item order, whatever thread met them first.
  Result<StageReport> finish() {
    if (fatal_) return Unexpected{*fatal_};
    if (is_cancelled(progress_)) return cancelled();
    std::sort(failures_.begin(), failures_.end());
    for (auto& f : failures_) report_.failures.push_back(std::move(f.second));
    return std::move(report_);
  }

 private:
  const Progress* const progress_;
  mutable std::mutex mutex_;
  StageReport report_;
  std::optional<Error> fatal_;
  std::vector<std::pair<int, std::string>> failures_;
};

bool nobody_on_stage(const std::vector<Matte>& mattes) {
  return std::all_of(mattes.begin(), mattes.end(),
                     [](const Matte& m) { return m.empty() || coverage(m) == 0; });
}

// One frame's mesh and its line in the record.
struct FrameHull {
  MeshEntry entry;
  json report;
};

/// What hulls keep from frame to frame, one set for each worker.
class HullWorkspaces {
 public:
  struct Slot {
    recon::HullWorkspace workspace;
    recon::HullReport report;
  };
  std::unique_ptr<Slot> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<Slot>();
    std::unique_ptr<Slot> slot = std::move(free_.back());
    free_.pop_back();
    return slot;
  }
  void give_back(std::unique_ptr<Slot> slot) {
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(slot));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Slot>> free_;
};

// The mesh of these mattes, left in the slot.
Result<json> make_mesh(const Rig& rig, const std::vector<Matte>& mattes, const capture::AddedFile& added,
                       const recon::HullOptions& options, HullWorkspaces::Slot& slot) {
  json iou = json::object();
  if (nobody_on_stage(mattes)) {
    slot.report.clear();
    return json{{"volume", 0}, {"empty", true}, {"silhouette_iou", iou}, {"seconds", 0}};
  }
  recon::HullReport& hull = slot.report;
  if (Result<void> ok = hull_inside_bars(rig, mattes, added, options, slot.workspace, hull); !ok)
    return forward(ok);
  for (std::size_t c = 0; c < hull.silhouette_iou.size(); ++c)
    iou[rig.cameras[c].serial] = hull.silhouette_iou[c];  // NaN becomes null: this camera had no matte
  json report = {{"volume", hull.volume},          {"empty", hull.mesh.empty()},
                 {"trusted", !hull.contradictory}, {"cut", hull.cut},
                 {"crumbs", hull.crumbs},          {"remarks", hull.remarks},
                 {"seconds", hull.seconds},        {"silhouette_iou", std::move(iou)}};
  if (json silhouettes = silhouettes_json(rig, hull.verdicts); !silhouettes.empty())
    report["silhouettes"] = std::move(silhouettes);
  if (hull.cleanup) report["cleanup"] = cleanup_json(rig, *hull.cleanup);
  report.update(denied_json(rig, mattes, hull, options));
  return report;
}

/// Puts finished meshes into their places while the next ones are made: a disk takes some milliseconds for
/// each, in which a core would wait. Holds two meshes a thread at most.
class MeshWriters {
 public:
  struct Finished {
    std::size_t item = 0;  ///< of the run
    int frame = 0;
    Mesh mesh;
    FrameHull hull;
  };
  using Write = std::function<void(Finished)>;

  /// `write` is called by any of the threads.
  MeshWriters(int workers, Write write)
      : queue_(static_cast<std::size_t>(threads_for(workers)), QueuePolicy::Block), write_(std::move(write)) {
    for (int i = 0; i < threads_for(workers); ++i) threads_.emplace_back([this] { work(); });
  }
  ~MeshWriters() { join(); }
  void add(Finished one) { queue_.push(std::move(one)); }
  /// Everything that was added has been written when this returns. Throws what `write` threw.
  void finish() {
    join();
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  static constexpr int kMost = 4;  // files at once: disks gain nothing from more
  static int threads_for(int workers) { return std::clamp(workers, 1, kMost); }

  void work() {
    while (std::optional<Finished> one = queue_.pop()) {
      try {
        write_(std::move(*one));
      } catch (...) {
        const std::lock_guard lock(mutex_);
        if (!thrown_) thrown_ = std::current_exception();
      }
    }
  }
  void join() {
    queue_.close();
    for (std::thread& thread : threads_) thread.join();
    threads_.clear();
  }

  BoundedQueue<Finished> queue_;
  const Write write_;
  std::mutex mutex_;
  std::exception_ptr thrown_;
  std::vector<std::thread> threads_;
};

// Makes the meshes of a take that are missing or were made from something else.
class MeshMaker {
 public:
  MeshMaker(capture::TakeReader& take, const ProcessOptions& options, const recon::HullOptions& hull,
            MeshRecord record)
      : take_(take),
        options_(options),
        hull_(hull),
        record_(std::move(record)),
        journal_(take.layout().meshes_journal()),
        collector_(options.progress) {}

  Result<void> run(const std::vector<int>& frames, ProcessReport& report) {
    if (Result<void> ok = make_folder(take_.layout().meshes()); !ok) return forward(ok);
    record_.options = describe(hull_);
    frames_ = frames;
    if (Result<void> ok = save_mesh_record(record_, take_.layout()); !ok) return forward(ok);
    journal_.remove();
    hull_.quality_step = 4;                   // the rows between tell the same
    if (!everybody()) hull_.quality = false;  // silhouettes with what may be hidden are no measure
    hull_.threads = frames.size() > 1 ? 1 : options_.threads;  // over frames, or inside the one
    Result<std::unique_ptr<MatteHealer>> healer = MatteHealer::open(take_);
    if (!healer) return forward(healer);
    healer_ = std::move(*healer);
    healer_->ask_first([this] { return cameras_agree(); });
    Result<capture::AddedFile> added = capture::load_added(take_.layout());
    if (!added) return forward(added);
    added_ = std::move(*added);
    Result<Occluders> occluders = load_occluders(take_.layout(), take_.rig());
    if (!occluders) return forward(occluders);
    occluders_ = std::move(*occluders);
    inputs_ = hash_of_hull_inputs(take_.manifest().rig_sha256, hull_, added_, occluders_.hash);
    std::vector<std::optional<FrameHull>> hulls(frames.size());
    others_.assign(frames.size(), 0);
    ProgressPart progress(options_.progress, "meshes", frames.size());
    const auto failed = [&](const Error& e, int frame) {
      collector_.failed({e.code, text("frame ", frame, ": ", e.message)}, frame);
    };
    const int workers = options_.threads > 0 ? options_.threads : default_threads();
    MeshWriters writers(workers, [&](MeshWriters::Finished one) {
      if (Result<void> ok = write(one); !ok) return failed(ok.error(), one.frame);
      hulls[one.item] = std::move(one.hull);
      collector_.made();
    });
    parallel_for(frames.size(), workers, [&](std::size_t i) {
      if (collector_.stopped()) return;
      if (Result<void> ok = work(i, frames[i], writers); !ok) failed(ok.error(), frames[i]);
      progress.advance();
    });
    writers.finish();
    const bool any_made =
        std::any_of(hulls.begin(), hulls.end(), [](const auto& hull) { return hull.has_value(); });
    if ((any_made || options_.gathered) && !collector_.stopped())
      if (const Result<bool> agree = cameras_agree(); !agree) return forward(agree);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (others_[i]) record_.meshes.erase(frames[i]);
      if (!hulls[i]) continue;
      record_.reports[frames[i]] = std::move(hulls[i]->report);
      record_.meshes[frames[i]] = std::move(hulls[i]->entry);
    }
    if (Result<void> ok = save_mesh_record(record_, take_.layout()); !ok) return forward(ok);
    journal_.remove();
    Result<StageReport> done = collector_.finish();
    if (!done) return forward(done);
    report.meshes = std::move(*done);
    Result<std::vector<HealedCamera>> healed = healer_->finish();
    if (!healed) return forward(healed);
    report.healed = std::move(*healed);
    if (camera_doubts_) report.camera_doubts = *camera_doubts_;
    const fs::path pictures = take_.layout().meshes() / "faults";
    if (Result<void> ok = evidence_.save(take_, pictures); !ok) return ok;
    HullDoubts doubts = doubts_in(record_.reports, pictures);
    if (Result<void> ok = keep_pictures(doubts.faults, pictures); !ok) return ok;
    report.faults = std::move(doubts.faults);
    report.contradictory_frames = doubts.contradictory;
    report.cut_frames = doubts.cut;
    report.poor_frames = doubts.poor;
    report.cleanup = std::move(doubts.cleanup);
    report.empty_frames = count_empty(frames);
    remark_on_props(report);
    Result<std::optional<MatteDoubt>> denied =
        contradiction_in(take_, denials_in(record_.reports), report.meshes.made > 0);
    if (!denied) return forward(denied);
    std::set<int> judged;
    for (const auto& [frame, said] : record_.reports) judged.insert(frame);
    if (everybody())
      if (Result<void> ok = keep_denials(take_.layout(), *denied, judged); !ok) return ok;
    if (*denied) add_contradiction(std::move(**denied), report.doubts);
    return {};
  }

 private:
  // What is left of a sum is nothing to mend.
  bool everybody() const { return take_.layout().labels().empty(); }

  Result<void> work(std::size_t item, int frame, MeshWriters& writers) {
    const Result<MeshState> state = state_of_mesh(take_.layout(), take_.rig(), record_, inputs_, frame);
    if (!state) return forward(state);
    if (*state == MeshState::Others) return others_[item] = 1, collector_.kept(true), Result<void>();
    if (*state == MeshState::Kept && !options_.redo) return collector_.kept(false), Result<void>();
    return make(item, frame, writers);
  }

  Result<void> make(std::size_t item, int frame, MeshWriters& writers) {
    MeshWriters::Finished finished{.item = item, .frame = frame, .mesh = {}, .hull = {}};
    FrameHull& made = finished.hull;
    Result<std::vector<Matte>> mattes = load_mattes(take_, frame, &made.entry.mattes);
    if (mattes) mattes = silhouettes_of_labels(take_, frame, std::move(*mattes), hull_.threads);
    if (mattes) mattes = behind_props(frame, std::move(*mattes));
    if (!mattes) return forward(mattes);
    std::unique_ptr<HullWorkspaces::Slot> slot = workspaces_.take();
    Result<json> report = make_mesh(take_.rig(), *mattes, added_, hull_, *slot);
    if (report && !report->at("empty") && everybody() && !occluders_.props.any())
      report = heal(frame, *mattes, *slot, std::move(*report), made);
    if (report && report->contains("silhouettes")) evidence_.note(frame, slot->report, *mattes);
    if (report) finished.mesh = slot->report.mesh;
    workspaces_.give_back(std::move(slot));
    if (!report) return forward(report);
    made.entry.inputs = inputs_;
    made.report = std::move(*report);
    writers.add(std::move(finished));
    return {};
  }

  Result<std::vector<Matte>> behind_props(int frame, std::vector<Matte> mattes) {
    recon::Props::Within within;
    Result<std::vector<Matte>> silhouettes =
        occluders_.props.silhouettes(take_.rig(), std::move(mattes), hull_.threads, &within);
    const std::lock_guard lock(within_mutex_);
    if (within.share > within_.share || (within.share == within_.share && frame < within_frame_))
      within_ = within, within_frame_ = frame;
    return silhouettes;
  }

  // What to say of it, if anything.
  void remark_on_props(ProcessReport& report) const {
    if (within_.share <= kMuchWithinProps) return;
    report.remarks.push_back(
        text("camera '", take_.rig().cameras[static_cast<std::size_t>(within_.camera)].serial,
             "' shows somebody within what stands on the stage (occluders), ",
             std::lround(100 * within_.share), " % of all in frame ", within_frame_,
             ": its shadow there, or a mask that is larger than what it covers; look at the matte"));
  }

  Result<void> write(MeshWriters::Finished& one) {
    const fs::path file = take_.layout().mesh(one.frame), whole = temporary_name(file);
    if (Result<void> ok = save_ply(one.mesh, whole); !ok) return ok;
    const Result<std::optional<std::string>> hash = hash_of(whole);
    if (!hash) return forward(hash);
    one.hull.entry.mesh = hash->value_or("");
    // It is ours before it is there: what has no entry is somebody else's.
    Result<void> ok = journal_.add(to_journal(one.frame, one.hull.entry, one.hull.report));
    std::error_code error;
    if (ok) fs::rename(whole, file, error);
    if (error) ok = fail(ErrorCode::Io, text("cannot write ", file.string(), ": ", error.message()));
    if (!ok) fs::remove(whole, error);
    return ok;
  }

  // The mesh once more, where mattes were healed.
  Result<json> heal(int frame, std::vector<Matte>& mattes, HullWorkspaces::Slot& slot, json report,
                    FrameHull& made) {
    const Result<bool> healed = healer_->heal(frame, slot.report, hull_, mattes, made.entry.mattes);
    if (!healed) return forward(healed);
    if (!*healed) return report;
    return make_mesh(take_.rig(), mattes, added_, hull_, slot);
  }

  /// Whether all cameras' pictures are what rig and clock say; else they are no evidence to cut mattes by.
  Result<bool> cameras_agree() {
    std::call_once(asked_, [&] {
      if (everybody()) camera_doubts_ = camera_doubts(take_, frames_, options_.threads, options_.progress);
    });
    if (!camera_doubts_) return forward(camera_doubts_);
    return camera_doubts_->empty();
  }

  /// Frames whose mesh holds no subject, whenever it was made. Those that somebody put there are read: the
  /// record tells nothing of them.
  int count_empty(const std::vector<int>& frames) const {
    return static_cast<int>(std::count_if(frames.begin(), frames.end(), [&](int frame) {
      const auto report = record_.reports.find(frame);
      if (record_.meshes.contains(frame) && report != record_.reports.end() &&
          report->second.contains("empty"))
        return report->second.at("empty") == true;
      const Result<Mesh> mesh = load_ply(take_.layout().mesh(frame));
      return mesh && mesh->empty();
    }));
  }

  capture::TakeReader& take_;
  const ProcessOptions& options_;
  recon::HullOptions hull_;
  capture::AddedFile added_;
  Occluders occluders_;
  std::mutex within_mutex_;
  recon::Props::Within within_;  // the most of any frame
  int within_frame_ = 0;
  std::string inputs_;  // what is common to all frames, as a hash
  MeshRecord record_;
  Journal journal_;
  Collector collector_;
  HullWorkspaces workspaces_;
  EvidenceCollector evidence_;
  std::unique_ptr<MatteHealer> healer_;
  std::vector<int> frames_;
  std::once_flag asked_;
  Result<std::vector<std::string>> camera_doubts_ = std::vector<std::string>();
  std::vector<char> others_;  // by item: the mesh is somebody else's
};

}  // namespace

Result<void> make_meshes(capture::TakeReader& take, const ProcessOptions& options,
                         const recon::HullOptions& hull, MeshRecord record, const std::vector<int>& frames,
                         ProcessReport& report) {
  return MeshMaker(take, options, hull, std::move(record)).run(frames, report);
}

}  // namespace floatstage::pipeline
