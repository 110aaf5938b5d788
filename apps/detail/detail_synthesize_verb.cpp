#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/detail/detail_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/verb.h"
#include "core/png.h"
#include "core/text.h"
#include "detail/graph_json.h"
#include "detail/synthesis/deep_zoom.h"
#include "detail/synthesis/enlarge.h"
#include "detail/synthesis/pyramid_tiff.h"
#include "pipeline/confined_outputs.h"
#include "pipeline/detail_watch.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

namespace fs = std::filesystem;

struct DetailSynthesizeArguments {
  fs::path graph, out, json_file, provenance;
  std::string root;
  detail::EnlargeOptions enlarge;
};

nlohmann::json to_json(const detail::Enlargement& made) {
  nlohmann::json photos = nlohmann::json::array();
  for (const detail::ComposedPhoto& p : made.photos)
    photos.push_back({{"name", p.name}, {"zoom", p.zoom}, {"used", p.used}, {"why_not", p.why_not}});
  return {{"zoom", made.zoom},
          {"size", {made.width, made.height}},
          {"shares",
           {{"upsampled", made.shares[0]},
            {"synthesised", made.shares[1]},
            {"warped", made.shares[2]},
            {"real", made.shares[3]}}},
          {"like_root", made.like_root},
          {"photos", photos}};
}

void print(const detail::Enlargement& made) {
  for (const detail::ComposedPhoto& p : made.photos)
    if (p.why_not.empty())
      std::printf("%s: %.2f x, %.0f %% of it used\n", p.name.c_str(), p.zoom, 100 * p.used);
    else
      std::printf("%s: left out: %s\n", p.name.c_str(), p.why_not.c_str());
  std::printf(
      "%dx%d px, the root %d times enlarged: %.1f %% real, %.1f %% warped, %.1f %% synthesised, %.1f %% "
      "upsampled; its means are the root's to %.1f dB\n",
      made.width, made.height, made.zoom, 100 * made.shares[3], 100 * made.shares[2], 100 * made.shares[1],
      100 * made.shares[0], made.like_root);
}

bool is_deep_zoom(const fs::path& file) { return file.extension() == ".dzi"; }
bool is_tiff(const fs::path& file) { return file.extension() == ".tif" || file.extension() == ".tiff"; }

Result<void> make(const DetailSynthesizeArguments& given, const pipeline::PlaceOf& place,
                  pipeline::Progress& progress) {
  Result<detail::PhotoGraph> graph = detail::load_graph(given.graph);
  if (!graph) return forward(graph);
  if (Result<void> ok = take_root(*graph, given.root); !ok) return ok;
  detail::EnlargeOptions options = given.enlarge;
  options.watch = pipeline::watched_by(progress);
  options.keep_provenance = !given.provenance.empty();
  const fs::path out = place(given.out);
  if (is_deep_zoom(given.out))
    options.writer = [&](int width, int height) { return detail::write_deep_zoom(out, width, height); };
  if (is_tiff(given.out))
    options.writer = [&](int width, int height) { return detail::write_pyramid_tiff(out, width, height); };
  const Result<detail::Enlargement> made = detail::enlarge(*graph, options);
  if (!made) return forward(made);
  print(*made);
  if (!options.writer)
    if (Result<void> ok = save_picture(made->picture, out); !ok) return ok;
  if (!given.provenance.empty())
    if (Result<void> ok = save_png(detail::provenance_picture(made->provenance), place(given.provenance));
        !ok)
      return ok;
  return given.json_file.empty() ? Result<void>()
                                 : pipeline::save_json(to_json(*made), place(given.json_file));
}

Result<void> run_detail_synthesize(const DetailSynthesizeArguments& given) {
  if (!is_deep_zoom(given.out) && !is_tiff(given.out) && !is_picture_file(given.out))
    return fail(ErrorCode::InvalidArgument,
                text("--out ", given.out.string(),
                     ": a picture is a .png, a .jpg, a .dzi (Deep Zoom) or a .tif (pyramid) file"));
  if (!given.provenance.empty() && given.provenance.extension() != ".png")
    return fail(ErrorCode::InvalidArgument,
                text("--provenance ", given.provenance.string(), ": this picture is a .png file"));
  // The tiles before the document that names them.
  const fs::path tiles = is_deep_zoom(given.out) ? detail::deep_zoom_tiles(given.out) : fs::path();
  ProgressBar bar;
  return pipeline::make_confined(
      {.what = given.graph.string(), .outputs = {tiles, given.out, given.provenance, given.json_file}}, &bar,
      [&](const pipeline::PlaceOf& place, pipeline::Progress* told) { return make(given, place, *told); });
}

}  // namespace

void add_detail_synthesize(CLI::App& detail, Chosen& chosen) {
  auto options = std::make_shared<DetailSynthesizeArguments>();
  CLI::App* verb =
      add_verb(detail, chosen, "synthesize",
               "Enlarges a photograph, with details made up of those that close ones show",
               {"floatstage detail synthesize graph.json -o large.png",
                "floatstage detail synthesize graph.json -o large.dzi --zoom 8 --provenance from.png"});
  verb->add_option("graph", options->graph, "What `detail graph --json` wrote")
      ->required()
      ->type_name("FILE");
  add_out(*verb, options->out,
          "The picture (.png or .jpg); or written while it is made: a Deep Zoom image (.dzi and its folder), "
          "or a tiled pyramid in a TIFF (.tif)")
      ->required();
  verb->add_option("--zoom", options->enlarge.zoom,
                   "How many times the root is enlarged: 2, 4, 8, 16, 32 or 64 (default: that nearest to the "
                   "closest photograph's, as far as 32 million pixels allow; .dzi and .tif may have 1000)")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  verb->add_option("--root", options->root,
                   "The photograph that gets the details (default: as the graph says)")
      ->type_name("NAME");
  verb->add_option(
          "--provenance", options->provenance,
          "Write where every pixel comes from to this .png: blue real, green warped, red synthesised, "
          "grey upsampled")
      ->type_name("FILE");
  add_threads(*verb, options->enlarge.threads);
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_detail_synthesize(*options); }; });
}

}  // namespace floatstage::apps
