#include "pipeline/plan/process_plan.h"

#include <algorithm>
#include <cstdio>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include "capture/added_file.h"
#include "capture/sha256.h"
#include "core/claim.h"
#include "core/file.h"
#include "core/rig_io.h"
#include "core/text.h"
#include "pipeline/derived_files.h"
#include "pipeline/hull_record.h"
#include "pipeline/label_record.h"
#include "pipeline/matte/all_cameras_instead.h"
#include "pipeline/matte/label_take.h"
#include "pipeline/matte/matte_job.h"
#include "pipeline/matte/settle_added.h"
#include "pipeline/occluders.h"
#include "pipeline/plan/take_view.h"
#include "pipeline/process/mesh_maker.h"

namespace floatstage::pipeline {
namespace {

namespace fs = std::filesystem;

// What a photograph costs before this plan has measured it, and what it takes on disk
// (docs/constants.md).
constexpr double kMatteSeconds = 0.4, kMeshSeconds = 0.02, kGatherSeconds = 0.001;
constexpr double kMatteBytesAPixel = 0.02;
constexpr std::uint64_t kMeshBytes = 400'000;

std::vector<int> wanted_frames(const capture::TakeReader& take, const std::vector<int>& asked) {
  std::vector<int> frames = asked;
  for (int f = 0; asked.empty() && f < take.frame_count(); ++f) frames.push_back(f);
  return frames;
}

// Bytes of a camera's recording, a frame.
double media_bytes(const capture::TakeReader& take, const std::string& serial) {
  for (const TakeManifest::Camera& camera : take.manifest().cameras) {
    std::error_code error;
    const std::uintmax_t bytes = fs::file_size(take.layout().folder() / camera.media, error);
    if (camera.serial == serial && !error)
      return static_cast<double>(bytes) / std::max(1, take.frame_count());
  }
  return 0;
}

double pixels_of(const capture::TakeReader& take, const std::string& serial) {
  const RigCamera& camera = take.rig().cameras[static_cast<std::size_t>(camera_index(take.rig(), serial))];
  return static_cast<double>(camera.model.width) * camera.model.height;
}

std::vector<std::string> serials_of(const Rig& rig) {
  std::vector<std::string> all;
  for (const RigCamera& camera : rig.cameras) all.push_back(camera.serial);
  return all;
}

Result<std::string> inputs_of(const capture::TakeReader& take) {
  std::string from = take.manifest().rig_sha256;
  for (const fs::path& file : {take.layout().manifest(), take.layout().edits()}) {
    const Result<std::optional<std::string>> hash = hash_of(file);
    if (!hash) return forward(hash);
    from += hash->value_or("none");
  }
  return capture::sha256(from);
}

Result<Plan> empty_plan(const capture::TakeReader& take) {
  Result<std::string> inputs = inputs_of(take);
  if (!inputs) return forward(inputs);
  Plan plan;
  plan.made_from = std::move(*inputs);
  plan.frame_rate = take.manifest().frame_rate;
  plan.cameras = static_cast<int>(take.rig().cameras.size());
  return plan;
}

// Whether mattes of a camera need one another.
bool is_whole(const MatteJob& job) { return job.how == "spectral" || job.edits != CameraEdits(); }

void add_matte_item(const capture::TakeReader& take, PlanItem item, const MatteJob& job,
                    const std::vector<std::string>& cameras, Plan& plan) {
  item.stage = "mattes";
  item.id = text("mattes-", cameras.size() > 1 ? "all" : job.serial, "-", item.first);
  item.cameras = cameras;
  item.with = {{"how", job.how}, {"guide", job.guide}, {"together", job.together ? "yes" : "no"}};
  item.units = static_cast<double>(item.count) * static_cast<double>(cameras.size());
  for (const std::string& serial : cameras) {
    item.bytes_in += static_cast<std::uint64_t>(media_bytes(take, serial) * item.count);
    const double pixels = pixels_of(take, serial) * item.count;
    item.bytes_out += static_cast<std::uint64_t>(kMatteBytesAPixel * pixels);
    item.seconds += kMatteSeconds * 1e-6 * pixels;
  }
  plan.items.push_back(std::move(item));
}

// One item that puts files in their places; nothing where there is nothing to put.
void add_last(const char* stage, double units, Plan& plan) {
  PlanItem item;
  item.id = item.stage = stage;
  item.units = units;
  item.seconds = kGatherSeconds * units;
  plan.items.push_back(std::move(item));
}

// The items that make mattes; returns the frames at which something is to be made.
Result<std::set<int>> add_mattes(capture::TakeReader& take, const MatteTakeOptions& options, int chunk,
                                 Plan& plan) {
  Result<MatteEdits> edits = load_matte_edits(take.layout().edits());
  if (!edits) return forward(edits);
  Result<std::unique_ptr<MatteStore>> store = MatteStore::open(take.layout());
  if (!store) return forward(store);
  Result<std::vector<MatteJob>> jobs = matte_jobs(take, **store, *edits, options);
  if (!jobs) return forward(jobs);
  const Result<std::string> instead = all_cameras_instead(take, options, **store, *edits, *jobs);
  if (!instead) return forward(instead);
  if (!instead->empty()) plan.remarks.push_back(*instead);
  for (MatteJob& job : *jobs) job.together = job.together || (job.undecided() && !instead->empty());
  const std::vector<int> wanted = wanted_frames(take, options.frames);
  std::set<int> touched;
  std::vector<std::string> together;
  const MatteJob* one_of_them = nullptr;
  for (const MatteJob& job : *jobs) {
    if (!job.stale.empty()) plan.stale[job.serial] = job.stale;
    if (job.nothing_to_do()) continue;
    for (const int frame : wanted)
      if (job.todo[static_cast<std::size_t>(frame)]) touched.insert(frame);
    if (job.together) {
      together.push_back(job.serial), one_of_them = &job;
      continue;
    }
    const int most = is_whole(job) ? static_cast<int>(wanted.size()) : chunk;
    for (PlanItem& piece : pieces_of(wanted, most)) {
      const std::vector<int> frames = piece.frames();
      if (std::any_of(frames.begin(), frames.end(),
                      [&](int frame) { return job.todo[static_cast<std::size_t>(frame)]; }))
        add_matte_item(take, std::move(piece), job, {job.serial}, plan);
    }
  }
  if (one_of_them)
    for (PlanItem& piece : pieces_of(wanted, static_cast<int>(wanted.size())))
      add_matte_item(take, std::move(piece), *one_of_them, together, plan);
  return touched;
}

double units_of(const Plan& plan) {
  double units = 0;
  for (const PlanItem& item : plan.items) units += item.units;
  return units;
}

// Of all, or of the labels that are chosen.
Result<TakeLayout> chosen_layout(const ProcessOptions& options) {
  return choose_labels(TakeLayout(options.take), options.labels.only, options.labels.without);
}

Result<void> add_meshes(const capture::TakeReader& take, const ProcessOptions& options, int chunk,
                        const std::set<int>& touched, Plan& plan) {
  const Result<TakeLayout> layout = chosen_layout(options);
  if (!layout) return forward(layout);
  const Result<MeshRecord> record = load_mesh_record(*layout);
  if (!record) return forward(record);
  const Result<recon::HullOptions> hull = settle_hull_options(take, options, *record);
  if (!hull) return forward(hull);
  const Result<capture::AddedFile> added = capture::load_added(take.layout());
  if (!added) return forward(added);
  const Result<Occluders> occluders = load_occluders(take.layout(), take.rig());
  if (!occluders) return forward(occluders);
  const std::string inputs = hash_of_hull_inputs(take.manifest().rig_sha256, *hull, *added, occluders->hash);
  double recorded = 0;
  for (const std::string& serial : serials_of(take.rig())) recorded += media_bytes(take, serial);
  for (PlanItem& piece : pieces_of(wanted_frames(take, options.frames), chunk)) {
    // One other matte may change the labels of all frames.
    bool any = options.redo || (!options.labels.everybody() && !touched.empty());
    for (const int frame : piece.frames()) {
      if (any || touched.contains(frame)) {
        any = true;
        break;
      }
      const Result<MeshState> state = state_of_mesh(*layout, take.rig(), *record, inputs, frame);
      if (!state) return forward(state);
      any = *state == MeshState::ToMake;
    }
    if (!any) continue;
    piece.stage = "meshes";
    piece.id = text("meshes-", piece.first);
    piece.units = static_cast<double>(piece.count) * plan.cameras;
    piece.seconds = kMeshSeconds * piece.units;
    for (const std::string& serial : serials_of(take.rig()))
      piece.bytes_in += static_cast<std::uint64_t>(kMatteBytesAPixel * pixels_of(take, serial) * piece.count);
    piece.bytes_out = kMeshBytes * static_cast<std::uint64_t>(piece.count);
    plan.items.push_back(std::move(piece));
  }
  return {};
}

std::string host_name() {
  char host[256] = {};
  gethostname(host, sizeof host - 1);
  return host;
}

// A folder for a view in the scratch, gone afterwards.
class Workplace {
 public:
  // Of a scratch of this machine's own what killed processes left is cleared away first.
  static Result<std::unique_ptr<Workplace>> make(const Plan& plan, const PlanItem& item) {
    const fs::path scratch = plan.scratch.empty() ? plan.folder / "scratch" : plan.scratch;
    if (Result<void> ok = make_folder(scratch); !ok) return forward(ok);
    // Plans that share a scratch have folders of other names.
    const std::string mine = text("floatstage-", capture::sha256(plan.folder.string()).substr(0, 8), "-");
    if (!plan.scratch.empty()) sweep(scratch, mine);
    const fs::path folder = scratch / text(mine, item.id, "-", host_name(), "-", getpid());
    if (Result<void> ok = make_folder(folder); !ok) return forward(ok);
    Result<Claim> claim = wait_for_folder(folder, [] { return false; });
    if (!claim) return forward(claim);
    return std::unique_ptr<Workplace>(new Workplace(folder, std::move(*claim)));
  }
  ~Workplace() {
    std::error_code none;
    fs::remove_all(layout_.folder(), none);
  }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;

