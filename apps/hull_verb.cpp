#include <algorithm>
#include <chrono>
#include <cstdio>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "apps/hull_flags.h"
#include "apps/interrupt.h"
#include "apps/progress_bar.h"
#include "apps/text_options.h"
#include "apps/verbs.h"
#include "core/mesh_io.h"
#include "core/statistics.h"
#include "core/text.h"
#include "pipeline/json_report.h"
#include "pipeline/progress.h"
#include "pipeline/scene_loader.h"
#include "recon/mesh/mesh_check.h"

namespace floatstage::apps {
namespace {

struct Options {
  std::filesystem::path take, out;
  std::string cameras, json_file;
  HullFlags hull;
  int frame = 0, threads = 0, repeat = 1;
};

struct Input {
  Rig rig;
  std::vector<Matte> mattes;
};

Result<Input> load(const Options& given) {
  Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  if (given.frame < 0 || given.frame >= (*take)->frame_count()) {
    return fail(ErrorCode::InvalidArgument, text("--frame ", given.frame, ": ", given.take.string(),
                                                 " has frames 0 to ", (*take)->frame_count() - 1));
  }
  Result<std::vector<Matte>> mattes = pipeline::load_mattes(**take, given.frame);
  if (!mattes) return forward(mattes);
  if (given.cameras.empty()) return Input{(*take)->rig(), std::move(*mattes)};
  Input input;
  for (const std::string& serial : split_list(given.cameras)) {
    const int camera = camera_index((*take)->rig(), serial);
    if (camera < 0) {
      return fail(ErrorCode::InvalidArgument, text("--cameras: ", given.take.string(), " has no camera '",
                                                   serial, "'; see its rig.json"));
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

nlohmann::json care_json(const Rig& rig, const recon::HullReport& hull) {
  if (!hull.care) return nullptr;
  const recon::MeshCleanupReport& care = *hull.care;
  return {{"triangles", {care.triangles_before, care.triangles_after}},
          {"slivers", {care.slivers_before, care.slivers_after}},
          {"smoothed_within", care.smoothed_within},
          {"vertex_move", by_camera(rig, care.vertex_move)},
          {"silhouette_shift", by_camera(rig, care.silhouette_shift)},
          {"iou_loss", by_camera(rig, care.iou_loss)},
          {"ms", 1e3 * hull.timings.care}};
}

void print_care(const recon::MeshCleanupReport& care) {
  std::printf(
      "care: %zu triangles (%zu slivers) became %zu (%zu); vertices moved up to %.2f px, silhouettes shifted "
      "up to "
      "%.1f px, IoU fell by up to %.4f\n",
      care.triangles_before, care.slivers_before, care.triangles_after, care.slivers_after,
      *std::max_element(care.vertex_move.begin(), care.vertex_move.end()),
      *std::max_element(care.silhouette_shift.begin(), care.silhouette_shift.end()),
      *std::max_element(care.iou_loss.begin(), care.iou_loss.end()));
}

/// Before anything is computed for it.
Result<void> check_name_of_mesh(const std::filesystem::path& file) {
  if (file.empty() || file.extension() == ".glb" || file.extension() == ".ply") return {};
  return fail(ErrorCode::InvalidArgument, text("--out ", file.string(), ": a mesh is a .ply or a .glb file"));
}

Result<void> save_mesh(const Mesh& mesh, const std::filesystem::path& file) {
  return file.extension() == ".glb" ? save_glb(mesh, file) : save_ply(mesh, file);
}

Result<void> run(const Options& given) {
  if (given.repeat < 1)
    return fail(ErrorCode::InvalidArgument, text("--repeat ", given.repeat, " is less than 1"));
  if (Result<void> ok = check_name_of_mesh(given.out); !ok) return ok;
  Result<recon::HullOptions> options = pipeline::hull_options(given.hull);
  if (!options) return forward(options);
  options->threads = given.threads;
  Result<Input> input = load(given);
  if (!input) return forward(input);

  // The repeats measure what a live chain pays for a frame; how good the mesh is, is found out once,
  // afterwards.
  recon::HullWorkspace workspace;
  std::vector<double> ms, without_contours;
  recon::HullTimings timings;
  recon::HullReport repeated;
  const recon::MeshCleanup care = std::exchange(options->care, {});
  options->quality = false;
  ProgressBar bar;
  std::optional<pipeline::ProgressPart> progress(std::in_place, &bar, "hulls",
                                                 static_cast<std::size_t>(given.repeat));
  for (int k = 0; k < given.repeat; ++k) {
    if (interrupted()) return pipeline::cancelled_unwritten();
    const auto begin = std::chrono::steady_clock::now();
    if (Result<void> ok = recon::visual_hull(input->rig, input->mattes, *options, workspace, repeated); !ok)
      return ok;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    ms.push_back(1e3 * seconds);
    without_contours.push_back(1e3 * (seconds - repeated.timings.contours));
    timings = repeated.timings;
    progress->advance();
  }
  progress.reset();  // off the terminal, before anything else is said
  options->quality = true;
  options->care = care;
  const Result<recon::HullReport> hull = recon::visual_hull(input->rig, input->mattes, *options, &workspace);
  if (!hull) return forward(hull);
  const recon::MeshCheck check = recon::check_mesh(hull->mesh);

  nlohmann::json iou = nlohmann::json::object(), voted_down = nlohmann::json::array();
  double sum = 0;
  int counted = 0;
  for (std::size_t c = 0; c < input->rig.cameras.size(); ++c) {
    iou[input->rig.cameras[c].serial] = hull->silhouette_iou[c];
    if (!(hull->silhouette_iou[c] >= 0)) continue;
    sum += hull->silhouette_iou[c];
    ++counted;
  }
  for (const int camera : hull->voted_down)
    voted_down.push_back(input->rig.cameras[static_cast<std::size_t>(camera)].serial);
  const double mean_iou = counted > 0 ? sum / counted : 0;
  for (const std::string& remark : hull->remarks) std::fprintf(stderr, "floatstage: %s\n", remark.c_str());
  std::printf(
      "%zu vertices, %zu triangles, %.6g m³; mean IoU %.4f; %s; %.2f ms (p95 %.2f), %.2f ms without "
      "contours\n",
      hull->mesh.positions.size(), hull->mesh.triangle_count(), hull->volume, mean_iou,
      check.watertight && check.manifold ? "closed and manifold" : "NOT CLOSED", percentile(ms, 0.5),
      percentile(ms, 0.95), percentile(without_contours, 0.5));
  if (hull->care) print_care(*hull->care);
  if (!given.out.empty()) {
    if (Result<void> ok = save_mesh(hull->mesh, given.out); !ok) return ok;
  }
  if (given.json_file.empty()) return {};
  return pipeline::save_json({{"options", pipeline::describe(*options)},
                              {"ms", spread_of(ms)},
                              {"ms_without_contours", spread_of(without_contours)},
                              {"phases_ms", phases(timings)},
                              {"work",
                               {{"points", hull->work.points},
                                {"hits", hull->work.hits},
                                {"lines", hull->work.lines},
                                {"relations", hull->work.relations}}},
                              {"faces", hull->faces},
                              {"vertices", hull->mesh.positions.size()},
                              {"triangles", hull->mesh.triangle_count()},
                              {"volume", hull->volume},
                              {"watertight", check.watertight},
                              {"manifold", check.manifold},
                              {"oriented", check.oriented && check.outward},
                              {"iou", iou},
                              {"mean_iou", mean_iou},
                              {"escalations", hull->escalations},
                              {"voted_down", voted_down},
                              {"remarks", hull->remarks},
                              {"care", care_json(input->rig, *hull)}},
                             given.json_file);
}

}  // namespace

void add_hull(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* verb =
      app.add_subcommand("hull", "The visual hull of one frame of a take that has mattes, timed and checked");
  verb->add_option("take", options->take, "The take's folder")->required();
  verb->add_option("--frame", options->frame, "Which frame")->capture_default_str();
  verb->add_option("--cameras", options->cameras, "Only these serials, separated by commas (default: all)");
  options->hull.votes = "strict";
  add_hull_flags(*verb, options->hull);
  verb->add_option("--threads", options->threads, "Threads; 0: one per core")
      ->capture_default_str()
      ->check(CLI::Range(0, 1024));
  verb->add_option("--repeat", options->repeat, "Compute it this often and report the times")
      ->capture_default_str();
  verb->add_option("--out", options->out, "Write the mesh: .ply or .glb");
  verb->add_option("--json", options->json_file, "Write a report as JSON");
  verb->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace floatstage::apps
