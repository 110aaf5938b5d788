#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/export/export_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/label_flags.h"
#include "apps/terminal/progress_bar.h"
#include "pipeline/export/export_mesh.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

struct MeshArguments {
  pipeline::ExportMeshOptions mesh;
  std::string frames, up = "y";
  std::filesystem::path json;
};

Result<void> run_mesh(const MeshArguments& given) {
  pipeline::ExportMeshOptions options = given.mesh;
  options.up = given.up == "z" ? GlbUp::Z : GlbUp::Y;
  Result<std::vector<int>> frames = frames_of_take(options.take, given.frames);
  if (!frames) return forward(frames);
  options.frames = std::move(*frames);
  ProgressBar bar;
  options.progress = &bar;
  const Result<pipeline::ExportMeshReport> report = pipeline::export_mesh(options);
  if (!report) return forward(report);
  std::printf("%s: %d frames, %zu vertices at most %.1f mm apart, %zu triangles\n", options.out.c_str(),
              report->frames, report->vertices, 1e3 * report->spacing, report->triangles);
  if (given.json.empty()) return {};
  return pipeline::save_json({{"out", options.out.string()},
                              {"frames", report->frames},
                              {"vertices", report->vertices},
                              {"triangles", report->triangles},
                              {"spacing", report->spacing}},
                             given.json);
}

}  // namespace

void add_export_mesh(CLI::App& parent, Chosen& chosen) {
  auto options = std::make_shared<MeshArguments>();
  CLI::App* verb = add_verb(parent, chosen, "mesh",
                            "Hulls in the photographs' colours as GLB: one animated, or one a frame",
                            {"floatstage export mesh take -o take.glb",
                             "floatstage export mesh take --frames 0:50 --up z -o meshes"});
  add_take(*verb, options->mesh.take);
  add_label_choice(*verb, options->mesh.labels);
  add_out(*verb, options->mesh.out, "A .glb for one animated file, or a new folder for one file a frame")
      ->required();
  add_frames(*verb, options->frames, "all");
  verb->add_option("--spacing", options->mesh.spacing,
                   "How far apart vertices, and so colours, are at most: pixels of the nearest photograph")
      ->capture_default_str()
      ->type_name("PX");
  verb->add_option("--up", options->up,
                   "The axis that points upwards: y as glTF has it, z for programs that do not turn")
      ->capture_default_str()
      ->check(one_of({"y", "z"}));
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_mesh(*options); }; });
}

}  // namespace floatstage::apps