  const TakeLayout& layout() const { return layout_; }

 private:
  Workplace(const fs::path& folder, Claim claim) : layout_(folder), claim_(std::move(claim)) {}

  static void sweep(const fs::path& scratch, const std::string& mine) {
    std::error_code none;
    for (const fs::directory_entry& entry : fs::directory_iterator(scratch, none))
      if (entry.path().filename().string().starts_with(mine))
        if (const Result<Claim> dead = wait_for_folder(entry.path(), [] { return false; }); dead)
          fs::remove_all(entry.path(), none);
  }

  TakeLayout layout_;
  Claim claim_;
};

std::vector<fs::path> delivered(const Plan& plan, const char* stage) {
  std::vector<fs::path> folders;
  for (const PlanItem& item : plan.items)
    if (item.stage == stage) folders.push_back(plan.done(item.id));
  return folders;
}

Result<std::uint64_t> gather(const Plan& plan, const TakeLayout& take, Progress* progress,
                             const char* stage) {
  const Result<Claim> claim = claim_take(take.folder(), progress);
  if (!claim) return forward(claim);
  const bool mattes = std::string(stage) == "mattes";
  const Result<int> put = mattes ? gather_mattes(take, delivered(plan, stage), plan.stale)
                                 : gather_meshes(take, delivered(plan, stage));
  if (!put) return forward(put);
  std::printf("%s: %d %s in their places\n", take.folder().c_str(), *put, stage);
  return std::uint64_t{0};
}

// The mattes in their places, and divided anew where labels are chosen whose meshes come next.
Result<std::uint64_t> gather_for_meshes(const Plan& plan, const ProcessOptions& options) {
  Result<std::uint64_t> bytes = gather(plan, TakeLayout(options.take), options.progress, "mattes");
  if (!bytes || options.labels.everybody()) return bytes;
  const Result<LabelTakeReport> labels =
      label_take(options.take, {.threads = options.threads, .redo = false, .progress = options.progress});
  if (!labels) return forward(labels);
  return bytes;
}

Result<std::uint64_t> make_meshes_of(const Plan& plan, const PlanItem& item, const ProcessOptions& options) {
  const Result<std::unique_ptr<Workplace>> workplace = Workplace::make(plan, item);
  if (!workplace) return forward(workplace);
  const Result<TakeLayout> take = chosen_layout(options);
  if (!take) return forward(take);
  const TakeLayout here = (*workplace)->layout().with_labels(take->labels());
  const Result<Rig> rig = load_rig(take->rig());
  if (!rig) return forward(rig);
  if (Result<void> ok = make_view(*take, {serials_of(*rig), item.frames()}, here.folder()); !ok)
    return forward(ok);
  Result<std::unique_ptr<capture::TakeReader>> view = open_chosen(here.folder(), options.labels);
  if (!view) return forward(view);
  Result<MeshRecord> record = load_mesh_record(here);
  if (!record) return forward(record);
  const Result<recon::HullOptions> hull = settle_hull_options(**view, options, *record);
  if (!hull) return forward(hull);
  ProcessReport report;
  Result<void> ok = make_meshes(**view, options, *hull, std::move(*record), item.frames(), report);
  if (!ok) return forward(ok);
  for (const std::string& failure : report.meshes.failures)
    std::fprintf(stderr, "floatstage: %s\n", failure.c_str());
  return deliver(here, plan.done(item.id));
}

}  // namespace

std::vector<PlanItem> pieces_of(const std::vector<int>& frames, int chunk) {
  std::vector<PlanItem> all;
  for (const int frame : frames) {
    if (!all.empty() && all.back().count < chunk) {
      PlanItem& last = all.back();
      if (last.count == 1 && frame > last.first) last.step = frame - last.first;
      if (frame == last.first + last.count * last.step) {
        ++last.count;
        continue;
      }
      if (last.count == 1) last.step = 1;
    }
    PlanItem piece;
    piece.first = frame, piece.count = 1;
    all.push_back(std::move(piece));
  }
  return all;
}

Result<Plan> plan_of_pieces(const fs::path& take, const std::string& stage, std::vector<PlanItem> pieces,
                            double seconds_a_unit) {
  const Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(take);
  if (!opened) return forward(opened);
  Result<Plan> plan = empty_plan(**opened);
  if (!plan) return plan;
  plan->cameras = 0;
  for (PlanItem& piece : pieces) {
    piece.stage = stage;
    piece.id = text(stage, "-", piece.first);
    piece.units = piece.count;
    piece.seconds = seconds_a_unit * piece.units;
    plan->items.push_back(std::move(piece));
  }
  add_last("finish", units_of(*plan), *plan);
  return plan;
}

Result<std::string> plan_inputs(const fs::path& take) {
  const Result<std::unique_ptr<capture::TakeReader>> opened = capture::TakeReader::open(take);
  if (!opened) return forward(opened);
  return inputs_of(**opened);
}

Result<Plan> plan_mattes(const MatteTakeOptions& options, int chunk) {
  Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(options.take);
  if (!take) return forward(take);
  if (const auto added = settle_added(*take, options.hide_added, options.threads); !added)
    return forward(added);
  Result<Plan> plan = empty_plan(**take);
  if (!plan) return plan;
  if (const Result<std::set<int>> touched = add_mattes(**take, options, chunk, *plan); !touched)
    return forward(touched);
  add_last("finish", units_of(*plan), *plan);
  return plan;
}

Result<Plan> plan_process(const ProcessOptions& options, int chunk) {
  Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(options.take);
  if (!take) return forward(take);
  if (const auto added = settle_added(*take, options.hide_added, options.threads); !added)
    return forward(added);
  Result<Plan> plan = empty_plan(**take);
  if (!plan) return plan;
  const Result<std::set<int>> touched = add_mattes(**take, matte_options(options), chunk, *plan);
  if (!touched) return forward(touched);
  const double mattes = units_of(*plan);
  if (mattes > 0 || !options.labels.everybody()) add_last("gather", mattes, *plan);
  if (Result<void> ok = add_meshes(**take, options, chunk, *touched, *plan); !ok) return forward(ok);
  add_last("finish", mattes, *plan);
  return plan;
}

Result<std::uint64_t> run_matte_item(const Plan& plan, const PlanItem& item,
                                     const MatteTakeOptions& options) {
  if (item.stage != "mattes") return gather(plan, TakeLayout(options.take), options.progress, "mattes");
  const Result<std::unique_ptr<Workplace>> workplace = Workplace::make(plan, item);
  if (!workplace) return forward(workplace);
  const TakeLayout& here = (*workplace)->layout();
  const ViewPart part{item.cameras, item.frames()};
  if (Result<void> ok = make_view(TakeLayout(options.take), part, here.folder()); !ok) return forward(ok);
  Result<std::unique_ptr<capture::TakeReader>> view = capture::TakeReader::open(here.folder());
  if (!view) return forward(view);
  MatteTakeOptions mine = options;
  mine.take = here.folder();
  mine.how = item.with.at("how");
  mine.guide = item.with.at("guide");
  if (const auto together = item.with.find("together"); together != item.with.end())
    mine.together = together->second == "yes";
  mine.cameras = item.cameras;
  mine.frames = part.frames;
  mine.check = false;
  for (const PlanItem& other : plan.items)
    if (other.stage == item.stage && other.cameras == item.cameras)
      for (const int frame : other.frames()) mine.of_frames.push_back(frame);
  const Result<MatteReport> report = matte_take(**view, mine);
  if (!report) return forward(report);
  for (const CameraMattes& camera : report->cameras)
    for (const std::string& failure : camera.failures)
      std::fprintf(stderr, "floatstage: %s\n", failure.c_str());
  return deliver(here, plan.done(item.id));
}

Result<std::uint64_t> run_process_item(const Plan& plan, const PlanItem& item,
                                       const ProcessOptions& options) {
  if (item.stage == "mattes") return run_matte_item(plan, item, matte_options(options));
  if (item.stage == "gather") return gather_for_meshes(plan, options);
  if (item.stage == "meshes") return make_meshes_of(plan, item, options);
  const Result<TakeLayout> take = chosen_layout(options);
  if (!take) return forward(take);
  return gather(plan, *take, options.progress, "meshes");
}

}  // namespace floatstage::pipeline
