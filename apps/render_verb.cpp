#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/plan/planned.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/label_flags.h"
#include "apps/terminal/orbit_flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/renderer_options.h"
#include "apps/terminal/text_options.h"
#include "apps/verbs.h"
#include "capture/sha256.h"
#include "core/text.h"
#include "pipeline/film_file.h"
#include "pipeline/json_report.h"
#include "pipeline/orbit.h"
#include "pipeline/plan/process_plan.h"
#include "pipeline/scene_loader.h"
#include "render/back_end.h"

namespace floatstage::apps {
namespace {

constexpr const char* kNoBackground = "none";

struct RenderArguments {
  std::filesystem::path take, path_file, out, json_file;
  std::vector<std::string> methods = {"floating"};
  std::string frames, pictures, sound;
  bool no_sound = false;
  Size size;
  bool orbit = false, keep_spill = false, exr = false;
  double seconds = 0;
  pipeline::LabelChoice labels;
  pipeline::FilmOptions film;
  RendererFlags renderer;
  pipeline::OrbitOptions walk;
  PlanFlags plan;
};

constexpr double kPictureSeconds = 0.1;  // before the plan has measured it

// The pictures of the film that --pictures names.
Result<std::vector<int>> parts_asked_for(const RenderArguments& given, const capture::TakeReader& take,
                                         const pipeline::CameraPath& path,
                                         const pipeline::FilmOptions& film) {
  if (given.pictures.empty()) return std::vector<int>();
  const Result<std::vector<int>> whole = pipeline::film_frames(take, path, film);
  if (!whole) return forward(whole);
  return parse_frames(given.pictures, static_cast<int>(whole->size()));
}

// What a picture's stages take in the mean, by name: of OpenGL alone.
nlohmann::json unseen_json(const pipeline::FilmSight& sight) {
  if (sight.pictures == 0) return nullptr;
  return {{"mean", sight.unseen},
          {"worst", sight.worst},
          {"worst_picture", sight.worst_picture},
          {"pictures_above_limit", sight.much},
          {"limit", pipeline::kMuchUnseen}};
}

nlohmann::json stages_json(const pipeline::FilmReport& film) {
  nlohmann::json stages = nlohmann::json::object();
  for (const render::StageTime& stage : film.stages)
    stages[stage.name] = {{"milliseconds", stage.milliseconds / film.pictures},
                          {"dispatches", static_cast<double>(stage.dispatches) / film.pictures},
                          {"least_megabytes", stage.least_megabytes / film.pictures}};
  return stages;
}

void say(const RenderArguments& given, const pipeline::FilmOptions& film,
         const pipeline::FilmFileReport& report) {
  const std::string kept = report.kept > 0 ? text(", ", report.kept, " of them made before") : "";
  const double drawing = report.film.render_seconds;
  std::printf("%s: %d pictures of %dx%d%s in %.1f s (%.1f a second in the renderer)\n", given.out.c_str(),
              report.kept + report.film.pictures, film.width, film.height, kept.c_str(), report.film.seconds,
              drawing > 0 ? report.film.pictures / drawing : 0.0);
  if (!report.sound.empty())
    std::printf("sound '%s' is heard for %.1f s of it\n", report.sound.c_str(), report.sound_seconds);
  if (!given.pictures.empty())
    std::printf(
        "%d of %d parts of the film are there; the same command without --pictures makes the rest and "
        "joins them\n",
        report.done, report.parts);
}

// Opacity in the place of a background.
bool is_transparent(const RenderArguments& given) { return given.renderer.background == kNoBackground; }

// What is said of the film and does not need the take.
Result<pipeline::FilmOptions> film_options(const RenderArguments& given) {
  pipeline::FilmOptions film = given.film;
  film.width = given.size.width;
  film.height = given.size.height;
  film.methods = given.methods;
  film.seconds = given.seconds;
  film.suppress_spill = !given.keep_spill;
  const bool transparent = is_transparent(given);
  if (transparent && film.methods.size() > 1)
    return fail(ErrorCode::InvalidArgument,
                "--background none shows one method: names stand on pictures that stand side by side");
  RendererFlags flags = given.renderer;
  if (transparent) flags.background = "000000";
  Result<render::RendererOptions> renderer = renderer_options(flags);
  if (!renderer) return forward(renderer);
  film.renderer = *renderer;
  film.balance = given.renderer.balance;
  return film;
}

// Where the camera goes; an orbit's subject is the film's.
Result<pipeline::CameraPath> path_of(const RenderArguments& given, const capture::TakeReader& take,
                                     pipeline::FilmOptions& film) {
  if (!given.orbit) {
    Result<pipeline::CameraPath> path = pipeline::load_path(given.path_file);
    if (path && film.seconds == 0) film.seconds = path->duration();  // as it is played everywhere else
    return path;
  }
  const Result<pipeline::Subject> subject = pipeline::find_subject(take);
  if (!subject) return forward(subject);
  film.subject = subject->box;
  pipeline::OrbitOptions walk = given.walk;
  if (given.seconds > 0) walk.seconds = given.seconds;
  walk.aspect = static_cast<double>(film.width) / film.height;
  pipeline::Orbit orbit = pipeline::orbit_around(take.rig(), *subject, walk);
  std::printf("%s\n", pipeline::describe(orbit).c_str());
  return std::move(orbit.path);
}

Result<void> run_render(const RenderArguments& given) {
  if (given.orbit == !given.path_file.empty())
    return fail(ErrorCode::InvalidArgument, "say where the camera goes: either --orbit or --path FILE");
  Result<pipeline::FilmOptions> film = film_options(given);
  if (!film) return forward(film);
  Result<std::unique_ptr<capture::TakeReader>> take = pipeline::open_chosen(given.take, given.labels);
  if (!take) return forward(take);
  if (Result<void> ok = suit_cameras(given.renderer, (*take)->rig(), film->renderer); !ok) return forward(ok);
  Result<std::vector<int>> frames = parse_frames(given.frames, (*take)->frame_count());
  if (!frames) return forward(frames);
  film->frames = std::move(*frames);
  const Result<pipeline::CameraPath> path = path_of(given, **take, *film);
  if (!path) return forward(path);
  const Result<render::OpenBackEnd> drawing = render::open_back_end(film->renderer.back_end);
  if (!drawing) return forward(drawing);
  film->renderer.back_end = drawing->back_end;
  Result<std::vector<int>> pictures = parts_asked_for(given, **take, *path, *film);
  if (!pictures) return forward(pictures);
  ProgressBar bar;
  film->progress = &bar;
  film->time_stages = !given.json_file.empty();
  const Result<capture::FileHash> program =
      capture::sha256_of_file("/proc/self/exe", [](std::uint64_t) { return true; });
  if (!program) return forward(program);
  const std::string drawn_by = drawing->back_end == render::BackEnd::Gl ? drawing->description : "cpu";
  const pipeline::FilmFileOptions file = {.out = given.out,
                                          .drawn_by = drawn_by + " " + program->sha256,
                                          .with_opacity = is_transparent(given),
                                          .stills = given.exr ? pipeline::Stills::Exr : pipeline::Stills::Png,
                                          .pictures = std::move(*pictures),
                                          .sound = !given.no_sound,
                                          .sound_track = given.sound};
  const Result<pipeline::FilmFileReport> report = pipeline::render_film_file(**take, *path, *film, file);
  if (!report) return forward(report);
  say(given, *film, *report);
  if (given.json_file.empty()) return {};
  return pipeline::save_json({{"out", given.out.string()},
                              {"pictures", report->pictures},
                              {"drawn", report->film.pictures},
                              {"kept", report->kept},
                              {"sound", report->sound},
                              {"sound_seconds", report->sound_seconds},
                              {"parts", report->parts},
                              {"parts_done", report->done},
                              {"seconds", report->film.seconds},
                              {"render_seconds", report->film.render_seconds},
                              {"stages", stages_json(report->film)},
                              {"unseen", unseen_json(report->film.sight)},
                              {"renderer", drawing->description}},
                             given.json_file);
}

// Parts of the film, so many that there are `chunk` pictures in an item, or one part.
Result<pipeline::Plan> make_plan(const RenderArguments& given, int chunk) {
  if (!given.pictures.empty())
    return fail(ErrorCode::InvalidArgument, "--plan makes the whole film; leave out --pictures");
  Result<pipeline::FilmOptions> film = film_options(given);
  if (!film) return forward(film);
  Result<std::unique_ptr<capture::TakeReader>> take = pipeline::open_chosen(given.take, given.labels);
  if (!take) return forward(take);
  Result<std::vector<int>> frames = parse_frames(given.frames, (*take)->frame_count());
  if (!frames) return forward(frames);
  film->frames = std::move(*frames);
  const Result<pipeline::CameraPath> path = path_of(given, **take, *film);
  if (!path) return forward(path);
  const Result<std::vector<int>> whole = pipeline::film_frames(**take, *path, *film);
  if (!whole) return forward(whole);
  std::vector<pipeline::PlanItem> pieces;
  for (const pipeline::FilmParts::Part& part : pipeline::FilmParts::divide(
           {.pictures = static_cast<int>(whole->size()), .in_one = film->renderer.motion_blur > 0})) {
    if (pieces.empty() || pieces.back().count + part.count > chunk) pieces.emplace_back().first = part.first;
    pieces.back().count += part.count;
  }
  return pipeline::plan_of_pieces(given.take, "pictures", std::move(pieces), kPictureSeconds);
}

// Parts, or the film of them.
Result<ItemEnd> run_item(RenderArguments given, const pipeline::Plan&, const pipeline::PlanItem& item) {
  if (item.count > 0) given.pictures = text(item.first, ":", item.first + item.count);
  if (item.count > 0) given.json_file.clear();
  if (Result<void> ok = run_render(given); !ok) return forward(ok);
  return ItemEnd();
}

Planned planned(const RenderArguments& given) {
  return {.folder = plan_beside(given.out, "render"),
          .threads = 0,
          .make = [given](int chunk) { return make_plan(given, chunk); },
          .made_from = [given] { return pipeline::plan_inputs(given.take); },
          .run = [given](const pipeline::Plan& plan,
                         const pipeline::PlanItem& item) { return run_item(given, plan, item); }};
}

}  // namespace

void add_render(CLI::App& app, Chosen& chosen) {
  auto options = std::make_shared<RenderArguments>();
  CLI::App* verb =
      add_verb(app, chosen, "render", "A camera path through a processed take → H.264 video or stills",
               {"floatstage render take --orbit --turns 2 --height 0.5 -o orbit.mp4",
                "floatstage render take --path path.json --method linear,floating --size 1280x720 "
                "-o compare.mp4"});
  add_take(*verb, options->take);
  add_label_choice(*verb, options->labels);
  verb->add_flag("--orbit", options->orbit, "Walk around the performer where the cameras stand");
  verb->add_option("--path", options->path_file, "A camera path, of `play` or `path import`")
      ->type_name("FILE");
  add_out(*verb, options->out, "A .mp4, .mkv or .mov file, or a folder for stills")->required();
  verb->add_flag("--exr", options->exr,
                 "A folder's stills are OpenEXR, in linear light and multiplied by their opacity, not PNG");
  add_list(*verb, "--method", options->methods, method_help() + "\nSeveral stand side by side",
           renderer_names());
  add_size(*verb, options->size, "Size of one picture");
  add_frames(*verb, options->frames, "all");
  add_fps(*verb, options->film.frame_rate, "Pictures a second of the film");
  add_seconds(*verb, options->seconds, "Length of the film (default: the path's; with --orbit the take's)");
  verb->add_option("--pictures", options->pictures,
                   "Only the parts of the film with these pictures, A:B; the call without it joins all parts")
      ->type_name("A:B");
  verb->add_flag("--no-sound", options->no_sound, "Leave out the take's sound");
  verb->add_option("--sound", options->sound, "The sound track that is heard (default: the take's first)")
      ->type_name("NAME")
      ->excludes("--no-sound");
  verb->add_option("--views", options->film.array.views,
                   "Eyes beside one another in each picture: 2 for stereo, up to 8 for displays of several "
                   "(above 3 in two rows), from the leftmost on")
      ->type_name("N")
      ->check(CLI::Range(1, pipeline::kMostViews))
      ->group(kGroupPicture)
      ->capture_default_str();
  verb->add_option("--baseline", options->film.array.baseline, "Metres from each eye to the next")
      ->type_name("M")
      ->check(CLI::PositiveNumber)
      ->needs("--views")
      ->group(kGroupPicture)
      ->capture_default_str();
  verb->add_flag("--keep-spill", options->keep_spill, "Leave the cloth's colour cast on the photographs")
      ->group(kGroupPicture);
  add_orbit_flags(*verb, options->walk, verb->get_option("--orbit"));
  add_renderer_flags(*verb, options->renderer);
  verb->get_option("--background")
      ->description(
          "Colour behind the performer; none: opacity instead, in stills and in a .mov (ProRes 4444)");
  add_json(*verb, options->json_file);
  add_planned_run(*verb, chosen, options, run_render, planned);
}

}  // namespace floatstage::apps
