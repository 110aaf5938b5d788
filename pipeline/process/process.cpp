#include "pipeline/process/process.h"

#include <algorithm>
#include <chrono>
#include <mutex>

#include <nlohmann/json.hpp>

#include "capture/take.h"
#include "core/file.h"
#include "core/log.h"
#include "core/mesh_io.h"
#include "core/parallel.h"
#include "core/png.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/hull_record.h"
#include "pipeline/keying.h"
#include "pipeline/progress.h"
#include "pipeline/scene_loader.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Collects what parallel items of one stage did; the first fatal error (disk, permission) stops the stage.
class Collector {
 public:
  explicit Collector(const Progress* progress) : progress_(progress) {}
  void made() {
    std::lock_guard lock(mutex_);
    ++report_.made;
  }
  void kept() {
    std::lock_guard lock(mutex_);
    ++report_.kept;
  }
  void gap() {
    std::lock_guard lock(mutex_);
    ++report_.gaps;
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

Result<KeyingRecord> settle_keying(capture::TakeReader& take, const ProcessOptions& options) {
  Result<std::optional<KeyingRecord>> before = load_keying(take.layout(), take.rig());
  if (!before) return forward(before);
  const std::string wanted = options.key.value_or(*before ? (*before)->key : "chroma");
  if (*before && (*before)->key == wanted) return std::move(**before);
  if (*before && !options.redo)
    return fail(ErrorCode::AlreadyExists,
                text(take.layout().folder().string(), " was keyed with '", (*before)->key, "', not '", wanted,
                     "'; add --redo to make its mattes and meshes again"));
  KeyingRecord record{wanted, {}};
  for (std::size_t i = 0; i < take.rig().cameras.size(); ++i) {
    Result<std::unique_ptr<matting::Keyer>> keyer = keyer_for(take, static_cast<int>(i), wanted);
    if (!keyer) return forward(keyer);
    record.specs.push_back((*keyer)->spec());
  }
  if (Result<void> ok = clear_for_redo(take.layout().mattes(), take.layout().edits()); !ok)
    return forward(ok);
  if (Result<void> ok = clear_for_redo(take.layout().meshes()); !ok) return forward(ok);
  if (Result<void> ok = make_folder(take.layout().mattes()); !ok) return forward(ok);
  if (Result<void> ok = save_keying(record, take.layout(), take.rig()); !ok) return forward(ok);
  return record;
}

Result<StageReport> make_mattes(capture::TakeReader& take, const KeyingRecord& record,
                                const ProcessOptions& options) {
  const std::vector<RigCamera>& cameras = take.rig().cameras;
  std::vector<std::unique_ptr<matting::Keyer>> keyers;
  for (std::size_t i = 0; i < record.specs.size(); ++i) {
    Result<std::unique_ptr<matting::Keyer>> keyer = keyer_for(take, static_cast<int>(i), record.specs[i]);
    if (!keyer) return forward(keyer);
    keyers.push_back(std::move(*keyer));
    if (Result<void> ok = make_folder(take.layout().mattes() / cameras[i].serial); !ok) return forward(ok);
  }
  const std::size_t items = static_cast<std::size_t>(take.frame_count()) * cameras.size();
  Collector collector(options.progress);
  ProgressPart progress(options.progress, "mattes", items);
  parallel_for(items, options.threads, [&](std::size_t item) {
    if (collector.stopped()) return;
    const int frame = static_cast<int>(item / cameras.size());
    const std::size_t camera = item % cameras.size();
    const fs::path file = take.layout().matte(cameras[camera].serial, frame);
    auto work = [&]() -> Result<void> {
      if (fs::exists(file) || keyers.empty()) return collector.kept(), Result<void>();
      Result<Frame> photograph = take.frame(static_cast<int>(camera), frame);
      if (!photograph) return forward(photograph);
      if (photograph->empty()) return collector.gap(), Result<void>();  // a gap: this camera does not know
      Result<Matte> matte = keyers[camera]->key(*photograph);
      if (!matte) return forward(matte);
      if (Result<void> ok = save_png(to_image(*matte), file); !ok) return ok;
      collector.made();
      return {};
    };
    if (Result<void> ok = work(); !ok)
      collector.failed({ok.error().code, text("camera '", cameras[camera].serial, "', frame ", frame, ": ",
                                              ok.error().message)},
                       static_cast<int>(item));
    progress.advance();
  });
  return collector.finish();
}

bool nobody_on_stage(const std::vector<Matte>& mattes) {
  return std::all_of(mattes.begin(), mattes.end(),
                     [](const Matte& m) { return m.empty() || coverage(m) == 0; });
}

// meshes/hull.json: the options, and a line a frame. Written once the stage is done. The answer: the options
// to go on with.
Result<recon::HullOptions> settle_hull_options(capture::TakeReader& take, const ProcessOptions& options) {
  const fs::path file = take.layout().hull_report();
  Result<std::string> before = read_file(file);
  if (!before && before.error().code != ErrorCode::NotFound) return forward(before);
  const json old = before ? json::parse(*before, nullptr, false) : json();
  const json recorded = old.is_object() ? old.value("options", json()) : json();
  recon::HullOptions hull = *hull_options(HullWords());
  if (options.hull) {
    hull = *options.hull;
  } else if (std::optional<recon::HullOptions> earlier = parse_hull_options(recorded)) {
    hull = *earlier;
  }
  const json wanted = describe(hull);
  if (before) {
    if (recorded == wanted) return hull;
    if (!options.redo)
      return fail(
          ErrorCode::AlreadyExists,
          text(take.layout().meshes().string(), " was made with other hull options (", recorded.dump(),
               "); leave the flags out to go on with them, or add --redo to make its meshes again"));
    if (Result<void> ok = clear_for_redo(take.layout().meshes()); !ok) return forward(ok);
  }
  if (Result<void> ok = make_folder(take.layout().meshes()); !ok) return forward(ok);
  if (Result<void> ok = write_file(file, json{{"options", wanted}}.dump(2) + "\n"); !ok) return forward(ok);
  return hull;
}

struct FrameHull {
  bool made = false, empty = false;
  double volume = 0, seconds = 0;
  std::vector<double> iou;
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

Result<FrameHull> make_mesh(capture::TakeReader& take, int frame, const recon::HullOptions& options,
                            HullWorkspaces::Slot& slot) {
  Result<std::vector<Matte>> mattes = load_mattes(take, frame);
  if (!mattes) return forward(mattes);
  const fs::path file = take.layout().mesh(frame);
  FrameHull result{.made = true, .empty = nobody_on_stage(*mattes), .iou = {}};
  if (result.empty) {
    if (Result<void> ok = save_ply({}, file); !ok) return forward(ok);
    return result;
  }
  recon::HullReport& hull = slot.report;
  if (Result<void> ok = recon::visual_hull(take.rig(), *mattes, options, slot.workspace, hull); !ok)
    return forward(ok);
  if (Result<void> ok = save_ply(hull.mesh, file); !ok) return forward(ok);
  result.empty = hull.mesh.empty();
  result.volume = hull.volume;
  result.seconds = hull.seconds;
  result.iou = hull.silhouette_iou;
  return result;
}

Result<void> save_hull_report(capture::TakeReader& take, const recon::HullOptions& options,
                              const std::vector<FrameHull>& hulls) {
  json report = {{"options", describe(options)}, {"frames", json::object()}};
  if (Result<std::string> before = read_file(take.layout().hull_report())) {
    const json old = json::parse(*before, nullptr, false);
    if (old.is_object() && old.contains("frames") && old["frames"].is_object())
      report["frames"] = old["frames"];
  }
  for (std::size_t f = 0; f < hulls.size(); ++f) {
    if (!hulls[f].made) continue;
    json iou = json::object();
    for (std::size_t c = 0; c < hulls[f].iou.size(); ++c)
      iou[take.rig().cameras[c].serial] = hulls[f].iou[c];  // NaN becomes null: this camera had no matte
    report["frames"][std::to_string(f)] = {{"volume", hulls[f].volume},
                                           {"empty", hulls[f].empty},
                                           {"silhouette_iou", iou},
                                           {"seconds", hulls[f].seconds}};
  }
  return write_file(take.layout().hull_report(), report.dump(2) + "\n");
}

Result<StageReport> make_meshes(capture::TakeReader& take, const ProcessOptions& options) {
  Result<recon::HullOptions> settled = settle_hull_options(take, options);
  if (!settled) return forward(settled);
  const std::size_t frames = static_cast<std::size_t>(take.frame_count());
  recon::HullOptions each = *settled;
  each.threads = frames > 1 ? 1 : options.threads;  // over frames when there are several, else inside the one
  Collector collector(options.progress);
  std::vector<FrameHull> hulls(frames);
  HullWorkspaces workspaces;
  ProgressPart progress(options.progress, "meshes", frames);
  parallel_for(frames, options.threads, [&](std::size_t frame) {
    if (collector.stopped()) return;
    if (fs::exists(take.layout().mesh(static_cast<int>(frame)))) {
      collector.kept();
    } else {
      std::unique_ptr<HullWorkspaces::Slot> slot = workspaces.take();
      Result<FrameHull> hull = make_mesh(take, static_cast<int>(frame), each, *slot);
      workspaces.give_back(std::move(slot));
      if (hull) {
        hulls[frame] = std::move(*hull);
        collector.made();
      } else {
        collector.failed({hull.error().code, text("frame ", frame, ": ", hull.error().message)},
                         static_cast<int>(frame));
      }
    }
    progress.advance();
  });
  if (Result<void> ok = save_hull_report(take, *settled, hulls); !ok) return forward(ok);
  return collector.finish();
}

// Frames whose mesh holds no subject, whenever it was made.
int count_empty(const capture::TakeReader& take) {
  int empty = 0;
  for (int f = 0; f < take.frame_count(); ++f) {
    Result<Mesh> mesh = load_ply(take.layout().mesh(f));
    empty += mesh && mesh->empty();
  }
  return empty;
}

}  // namespace

Result<ProcessReport> process_take(const ProcessOptions& options) {
  const auto begin = std::chrono::steady_clock::now();
  Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(options.take);
  if (!opened) return forward(opened);
  capture::TakeReader& take = **opened;
  ProcessReport report{.frames = take.frame_count(),
                       .cameras = static_cast<int>(take.rig().cameras.size()),
                       .mattes = {},
                       .meshes = {}};

  sweep_temporaries(take.layout().mattes());
  sweep_temporaries(take.layout().meshes());
  Result<KeyingRecord> keying = settle_keying(take, options);
  if (!keying) return forward(keying);
  Result<StageReport> mattes = make_mattes(take, *keying, options);
  if (!mattes) return forward(mattes);
  report.mattes = std::move(*mattes);
  Result<StageReport> meshes = make_meshes(take, options);
  if (!meshes) return forward(meshes);
  report.meshes = std::move(*meshes);

  report.empty_frames = count_empty(take);
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return report;
}

}  // namespace floatstage::pipeline
