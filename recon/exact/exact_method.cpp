#include "recon/exact/exact_method.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/text.h"
#include "recon/bounding_volume.h"

namespace floatstage::recon {

namespace {

/// px: how far from half opacity the edge within a pixel can lie.
constexpr double kPixelAtMost = 0.5;

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

Unexpected unbounded() {
  return fail(
      ErrorCode::BadData,
      "the silhouettes bound nothing: in too many cameras the subject fills the image or is cut by its "
      "border; give the volume to search");
}

void remark_on_noise(const Rig& rig, const HullInput& input, double tolerance, const SilhouetteCones& cones,
                     HullReport& report) {
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const OutlineDetail& detail = cones.details[c];
    if (!input.knows(c) || (!detail.coarser && detail.smallest <= 0)) continue;
    if (cones.outlines[c].empty()) {
      report.remarks.push_back(text("camera '", rig.cameras[c].serial,
                                    "': its matte is nothing but specks and was left out; look at it"));
    } else {
      report.remarks.push_back(
          text("camera '", rig.cameras[c].serial, "': its matte is noisy: its outline was taken within ",
               std::max(tolerance, detail.tolerance), " px, without islands and holes below ",
               detail.smallest, " px²; look at it"));
    }
  }
}

int known_cameras(const Rig& rig, const HullInput& input) {
  int known = 0;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) known += input.knows(c);
  return known;
}

/// What no camera bears witness for, and what the mattes are not sure of.
void drop_shells(const Rig& rig, const HullInput& input, const ShellRules& rules, ShellFilter& filter,
                 HullReport& report) {
  const std::size_t before = report.mesh.triangles.size();
  const ShellCount dropped = filter.apply(rig, input, rules, report.mesh, report.sources);
  report.crumbs = dropped.crumbs;
  report.crumb_volume = dropped.crumb_volume;
  if (report.mesh.triangles.size() != before) report.volume = signed_volume(report.mesh);
}

void take_over(const HullPolygons& polygons, const SilhouetteCones& cones, HullReport& report) {
  report.volume = polygons.volume;
  report.faces = static_cast<int>(polygons.polygon_start.size()) - 1;
  report.mesh.positions.resize(polygons.positions.size());
  std::transform(polygons.positions.begin(), polygons.positions.end(), report.mesh.positions.begin(),
                 [](const Eigen::Vector3d& p) { return p.cast<float>(); });
  report.mesh.triangles.assign(polygons.triangles.begin(), polygons.triangles.end());
  report.sources.resize(polygons.triangle_face.size());
  std::transform(polygons.triangle_face.begin(), polygons.triangle_face.end(), report.sources.begin(),
                 [&](int face) {
                   const HullPolygons::Face& f = polygons.faces[static_cast<std::size_t>(face)];
                   return HullFaceSource{cones.camera[static_cast<std::size_t>(f.view)], f.edge};
                 });
}

/// Whom the others contradict, and their mattes with what they lack as subject. Finds the stage of those.
/// Once: what is mended is looser than the subject, and would accuse others.
std::vector<Matte> mend(const Rig& rig, HullInput& input, int threads, HullWorkspace::Impl& workspace,
                        HullReport& report) {
  std::vector<Matte> mattes;
  report.verdicts = workspace.audit.audit(rig, input, workspace.finder);
  const int known = workspace.finder.pictures().known();
  const auto lacks = [](const SilhouetteVerdict& verdict) {
    return verdict.lost > SilhouetteAudit::kAllowed;
  };
  const auto lacking = std::count_if(report.verdicts.begin(), report.verdicts.end(), lacks);
  report.contradictory = lacking > std::max(1, known / 4);  // too many for the others to be believed
  if (report.contradictory) return mattes;
  for (const SilhouetteVerdict& verdict : report.verdicts) {
    if (!lacks(verdict)) continue;
    if (mattes.empty()) mattes.assign(input.mattes().begin(), input.mattes().end());
    Matte& matte = mattes[static_cast<std::size_t>(verdict.camera)];
    matte = mended(matte, verdict);
    report.voted_down.push_back(verdict.camera);
  }
  if (!mattes.empty())
    workspace.finder.find(rig, HullInput(rig, std::span<const Matte>(mattes), threads), workspace.stage);
  int doubtful = 0;
  for (std::size_t c = 0; c < workspace.stage.unexplained.size(); ++c) {
    // What was mended is generous: it says nothing about the others.
    const bool was_mended = std::find(report.voted_down.begin(), report.voted_down.end(),
                                      static_cast<int>(c)) != report.voted_down.end();
    doubtful += !was_mended && workspace.stage.unexplained[c] > SilhouetteAudit::kAllowed;
  }
  report.contradictory = doubtful >= std::max(2, (known + 1) / 2);
  return mattes;
}

