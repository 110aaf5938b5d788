#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/flags.h"
#include "apps/orbit_flags.h"
#include "apps/progress_bar.h"
#include "apps/renderer_options.h"
#include "apps/text_options.h"
#include "apps/verbs.h"
#include "core/text.h"
#include "pipeline/film.h"
#include "pipeline/json_report.h"
#include "pipeline/orbit.h"
#include "pipeline/picture_sink.h"
#include "pipeline/scene_loader.h"
#include "render/back_end.h"

namespace floatstage::apps {
namespace {

constexpr const char* kNoBackground = "none";

struct Options {
  std::filesystem::path take, path_file, out, json_file;
  std::vector<std::string> methods = {"floating"};
  std::string frames;
  Size size;
  bool orbit = false, keep_spill = false;
  double seconds = 0;
  pipeline::FilmOptions film;
  RendererFlags renderer;
  pipeline::OrbitOptions walk;
};

Result<void> run(const Options& given) {
  if (given.orbit == !given.path_file.empty())
    return fail(ErrorCode::InvalidArgument, "say where the camera goes: either --orbit or --path FILE");
  pipeline::FilmOptions film = given.film;
  film.width = given.size.width;
  film.height = given.size.height;
  film.methods = given.methods;
  film.seconds = given.seconds;
  film.suppress_spill = !given.keep_spill;
  const bool transparent = given.renderer.background == kNoBackground;
  if (transparent && film.methods.size() > 1)
    return fail(ErrorCode::InvalidArgument,
                "--background none shows one method: names stand on pictures that stand side by side");
  RendererFlags flags = given.renderer;
  if (transparent) flags.background = "000000";
  Result<render::RendererOptions> renderer = renderer_options(flags);
  if (!renderer) return forward(renderer);
  film.renderer = *renderer;
  film.balance = given.renderer.balance;

  Result<std::unique_ptr<capture::TakeReader>> take = capture::TakeReader::open(given.take);
  if (!take) return forward(take);
  suit_cameras(given.renderer, (*take)->rig(), film.renderer);
  Result<std::vector<int>> frames = parse_frames(given.frames, (*take)->frame_count());
  if (!frames) return forward(frames);
  film.frames = std::move(*frames);
  Result<pipeline::CameraPath> path =
      given.orbit ? pipeline::CameraPath{} : pipeline::load_path(given.path_file);
  if (!path) return forward(path);
  if (given.orbit) {
    const Result<pipeline::Subject> subject = pipeline::find_subject(**take);
    if (!subject) return forward(subject);
    film.subject = subject->box;
    pipeline::OrbitOptions walk = given.walk;
    if (given.seconds > 0) walk.seconds = given.seconds;
    walk.aspect = static_cast<double>(film.width) / film.height;
    pipeline::Orbit orbit = pipeline::orbit_around((*take)->rig(), *subject, walk);
    std::printf("%s\n", pipeline::describe(orbit).c_str());
    *path = std::move(orbit.path);
  }
  const Result<render::OpenBackEnd> drawing = render::open_back_end(film.renderer.back_end);
  if (!drawing) return forward(drawing);
  film.renderer.back_end = drawing->back_end;
  const int columns = static_cast<int>(film.methods.size());
  Result<std::unique_ptr<pipeline::PictureSink>> sink =
      pipeline::open_picture_sink(given.out, film.width * columns, film.height, film.frame_rate, transparent);
  if (!sink) return forward(sink);
  ProgressBar bar;
  film.progress = &bar;
  Result<pipeline::FilmReport> report =
      pipeline::render_film(**take, *path, film, [&](pipeline::FilmPicture picture) {
        if (transparent) return (*sink)->write(picture.renders.front());
        std::vector<Image> pictures;
        for (const Image& rgba : picture.renders)
          pictures.push_back(pipeline::over(rgba, film.renderer.background));
        return (*sink)->write(pipeline::side_by_side(pictures, film.methods));
      });
  if (!report) return forward(report);
  if (Result<void> ok = (*sink)->finish(); !ok) return ok;
  std::printf("%s: %d pictures of %dx%d in %.1f s (%.1f a second in the renderer)\n", given.out.c_str(),
              report->pictures, film.width, film.height, report->seconds,
              report->pictures / report->render_seconds);
  if (given.json_file.empty()) return {};
  return pipeline::save_json({{"out", given.out.string()},
                              {"pictures", report->pictures},
                              {"seconds", report->seconds},
                              {"render_seconds", report->render_seconds},
                              {"renderer", drawing->description}},
                             given.json_file);
}

}  // namespace

void add_render(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<Options>();
  CLI::App* verb =
      add_verb(app, chosen, "render", "A camera path through a processed take → H.264 video or PNGs",
               {"floatstage render take --orbit --turns 2 --height 0.5 -o orbit.mp4",
                "floatstage render take --path path.json --method linear,floating --size 1280x720 "
                "-o compare.mp4"});
  add_take(*verb, options->take);
  verb->add_flag("--orbit", options->orbit, "Walk around the performer where the cameras stand");
  verb->add_option("--path", options->path_file, "A camera path written by `floatstage play`")
      ->type_name("FILE");
  add_out(*verb, options->out, "A .mp4, .mkv or .mov file, or a folder for PNGs")->required();
  add_list(*verb, "--method", options->methods, method_help() + "\nSeveral stand side by side",
           renderer_names());
  add_size(*verb, options->size, "Size of one picture");
  add_frames(*verb, options->frames, "all");
  add_fps(*verb, options->film.frame_rate, "Pictures a second of the film");
  add_seconds(*verb, options->seconds, "Length of the film (default: the take's, or the path's)");
  verb->add_flag("--keep-spill", options->keep_spill, "Leave the cloth's colour cast on the photographs")
      ->group(kGroupPicture);
  add_orbit_flags(*verb, options->walk, verb->get_option("--orbit"));
  add_renderer_flags(*verb, options->renderer);
  verb->get_option("--background")
      ->description(
          "Colour behind the performer; none: opacity instead, in PNGs and in a .mov (ProRes 4444)");
  add_json(*verb, options->json_file);
  verb->callback([options, &chosen] { chosen.run = [options] { return run(*options); }; });
}

}  // namespace floatstage::apps
