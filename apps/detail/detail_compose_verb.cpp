#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/detail/detail_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/verb.h"
#include "core/file.h"
#include "core/jpeg.h"
#include "core/png.h"
#include "core/text.h"
#include "detail/compose.h"
#include "detail/graph_json.h"
#include "pipeline/confined_outputs.h"
#include "pipeline/detail_watch.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

constexpr int kJpegQuality = 95;

struct DetailComposeArguments {
  fs::path graph, out, json_file;
  std::string root;
  detail::ComposeOptions compose;
};

nlohmann::json to_json(const detail::Composition& made) {
  nlohmann::json photos = nlohmann::json::array();
  for (const detail::ComposedPhoto& p : made.photos) {
    if (!p.why_not.empty()) {
      photos.push_back({{"name", p.name}, {"zoom", p.zoom}, {"why_not", p.why_not}});
      continue;
    }
    photos.push_back({{"name", p.name},
                      {"zoom", p.zoom},
                      {"used", p.used},
                      {"same", p.same},
                      {"edges", p.edges},
                      {"moved", p.moved},
                      {"adapted", p.adapted},
                      {"seam", {p.seam_before, p.seam_after}},
                      {"correction", p.correction}});
  }
  return {{"zoom", made.zoom}, {"size", {made.picture.width, made.picture.height}}, {"photos", photos}};
}

void print(const detail::Composition& made) {
  for (const detail::ComposedPhoto& p : made.photos)
    if (p.why_not.empty())
      std::printf("%s: %.2f x, %.0f %% of it used, %d edges %.2f px apart%s, seam %.4g to %.4g\n",
                  p.name.c_str(), p.zoom, 100 * p.used, p.edges, p.moved, p.adapted ? " and moved" : "",
                  p.seam_before, p.seam_after);
    else
      std::printf("%s: left out: %s\n", p.name.c_str(), p.why_not.c_str());
  std::printf("%dx%d px, the root %.2f times enlarged\n", made.picture.width, made.picture.height, made.zoom);
}

bool is_jpeg(const fs::path& file) { return file.extension() == ".jpg" || file.extension() == ".jpeg"; }

Result<void> make(const DetailComposeArguments& given, const pipeline::PlaceOf& place,
                  pipeline::Progress& progress) {
  Result<detail::PhotoGraph> graph = detail::load_graph(given.graph);
  if (!graph) return forward(graph);
  if (Result<void> ok = take_root(*graph, given.root); !ok) return ok;
  detail::ComposeOptions options = given.compose;
  options.steps = place(given.compose.steps);
  options.watch = pipeline::watched_by(progress);
  const Result<detail::Composition> made = detail::compose(*graph, options);
  if (!made) return forward(made);
  if (made->photos.empty())
    std::fprintf(stderr, "floatstage: nothing lies below %s: it is only enlarged\n",
                 graph->photos[static_cast<std::size_t>(graph->root)].photo.name.c_str());
  print(*made);
  if (Result<void> ok = save_picture(made->picture, place(given.out)); !ok) return ok;
  return given.json_file.empty() ? Result<void>()
                                 : pipeline::save_json(to_json(*made), place(given.json_file));
}

Result<void> run_detail_compose(const DetailComposeArguments& given) {
  if (!is_picture_file(given.out))
    return fail(ErrorCode::InvalidArgument,
                text("--out ", given.out.string(), ": a picture is a .png or a .jpg file"));
  ProgressBar bar;
  return pipeline::make_confined(
      {.what = given.graph.string(), .outputs = {given.out, given.json_file, given.compose.steps}}, &bar,
      [&](const pipeline::PlaceOf& place, pipeline::Progress* told) { return make(given, place, *told); });
}

}  // namespace

bool is_picture_file(const fs::path& file) { return is_jpeg(file) || file.extension() == ".png"; }

Result<void> save_picture(const Image& picture, const fs::path& file) {
  return is_jpeg(file) ? write_file(file, encode_jpeg(picture, kJpegQuality)) : save_png(picture, file);
}

Result<void> take_root(detail::PhotoGraph& graph, const std::string& name) {
  if (name.empty()) return {};
  for (std::size_t i = 0; i < graph.photos.size(); ++i)
    if (graph.photos[i].photo.name == name) graph.root = static_cast<int>(i);
  if (graph.photos[static_cast<std::size_t>(graph.root)].photo.name == name) return {};
  return fail(ErrorCode::InvalidArgument,
              text("--root ", name, ": the graph has no photograph of this name"));
}

void add_detail_compose(CLI::App& detail, Chosen& chosen) {
  auto options = std::make_shared<DetailComposeArguments>();
  CLI::App* verb =
      add_verb(detail, chosen, "compose", "Carries close photographs into the wide one they belong to",
               {"floatstage detail compose graph.json -o zoom.png",
                "floatstage detail compose graph.json -o zoom.jpg --zoom 4 --steps steps/"});
  verb->add_option("graph", options->graph, "What `detail graph --json` wrote")
      ->required()
      ->type_name("FILE");
  add_out(*verb, options->out, "The picture (.png or .jpg)")->required();
  verb->add_option(
          "--zoom", options->compose.zoom,
          "How many times the root is enlarged (default: as the closest photograph, as far as 32 million "
          "pixels allow)")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  verb->add_option("--root", options->root,
                   "The photograph that gets the details (default: as the graph says)")
      ->type_name("NAME");
  verb->add_flag("!--no-adapt", options->compose.adapt, "Do not move edges of photographs onto one another");
  verb->add_option("--steps", options->compose.steps, "Write a picture of every step to this folder")
      ->type_name("FOLDER");
  add_threads(*verb, options->compose.threads);
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_detail_compose(*options); }; });
}

}  // namespace floatstage::apps