void remark_on_verdicts(const Rig& rig, HullReport& report) {
  for (const SilhouetteVerdict& verdict : report.verdicts) {
    const std::string& serial = rig.cameras[static_cast<std::size_t>(verdict.camera)].serial;
    if (verdict.lost > SilhouetteAudit::kAllowed)
      report.remarks.push_back(
          text("camera '", serial, "' ", report.contradictory ? "lacks " : "was voted down: its matte lacks ",
               std::lround(100 * verdict.lost), " % of what all others show; look at it"));
    if (verdict.gained > SilhouetteAudit::kAllowed)
      report.remarks.push_back(text("camera '", serial, "': ", std::lround(100 * verdict.gained),
                                    " % of its matte is confirmed by no other; look at it"));
  }
  if (report.contradictory)
    report.remarks.emplace_back(
        "the silhouettes contradict one another: half of them show subject that no body explains, or more "
        "than "
        "a quarter lack what the others show; look at the mattes and the calibration");
}

/// Traces the outlines and finds their hull; mattes of noise, whose outlines cross each other millions of
/// times, are made coarser until the frame's time is bounded. Absent with report filled (an empty hull).
class ExactRun {
 public:
  ExactRun(const Rig& rig, HullInput& input, const HullOptions& options, HullWorkspace::Impl& workspace,
           HullReport& report)
      : rig_(rig), input_(input), options_(options), workspace_(workspace), report_(report) {
    settings_.tolerance = input.outlined() ? 0 : options.contour_tolerance;
    settings_.volume = options.volume;
    settings_.threads = options.threads;
  }

  /// What StageFinder found: where the hull is sought, and who sees only a part of it.
  void seek_in(StageVolume& stage) {
    const Eigen::Vector3d margin = 0.01 * stage.box.sizes();
    stage.box = {stage.box.min() - margin, stage.box.max() + margin};
    stage_ = &stage;
    if (std::find(stage.partial.begin(), stage.partial.end(), 1) == stage.partial.end()) return;
    settings_.volume = stage.box;
    settings_.partial = stage.partial;
  }

  enum class End { Hull, Empty, Open };
  Result<End> run();
  Result<void> make_cones();
  const ExactOutcome& outcome() const { return outcome_; }
  bool cut() const { return cut_; }
  /// Somebody does not see all of what StageFinder found.
  bool is_partial() const { return stage_ && !settings_.partial.empty(); }
  int stage_cameras() const { return stage_ ? stage_->cameras : 0; }

 private:
  Result<bool> trace();

  const Rig& rig_;
  HullInput& input_;
  const HullOptions& options_;
  HullWorkspace::Impl& workspace_;
  HullReport& report_;
  ConeOptions settings_;
  const StageVolume* stage_ = nullptr;
  ExactOutcome outcome_;
  bool cut_ = false;
};

Result<void> ExactRun::make_cones() {
  SilhouetteCones& cones = workspace_.cones;
  workspace_.builder.build(rig_, input_, settings_, cones);
  for (std::size_t c = 0; c < rig_.cameras.size(); ++c) {
    if (!cones.details[c].torn) continue;
    return fail(ErrorCode::BadData,
                text("camera '", rig_.cameras[c].serial,
                     "': without its lens, its outline crosses itself too badly to be mended; "
                     "check its calibration and where the outline comes from"));
  }
  return {};
}

/// False when the silhouettes have no point in common.
Result<bool> ExactRun::trace() {
  if (Result<void> ok = make_cones(); !ok) return forward(ok);
  SilhouetteCones& cones = workspace_.cones;
  const bool enough =
      std::count_if(cones.camera.begin(), cones.camera.end(), [](int c) { return c >= 0; }) >= 2;
  if (stage_ && !enough) {  // what one camera or none shows is bounded by nothing
    stage_ = nullptr;
    settings_.volume.reset();
    settings_.partial = {};
    workspace_.builder.build(rig_, input_, settings_, cones);
  }
  cut_ =
      std::any_of(cones.views.begin(), cones.views.end(), [](const ConeView& v) { return v.beyond_counts; });
  if (settings_.volume || (enough && !cut_)) return true;
  if (stage_) {
    add_volume(stage_->box, cones);
    return true;
  }
  // Some silhouettes are open: what the others bound is where the hull is sought.
  const std::optional<Eigen::AlignedBox3d> box = bounding_volume(rig_, input_.mattes());
  if (!box) return unbounded();
  if (box->isEmpty()) return false;
  const Eigen::Vector3d margin = 0.01 * box->sizes();
  add_volume({box->min() - margin, box->max() + margin}, cones);
  return true;
}

