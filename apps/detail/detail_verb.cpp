#include <cstdio>

#include "apps/detail/detail_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/verb.h"
#include "core/file.h"
#include "core/text.h"
#include "detail/graph_json.h"
#include "pipeline/confined_outputs.h"
#include "pipeline/detail_watch.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

struct DetailArguments {
  fs::path folder, json_file, dot_file, cache;
  std::string root;
  int threads = 0;
};

// A photograph and those below it, indented.
void print_tree(const detail::PhotoGraph& graph, int photo, int depth) {
  const detail::GraphPhoto& p = graph.photos[static_cast<std::size_t>(photo)];
  std::printf("%*s%s", 2 * depth, "", p.photo.name.c_str());
  if (p.parent >= 0) std::printf("  %.2f x, %d features", p.zoom, p.inliers);
  std::printf(photo == graph.root ? "  (root)\n" : "\n");
  for (std::size_t i = 0; i < graph.photos.size(); ++i)
    if (graph.photos[i].parent == photo) print_tree(graph, static_cast<int>(i), depth + 1);
}

void print(const detail::PhotoGraph& graph) {
  std::size_t related = 0, alone = 0;
  for (std::size_t i = 0; i < graph.photos.size(); ++i) {
    if (graph.photos[i].parent >= 0) {
      ++related;
    } else if (graph.descendants(static_cast<int>(i)).empty()) {
      ++alone;
    } else {
      print_tree(graph, static_cast<int>(i), 0);
    }
  }
  std::printf("%zu photographs: %zu are details of another, %zu stand alone, %zu could not be read\n",
              graph.photos.size(), related, alone, graph.unread.size());
}

Result<void> make(const DetailArguments& given, const pipeline::PlaceOf& place,
                  pipeline::Progress& progress) {
  detail::GraphOptions options;
  options.root = given.root;
  options.relations.threads = given.threads;
  options.relations.watch = pipeline::watched_by(progress);
  options.relations.cache = given.cache;
  const Result<detail::PhotoGraph> graph = detail::build_photo_graph(given.folder, options);
  if (!graph) return forward(graph);
  for (const detail::UnreadPhoto& photo : graph->unread)
    std::fprintf(stderr, "floatstage: left out: %s\n", photo.why.c_str());
  print(*graph);
  if (!given.json_file.empty())
    if (Result<void> ok =
            write_file(place(given.json_file), detail::graph_to_json(*graph, given.json_file.parent_path()));
        !ok)
      return ok;
  if (given.dot_file.empty()) return {};
  return write_file(place(given.dot_file), detail::graph_to_dot(*graph));
}

Result<void> run_detail(DetailArguments given) {
  std::error_code error;
  if (!fs::is_directory(given.folder, error))
    return fail(ErrorCode::NotFound, text(given.folder.string(), " is no folder of photographs"));
  if (given.cache.empty() && !given.json_file.empty()) given.cache = given.json_file.string() + ".cache";
  ProgressBar bar;
  return pipeline::make_confined(
      {.what = given.folder.string(), .outputs = {given.json_file, given.dot_file}, .kept = given.cache},
      &bar,
      [&](const pipeline::PlaceOf& place, pipeline::Progress* told) { return make(given, place, *told); });
}

void add_graph(CLI::App& detail, Chosen& chosen) {
  auto options = std::make_shared<DetailArguments>();
  CLI::App* verb =
      add_verb(detail, chosen, "graph", "Finds which photographs show details of which",
               {"floatstage detail graph photos/ --json graph.json",
                "floatstage detail graph photos/ --json graph.json --dot graph.dot --root wide.jpg"});
  verb->add_option("folder", options->folder, "Folder of photographs (JPEG, PNG, TIFF) and folders of them")
      ->required()
      ->type_name("FOLDER");
  verb->add_option("--root", options->root,
                   "The photograph that gets the details (default: that with the most below it)")
      ->type_name("NAME");
  verb->add_option("--dot", options->dot_file, "Write the graph for Graphviz to this file")
      ->type_name("FILE");
  verb->add_option("--cache", options->cache,
                   "Folder that keeps features and pairs, so that one more photograph costs its own row only "
                   "(default: beside the --json file, its name with .cache)")
      ->type_name("FOLDER");
  add_threads(*verb, options->threads);
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_detail(*options); }; });
}

}  // namespace

void add_detail(CLI::App& app, Chosen& chosen) {
  CLI::App* verb =
      add_verb(app, chosen, "detail", "Photographs of one subject at several distances, as one zoom",
               {"floatstage detail graph photos/ --json graph.json",
                "floatstage detail compose graph.json -o zoom.png"});
  verb->require_subcommand(1);
  add_graph(*verb, chosen);
  add_detail_compose(*verb, chosen);
  add_detail_synthesize(*verb, chosen);
  add_detail_view(*verb, chosen);
}

}  // namespace floatstage::apps
