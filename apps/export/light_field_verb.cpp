#include <cstdio>

#include <nlohmann/json.hpp>

#include "apps/export/export_verbs.h"
#include "apps/terminal/flags.h"
#include "apps/terminal/label_flags.h"
#include "apps/terminal/progress_bar.h"
#include "apps/terminal/renderer_options.h"
#include "pipeline/export/export_light_field.h"
#include "pipeline/json_report.h"
#include "pipeline/orbit.h"
#include "pipeline/subject.h"
#include "render/back_end.h"

namespace floatstage::apps {
namespace {

struct LightFieldArguments {
  pipeline::ExportLightFieldOptions field;
  std::string method = "floating";
  int frame = 0;
  Size size;
  RendererFlags renderer;
  std::filesystem::path path, json;
};

Result<void> run_light_field(const LightFieldArguments& given) {
  pipeline::ExportLightFieldOptions options = given.field;
  pipeline::FilmOptions& film = options.film;
  const Result<render::RendererOptions> renderer = renderer_options(given.renderer);
  if (!renderer) return forward(renderer);
  film.renderer = *renderer;
  film.balance = given.renderer.balance;
  film.frames = {given.frame};
  film.methods = {given.method};
  film.width = given.size.width, film.height = given.size.height;
  const Result<std::unique_ptr<capture::TakeReader>> take =
      pipeline::open_chosen(options.take, options.labels);
  if (!take) return forward(take);
  if (Result<void> ok = suit_cameras(given.renderer, (*take)->rig(), film.renderer); !ok) return forward(ok);
  const Result<pipeline::Subject> subject = pipeline::find_subject(**take);
  if (!subject) return forward(subject);
  film.subject = subject->box;
  if (given.path.empty()) {
    const double aspect = static_cast<double>(film.width) / film.height;
    options.middle = pipeline::orbit_around((*take)->rig(), *subject, {.aspect = aspect}).path.keys.front();
  } else {
    const Result<pipeline::CameraPath> path = pipeline::load_path(given.path);
    if (!path) return forward(path);
    options.middle = pipeline::sample(*path, 0, subject->track);
  }
  const Result<render::OpenBackEnd> drawing = render::open_back_end(film.renderer.back_end);
  if (!drawing) return forward(drawing);
  film.renderer.back_end = drawing->back_end;
  ProgressBar bar;
  film.progress = &bar;
  const Result<pipeline::ExportLightFieldReport> report = pipeline::export_light_field(options);
  if (!report) return forward(report);
  std::printf("%s: %d views, %d rows of %d, %g m apart\n", options.out.c_str(), report->pictures,
              options.rows, options.columns, options.baseline);
  if (given.json.empty()) return {};
  return pipeline::save_json(
      {{"out", options.out.string()}, {"pictures", report->pictures}, {"seconds", report->seconds}},
      given.json);
}

}  // namespace

void add_export_light_field(CLI::App& parent, Chosen& chosen) {
  auto options = std::make_shared<LightFieldArguments>();
  CLI::App* verb =
      add_verb(parent, chosen, "lightfield", "A plane of views of one instant, with their calibration",
               {"floatstage export lightfield take -o field",
                "floatstage export lightfield take --frame 12 --rows 3 --columns 9 --baseline 0.02 "
                "-o field"});
  pipeline::ExportLightFieldOptions& field = options->field;
  add_take(*verb, field.take);
  add_label_choice(*verb, field.labels);
  add_out(*verb, field.out, "A new folder: views, sparse/0, transforms.json")->required();
  verb->add_option("--frame", options->frame, "The instant")->capture_default_str()->type_name("N");
  verb->add_option("--rows", field.rows, "Of views, from above")->capture_default_str()->type_name("N");
  verb->add_option("--columns", field.columns, "Of views, from the left")
      ->capture_default_str()
      ->type_name("N");
  verb->add_option("--baseline", field.baseline, "Metres from each view to the next")
      ->capture_default_str()
      ->check(CLI::PositiveNumber)
      ->type_name("M");
  verb->add_option(
          "--path", options->path,
          "A camera path: the middle stands at its first key (default: where --orbit of `render` begins)")
      ->type_name("FILE");
  verb->add_option("--method", options->method, method_help())
      ->capture_default_str()
      ->check(one_of(renderer_names()));
  add_size(*verb, options->size, "Size of a view");
  add_renderer_flags(*verb, options->renderer);
  add_json(*verb, options->json);
  verb->callback([options, &chosen] { chosen.run = [options] { return run_light_field(*options); }; });
}

}  // namespace floatstage::apps