Result<ExactRun::End> ExactRun::run() {
  SilhouetteCones& cones = workspace_.cones;
  ExactOptions engine;
  engine.threads = options_.threads;
  engine.votes = options_.voting == HullVoting::MofN ? options_.votes : 0;
  constexpr int kRounds = 6;
  for (int round = 0;; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    const Result<bool> traced = trace();
    if (!traced) return forward(traced);
    if (!*traced) return End::Empty;
    report_.timings.contours = seconds_since(begin);
    workspace_.views = cones.views;
    engine.pixel = cones.pixel;
    outcome_ = workspace_.engine.compute(workspace_.views, engine);
    if (!outcome_.too_complex) break;
    if (round == kRounds) {
      return fail(
          ErrorCode::BadData,
          "the outlines of the mattes cross each other too often, even without small islands and holes: they "
          "are noise; look at the mattes and at the keyer's settings");
    }
    settings_.tolerance = std::max(settings_.tolerance, std::clamp(2 * settings_.tolerance, 0.5, 4.0));
    settings_.smallest = std::max(16.0, 16 * settings_.smallest);
  }
  remark_on_noise(rig_, input_, input_.outlined() ? 0 : options_.contour_tolerance, cones, report_);
  if (outcome_.unbounded) return unbounded();
  return outcome_.closed ? End::Hull : End::Open;
}

void take_numbers(const ExactOutcome& outcome, const SilhouetteCones& cones, HullReport& report) {
  report.escalations = outcome.attempts - 1;
  report.work = {0, outcome.work.hits, outcome.work.lines, outcome.work.relations};
  for (const Silhouette& outline : cones.outlines)
    report.work.points += static_cast<std::int64_t>(outline.points.size());
  report.timings.tables = outcome.timings.pairs;
  report.timings.rays = outcome.timings.rays;
  report.timings.faces = outcome.timings.faces;
  report.timings.weld = outcome.timings.weld;
  report.timings.triangles = outcome.timings.triangles;
}

}  // namespace

Result<bool> exact_visual_hull(const Rig& rig, HullInput& input, const HullOptions& options,
                               HullWorkspace::Impl& workspace, HullReport& report) {
  const auto begin = std::chrono::steady_clock::now();
  const bool audited = options.voting == HullVoting::Auto;
  StageVolume& stage = workspace.stage;
  const int outvoted = options.voting == HullVoting::MofN ? known_cameras(rig, input) - options.votes : 0;
  const bool staged =
      (!options.volume || audited) && workspace.finder.find(rig, input, stage, std::max(0, outvoted));
  const double finding = seconds_since(begin);
  std::vector<Matte> mattes;
  if (staged && audited) {
    const auto voting = std::chrono::steady_clock::now();
    mattes = mend(rig, input, options.threads, workspace, report);
    remark_on_verdicts(rig, report);
    report.timings.voting = seconds_since(voting);
  }
  HullInput mended(rig, std::span<const Matte>(mattes), options.threads);
  ExactRun run(rig, mattes.empty() ? input : mended, options, workspace, report);
  if (staged && !options.volume && stage.box.isEmpty()) {
    if (const Result<void> ok = run.make_cones(); !ok) return forward(ok);  // is every outline of use?
    return true;
  }
  if (staged && !options.volume) run.seek_in(stage);
  const Result<ExactRun::End> end = run.run();
  if (!end) return forward(end);
  report.timings.contours += finding;
  if (*end == ExactRun::End::Empty) return true;
  if (*end == ExactRun::End::Open) return false;
  take_over(workspace.engine.polygons(), workspace.cones, report);
  take_numbers(run.outcome(), workspace.cones, report);
  report.stage_cameras = run.stage_cameras();
  drop_shells(rig, input,
              {.stage = run.is_partial() ? &workspace.finder : nullptr,
               .cameras = run.cut() ? std::max(1, report.stage_cameras) : 0,
               .uncertainty = options.keep_crumbs ? 0 : options.contour_tolerance + kPixelAtMost},
              workspace.shells, report);
  report.cut = std::any_of(report.sources.begin(), report.sources.end(),
                           [](const HullFaceSource& source) { return source.camera < 0; });
  if (report.cut && report.stage_cameras > 0)
    report.remarks.push_back(text("the subject goes on where fewer than ", report.stage_cameras,
                                  " cameras look: the hull is cut there; add cameras, or give the volume"));
  const Eigen::AlignedBox3f bounds = bounding_box(report.mesh);
  report.searched = options.volume
                        ? *options.volume
                        : Eigen::AlignedBox3d(bounds.min().cast<double>(), bounds.max().cast<double>());
  return true;
}

}  // namespace floatstage::recon
