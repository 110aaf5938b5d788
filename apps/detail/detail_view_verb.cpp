#include <array>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/detail/detail_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/interrupt.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/verb.h"
#include "apps/viewer/detail/zoom_window.h"
#include "core/text.h"
#include "detail/graph_json.h"
#include "detail/zoom_layers.h"
#include "pipeline/confined_job.h"
#include "pipeline/detail_watch.h"
#include "pipeline/json_report.h"

namespace floatstage::apps {
namespace {

const std::vector<std::string>& overlay_names() {
  static const std::vector<std::string> names = {"color", "provenance", "graph", "both"};
  return names;
}

struct DetailViewArguments {
  std::filesystem::path graph, json_file;
  std::string root, overlay = "color";
  std::vector<double> at;
  Size size{1280, 800};
  double video_memory = 512;  // MiB
  detail::ZoomLayersOptions layers;
  ZoomWindowOptions window;
};

nlohmann::json report_of(const ZoomReport& report, const detail::ZoomLayers& layers) {
  nlohmann::json photos = nlohmann::json::array();
  for (const detail::ComposedPhoto& p : layers.photos)
    photos.push_back({{"name", p.name}, {"zoom", p.zoom}, {"used", p.used}, {"why_not", p.why_not}});
  return {{"photos", photos},
          {"zoom", report.zoom},
          {"finest", report.finest},
          {"video_memory_bytes", report.allocated},
          {"flat_texture_bytes", report.flat},
          {"layers", report.layers},
          {"passes", report.passes},
          {"steps", report.steps},
          {"pictures",
           {{"pictures", report.pictures.count()},
            {"median_ms", report.pictures.percentile(0.5)},
            {"p95_ms", report.pictures.percentile(0.95)},
            {"worst_ms", report.pictures.worst()}}}};
}

/// What a window needs of a graph, as the child that decodes photographs hands it on.
struct Prepared {
  std::string root;
  detail::ZoomLayers layers;
};

nlohmann::json packed(const Image& picture) {
  return {{"size", {picture.width, picture.height, picture.channels}},
          {"pixels", nlohmann::json::binary(picture.pixels)}};
}

// JSON's own exception where it is no picture.
Image unpacked(const nlohmann::json& packed, int channels) {
  const auto size = packed.at("size").get<std::array<int, 3>>();
  Image picture;
  picture.pixels = packed.at("pixels").get_binary();
  const bool fits = size[0] > 0 && size[1] > 0 && size[2] == channels &&
                    picture.pixels.size() == static_cast<std::uint64_t>(size[0]) * size[1] * channels;
  if (!fits) throw nlohmann::json::other_error::create(501, "no picture", &packed);
  picture.width = size[0], picture.height = size[1], picture.channels = channels;
  return picture;
}

void to_json(nlohmann::json& json, const Prepared& prepared) {
  json = {{"root", prepared.root}, {"picture", packed(prepared.layers.root)}};
  json["layers"] = nlohmann::json::array();
  for (const detail::ZoomLayer& layer : prepared.layers.layers) {
    std::array<double, 9> matrix{};
    Eigen::Map<Eigen::Matrix3d>(matrix.data()) = layer.root_from_layer;
    json["layers"].push_back({{"name", layer.name},
                              {"picture", packed(layer.picture)},
                              {"root_from_layer", matrix},
                              {"zoom", layer.zoom},
                              {"moved", layer.moved}});
  }
  json["photos"] = nlohmann::json::array();
  for (const detail::ComposedPhoto& p : prepared.layers.photos)
    json["photos"].push_back({{"name", p.name}, {"zoom", p.zoom}, {"used", p.used}, {"why_not", p.why_not}});
}

void from_json(const nlohmann::json& json, Prepared& prepared) {
  json.at("root").get_to(prepared.root);
  prepared.layers.root = unpacked(json.at("picture"), 3);
  for (const nlohmann::json& from : json.at("layers")) {
    detail::ZoomLayer& layer = prepared.layers.layers.emplace_back();
    from.at("name").get_to(layer.name);
    layer.picture = unpacked(from.at("picture"), 4);
    auto matrix = from.at("root_from_layer").get<std::array<double, 9>>();
    layer.root_from_layer = Eigen::Map<Eigen::Matrix3d>(matrix.data());
    from.at("zoom").get_to(layer.zoom);
    from.at("moved").get_to(layer.moved);
  }
  for (const nlohmann::json& from : json.at("photos")) {
    detail::ComposedPhoto& photo = prepared.layers.photos.emplace_back();
    from.at("name").get_to(photo.name);
    from.at("zoom").get_to(photo.zoom);
    from.at("used").get_to(photo.used);
    from.at("why_not").get_to(photo.why_not);
  }
}

Result<Prepared> prepare(const DetailViewArguments& given, pipeline::Progress& progress) {
  Result<detail::PhotoGraph> graph = detail::load_graph(given.graph);
  if (!graph) return forward(graph);
  if (Result<void> ok = take_root(*graph, given.root); !ok) return forward(ok);
  const detail::Photo& root = graph->photos[static_cast<std::size_t>(graph->root)].photo;
  if (!given.at.empty() &&
      !(given.at[0] >= 0 && given.at[1] >= 0 && given.at[0] <= root.width && given.at[1] <= root.height))
    return fail(ErrorCode::InvalidArgument, text("--at ", given.at[0], ",", given.at[1], ": ", root.name,
                                                 " has ", root.width, "x", root.height, " px"));
  detail::ZoomLayersOptions making = given.layers;
  making.watch = pipeline::watched_by(progress);
  Result<detail::ZoomLayers> layers = detail::zoom_layers(*graph, making);
  if (!layers) return forward(layers);
  return Prepared{root.name, std::move(*layers)};
}

Result<void> run_detail_view(const DetailViewArguments& given) {
  ProgressBar bar;
  const Result<Prepared> prepared = pipeline::run_confined_job<Prepared>(
      {.what = given.graph.string()}, &bar, [&](pipeline::Progress* told) { return prepare(given, *told); });
  if (!prepared) return forward(prepared);
  const detail::ZoomLayers& layers = prepared->layers;
  ZoomWindowOptions options = given.window;
  if (!given.at.empty()) options.at = Eigen::Vector2d(given.at[0], given.at[1]);
  for (const detail::ComposedPhoto& p : layers.photos)
    if (!p.why_not.empty())
      std::fprintf(stderr, "floatstage: %s is left out: %s\n", p.name.c_str(), p.why_not.c_str());
  const Result<ZoomScene> scene = zoom_scene(layers);
  if (!scene) return forward(scene);
  options.title = "Floatstage: " + prepared->root;
  options.width = given.size.width;
  options.height = given.size.height;
  options.budget = static_cast<std::size_t>(given.video_memory * (1 << 20));
  options.provenance = given.overlay == "provenance" || given.overlay == "both";
  options.graph = given.overlay == "graph" || given.overlay == "both";
  options.stop = interrupted;
  const Result<ZoomReport> report = show_zoom(*scene, options);
  if (!report) return forward(report);
  return given.json_file.empty() ? Result<void>()
                                 : pipeline::save_json(report_of(*report, layers), given.json_file);
}

}  // namespace

void add_detail_view(CLI::App& detail, Chosen& chosen) {
  auto options = std::make_shared<DetailViewArguments>();
  ZoomWindowOptions& window = options->window;
  CLI::App* verb =
      add_verb(detail, chosen, "view", "Zooms from a photograph into the close ones below it, in a window",
               {"floatstage detail view graph.json",
                "floatstage detail view graph.json --at 812,430 --zoom 12 --split --screenshot zoom.png"});
  verb->add_option("graph", options->graph, "What `detail graph --json` wrote")
      ->required()
      ->type_name("FILE");
  verb->add_option("--at", options->at, "Begin at this pixel of the root (default: its middle)")
      ->delimiter(',')
      ->expected(2)
      ->type_name("X,Y");
  verb->add_option("--zoom", window.zoom,
                   "Begin with the root enlarged so many times (default: the whole of it)")
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  verb->add_option("--root", options->root, "The photograph to begin with (default: as the graph says)")
      ->type_name("NAME");
  verb->add_option("--overlay", options->overlay,
                   "Over the colours: where pixels come from, the photographs' outlines, or both")
      ->capture_default_str()
      ->check(one_of(overlay_names()));
  verb->add_flag("--split", window.split, "Split the screen: the root alone, enlarged, at the right");
  verb->add_flag("!--no-adapt", options->layers.adapt, "Do not move edges of photographs onto one another");
  verb->add_option("--video-memory", options->video_memory, "Video memory that it may take, MiB")
      ->capture_default_str()
      ->type_name("MB")
      ->check(CLI::PositiveNumber);
  add_size(*verb, options->size, "Size of the window");
  verb->add_flag("--fly", window.fly, "Begin with the whole and go there by 1 % a picture")
      ->group(kGroupWindow);
  verb->add_option("--screenshot", window.screenshot,
                   "Write the window to this PNG once it is there, then end")
      ->type_name("FILE")
      ->group(kGroupWindow);
  add_threads(*verb, options->layers.threads);
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_detail_view(*options); }; });
}

}  // namespace floatstage::apps
