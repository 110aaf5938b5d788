#include <algorithm>
#include <chrono>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/terminal/did_you_mean.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/hull_flags.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/label_flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/verbs.h"
#include "core/mesh_io.h"
#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/occluders.h"
#include "pipeline/progress.h"
#include "pipeline/scene_loader.h"
#include "recon/mesh/mesh_check.h"

namespace floatstage::apps {
namespace {

struct HullArguments {
  std::filesystem::path take, out, json_file;
  std::vector<std::string> cameras;
  pipeline::LabelChoice labels;
  HullFlags hull;
  int frame = 0, threads = 0, repeat = 1;
};

struct Input {
  Rig rig;
  std::vector<Matte> mattes;
};

Result<Input> load(const HullArguments& given) {
  Result<std::unique_ptr<capture::TakeReader>> take = pipeline::open_chosen(given.take, given.labels);
  if (!take) return forward(take);
  if (given.frame < 0 || given.frame >= (*take)->frame_count()) {
    return fail(ErrorCode::InvalidArgument, text("--frame ", given.frame, ": ", given.take.string(),
                                                 " has frames 0 to ", (*take)->frame_count() - 1));
  }
  Result<std::vector<Matte>> mattes = pipeline::load_mattes(**take, given.frame);
  if (mattes)
    mattes = pipeline::silhouettes_of_labels(**take, given.frame, std::move(*mattes), given.threads);
  if (!mattes) return forward(mattes);
  const Result<pipeline::Occluders> occluders = pipeline::load_occluders((*take)->layout(), (*take)->rig());
  if (!occluders) return forward(occluders);
  mattes = occluders->props.silhouettes((*take)->rig(), std::move(*mattes), given.threads);
  if (!mattes) return forward(mattes);
  if (given.cameras.empty()) return Input{(*take)->rig(), std::move(*mattes)};
  Input input;
  for (const std::string& serial : given.cameras) {
    const int camera = camera_index((*take)->rig(), serial);
    if (camera < 0) {
      std::vector<std::string> serials;
      for (const RigCamera& c : (*take)->rig().cameras) serials.push_back(c.serial);
      return fail(ErrorCode::InvalidArgument,
                  text("--cameras: ", given.take.string(), " has no camera '", serial, "'",
                       did_you_mean(serial, serials), "; see its rig.json"));
    }
    input.rig.cameras.push_back((*take)->rig().cameras[static_cast<std::size_t>(camera)]);
    input.mattes.push_back((*mattes)[static_cast<std::size_t>(camera)]);
  }
  return input;
}

nlohmann::json spread_of(const std::vector<double>& ms) {
  return {{"p50", percentile(ms, 0.5)}, {"p95", percentile(ms, 0.95)}, {"min", percentile(ms, 0)}};
}

nlohmann::json phases(const recon::HullTimings& t) {
  return {{"contours", 1e3 * t.contours}, {"tables", 1e3 * t.tables}, {"rays", 1e3 * t.rays},
          {"faces", 1e3 * t.faces},       {"weld", 1e3 * t.weld},     {"triangles", 1e3 * t.triangles},
          {"voting", 1e3 * t.voting}};
}

/// Numbers of one kind by camera.
nlohmann::json by_camera(const Rig& rig, const std::vector<double>& numbers) {
  nlohmann::json j = nlohmann::json::object();
  for (std::size_t c = 0; c < numbers.size(); ++c) j[rig.cameras[c].serial] = numbers[c];
  return j;
}

nlohmann::json cleanup_json(const Rig& rig, const recon::HullReport& hull) {
  if (!hull.cleanup) return nullptr;
  const recon::MeshCleanupReport& cleanup = *hull.cleanup;
  return {{"triangles", {cleanup.triangles_before, cleanup.triangles_after}},
          {"slivers", {cleanup.slivers_before, cleanup.slivers_after}},
          {"smoothed_within", cleanup.smoothed_within},
          {"vertex_move", by_camera(rig, cleanup.vertex_move)},
          {"silhouette_shift", by_camera(rig, cleanup.silhouette_shift)},
          {"iou_loss", by_camera(rig, cleanup.iou_loss)},
          {"ms", 1e3 * hull.timings.cleanup}};
}

nlohmann::json verdicts_json(const Rig& rig, const std::vector<recon::SilhouetteVerdict>& verdicts) {
  nlohmann::json j = nlohmann::json::array();
  for (const recon::SilhouetteVerdict& verdict : verdicts)
    j.push_back({{"camera", rig.cameras[static_cast<std::size_t>(verdict.camera)].serial},
                 {"lost", verdict.lost},
                 {"gained", verdict.gained}});
  return j;
}

void print_cleanup(const recon::MeshCleanupReport& cleanup) {
  std::printf(
      "cleanup: %zu triangles (%zu slivers) became %zu (%zu); vertices moved up to %.2f px, silhouettes "
      "shifted "
      "up to "
      "%.1f px, IoU fell by up to %.4f\n",
      cleanup.triangles_before, cleanup.slivers_before, cleanup.triangles_after, cleanup.slivers_after,
      *std::max_element(cleanup.vertex_move.begin(), cleanup.vertex_move.end()),
      *std::max_element(cleanup.silhouette_shift.begin(), cleanup.silhouette_shift.end()),
      *std::max_element(cleanup.iou_loss.begin(), cleanup.iou_loss.end()));
}

/// Before anything is computed for it.
Result<void> check_name_of_mesh(const std::filesystem::path& file) {
  if (file.empty() || file.extension() == ".glb" || file.extension() == ".ply") return {};
  return fail(ErrorCode::InvalidArgument, text("--out ", file.string(), ": a mesh is a .ply or a .glb file"));
}

Result<void> save_mesh(const Mesh& mesh, const std::filesystem::path& file) {
  return file.extension() == ".glb" ? save_glb(mesh, file) : save_ply(mesh, file);
}

// What a live chain pays for a frame, over the repeats.
struct Times {
  std::vector<double> ms, without_contours;
  recon::HullTimings phases;  ///< of the last
};

Result<Times> measure(const Input& input, recon::HullOptions options, int repeats,
                      recon::HullWorkspace& workspace) {
  options.cleanup = {};
  options.quality = false;
  Times times;
  recon::HullReport report;
  ProgressBar bar;
  pipeline::ProgressPart progress(&bar, "hulls", static_cast<std::size_t>(repeats));
  for (int k = 0; k < repeats; ++k) {
    if (interrupted()) return pipeline::cancelled_unwritten();
    const auto begin = std::chrono::steady_clock::now();
    if (Result<void> ok = recon::visual_hull(input.rig, input.mattes, options, workspace, report); !ok)
      return forward(ok);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    times.ms.push_back(1e3 * seconds);
    times.without_contours.push_back(1e3 * (seconds - report.timings.contours));
    progress.advance();
  }
  times.phases = report.timings;
  return times;
}

double mean_iou(const recon::HullReport& hull) {
  double sum = 0;
  int counted = 0;
  for (const double iou : hull.silhouette_iou)
    if (iou >= 0) sum += iou, ++counted;
  return counted > 0 ? sum / counted : 0;
}

void print(const recon::HullReport& hull, const recon::MeshCheck& check, const Times& times) {
  for (const std::string& remark : hull.remarks) std::fprintf(stderr, "floatstage: %s\n", remark.c_str());
  std::printf(
      "%zu vertices, %zu triangles, %.6g m³; mean IoU %.4f; %s; %.2f ms (p95 %.2f), %.2f ms without "
      "contours\n",
      hull.mesh.positions.size(), hull.mesh.triangle_count(), hull.volume, mean_iou(hull),
      check.watertight && check.manifold ? "closed and manifold" : "NOT CLOSED", percentile(times.ms, 0.5),
      percentile(times.ms, 0.95), percentile(times.without_contours, 0.5));
  if (hull.cleanup) print_cleanup(*hull.cleanup);
}

nlohmann::json to_json(const Rig& rig, const recon::HullOptions& options, const recon::HullReport& hull,
                       const recon::MeshCheck& check, const Times& times) {
  nlohmann::json voted_down = nlohmann::json::array();
  for (const int camera : hull.voted_down)
    voted_down.push_back(rig.cameras[static_cast<std::size_t>(camera)].serial);
  return {{"options", pipeline::describe(options)},
          {"ms", spread_of(times.ms)},
          {"ms_without_contours", spread_of(times.without_contours)},
          {"phases_ms", phases(times.phases)},
          {"work",
           {{"points", hull.work.points},
            {"hits", hull.work.hits},
            {"lines", hull.work.lines},
            {"relations", hull.work.relations}}},
          {"faces", hull.faces},
          {"vertices", hull.mesh.positions.size()},
          {"triangles", hull.mesh.triangle_count()},
          {"volume", hull.volume},
          {"watertight", check.watertight},
          {"manifold", check.manifold},
          {"oriented", check.oriented && check.outward},
          {"iou", by_camera(rig, hull.silhouette_iou)},
          {"mean_iou", mean_iou(hull)},
          {"escalations", hull.escalations},
          {"crumbs", hull.crumbs},
          {"crumb_volume", hull.crumb_volume},
          {"cut", hull.cut},
          {"cameras_that_see_it", hull.stage_cameras},
          {"contradictory", hull.contradictory},
          {"silhouettes", verdicts_json(rig, hull.verdicts)},
          {"voted_down", voted_down},
          {"remarks", hull.remarks},
          {"cleanup", cleanup_json(rig, hull)}};
}

Result<void> run_hull(const HullArguments& given) {
  if (Result<void> ok = check_name_of_mesh(given.out); !ok) return ok;
  Result<recon::HullOptions> options = pipeline::hull_options(given.hull);
  if (!options) return forward(options);
  options->threads = given.threads;
  const Result<Input> input = load(given);
  if (!input) return forward(input);
  // The repeats are what is timed; how good the mesh is, is found out once, afterwards.
  recon::HullWorkspace workspace;
  const Result<Times> times = measure(*input, *options, given.repeat, workspace);
  if (!times) return forward(times);
  options->quality = true;
  const Result<recon::HullReport> hull = recon::visual_hull(input->rig, input->mattes, *options, &workspace);
  if (!hull) return forward(hull);
  const recon::MeshCheck check = recon::check_mesh(hull->mesh);
  print(*hull, check, *times);
  if (!given.out.empty())
    if (Result<void> ok = save_mesh(hull->mesh, given.out); !ok) return ok;
  if (given.json_file.empty()) return {};
  return pipeline::save_json(to_json(input->rig, *options, *hull, check, *times), given.json_file);
}

}  // namespace

void add_hull(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<HullArguments>();
  CLI::App* verb = add_verb(app, chosen, "hull",
                            "The visual hull of one frame of a take that has mattes, timed and checked",
                            {"floatstage hull take --frame 12 -o hull.glb",
                             "floatstage hull take --votes strict --repeat 50 --json hull.json"});
  add_take(*verb, options->take);
  verb->add_option("--frame", options->frame, "Which frame")->capture_default_str()->type_name("N");
  add_out(*verb, options->out, "Write the mesh: .ply or .glb");
  add_cameras(*verb, options->cameras);
  add_label_choice(*verb, options->labels);
  add_hull_flags(*verb, options->hull);
  verb->add_option("--repeat", options->repeat, "Compute it this often and report the times")
      ->capture_default_str()
      ->type_name("N")
      ->check(CLI::Validator(CLI::PositiveNumber).description(""))
      ->group(kGroupRun);
  add_threads(*verb, options->threads);
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_hull(*options); }; });
}

}  // namespace floatstage::apps
