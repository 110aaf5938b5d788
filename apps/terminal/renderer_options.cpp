#include "apps/terminal/renderer_options.h"

#include <charconv>
#include <cmath>
#include <tuple>

#include "apps/terminal/flags.h"
#include "apps/terminal/text_options.h"
#include "core/text.h"
#include "render/camera_grid.h"

namespace floatstage::apps {
namespace {

constexpr double kUsualMemory = 0.75;  // ADR 357

std::vector<std::string> known_flows() {
  std::vector<std::string> names = render::flow_backends();
  names.emplace_back("none");
  return names;
}

Result<std::pair<double, double>> parse_range(const std::string& words) {
  const char *begin = words.data(), *end = begin + words.size();
  double low = 0, high = 0;
  const auto [colon, error] = std::from_chars(begin, end, low);
  if (error == std::errc() && colon != end && *colon == ':') {
    const auto [stop, second] = std::from_chars(colon + 1, end, high);
    if (second == std::errc() && stop == end && low > 0 && high > low && std::isfinite(high))
      return std::pair(low, high);
  }
  return fail(ErrorCode::InvalidArgument,
              text("--depth-range '", words,
                   "' is no range; write the nearest and a larger farthest depth in "
                   "metres, as in 1.5:4"));
}

}  // namespace

void add_back_end_flag(CLI::App& verb, std::string& back_end) {
  verb.add_option("--renderer", back_end,
                  "What draws: cpu (native code), gl (OpenGL), or auto: gl where a GPU draws, else cpu")
      ->capture_default_str()
      ->check(one_of(render::back_end_names()))
      ->group(kGroupPicture);
}

void add_renderer_flags(CLI::App& verb, RendererFlags& flags) {
  add_back_end_flag(verb, flags.back_end);
  render::RendererOptions& o = flags.options;
  o.field_memory = kUsualMemory;
  flags.blend = add_blend(verb, o.cameras);
  add_background(verb, flags.background);
  verb.add_flag("--balance", flags.balance,
                "Bring the cameras' colours to one another by what they see of the subject, where "
                "`calibrate color` did not: for cameras of unequal exposure")
      ->group(kGroupPicture);
  verb.add_option("--show", flags.show, "What the picture shows: the colours, or an intermediate")
      ->capture_default_str()
      ->check(one_of(render::render_output_names()))
      ->group(kGroupPicture);
  verb.add_option("--show-camera", flags.show_camera,
                  "Whose photograph, warp or field --show shows (default: the view's first)")
      ->type_name("SERIAL")
      ->group(kGroupPicture);
  verb.add_option("--show-towards", flags.show_towards,
                  "--show field, confidence: of the flow from the shown camera to this one")
      ->type_name("SERIAL")
      ->group(kGroupPicture);
  const std::vector<CLI::Option*> filters = {
      verb.add_option("--band-limit", o.band_limit,
                      "band-limited: width of its filter, photograph pixels (0: by the depth range)")
          ->type_name("PX"),
      verb.add_option("--depth-range", flags.depth_range,
                      "band-limited: nearest and farthest depth of the scene, metres before the cameras "
                      "(default: the proxy's, give or take --uncertainty)")
          ->type_name("NEAR:FAR"),
      verb.add_option(
          "--uncertainty", o.uncertainty,
          "band-limited, filtered, --show predicted: how far the surface may lie before or behind the proxy, "
          "as a share of the diagonal of the proxy's box"),
      verb.add_option("--motion-blur", o.motion_blur,
                      "filtered: share of the pictures before that stays in each, 0 to 0.95")
          ->type_name("SHARE"),
      verb.add_option(
              "--field-memory", o.field_memory,
              "floating: share of the last picture's displacements that stays in each picture's while "
              "time stands still, 0 (each is drawn for itself) to 0.95")
          ->type_name("SHARE")};
  for (CLI::Option* option : filters) option->capture_default_str()->group(kGroupTuning);
  const std::vector<CLI::Option*> tuning = {
      verb.add_option("--soft-radius", o.soft_radius, "Radius of soft visibility, px"),
      verb.add_option("--flow", o.flow.backend, "Flow back-end: variational, dis, or none")
          ->check(one_of(known_flows()).description("")),
      verb.add_option(
              "--flow-preset", o.flow.preset,
              "variational: fast or quality; dis: medium, fast or ultrafast (default: the first of these)")
          ->check(one_of({"ultrafast", "fast", "medium", "quality"})),
      verb.add_option("--flow-finest-scale", o.flow.finest_scale,
                      "Pyramid level at which the flow stops; 0: full resolution"),
      add_alignment(verb, flags.alignment),
      verb.add_option("--positions", flags.positions,
                      "Where floating puts what photographs show at different places: parallax (where it is "
                      "whatever depth the hull misses there) or mean (Eq. 11.3)")
          ->check(one_of(render::position_names()))};
  for (CLI::Option* option : tuning) option->capture_default_str()->group(kGroupTuning);
}

CLI::Option* add_alignment(CLI::App& verb, std::string& alignment) {
  return verb
      .add_option("--alignment", alignment,
                  "What floating finds to bring photographs together: flow (fields between each two), depth "
                  "(how far the surface lies off the hull, one number a pixel: faster, and sharper where "
                  "calibration is right) or auto (depth, but flow on a GPU)")
      ->check(one_of(render::alignment_names()))
      ->capture_default_str()
      ->group(kGroupTuning);
}

Result<render::RendererOptions> renderer_options(const RendererFlags& flags) {
  render::RendererOptions options = flags.options;
  const Result<render::BackEnd> back_end = render::parse_back_end(flags.back_end);
  if (!back_end) return forward(back_end);
  options.back_end = *back_end;
  const std::vector<std::string>& names = render::render_output_names();
  const std::size_t shown = place_of(names, flags.show);
  if (shown == names.size())
    return fail(ErrorCode::InvalidArgument, text("--show '", flags.show, "' is unknown; see --help"));
  options.output = static_cast<render::RenderOutput>(shown);
  options.positions = static_cast<render::Positions>(place_of(render::position_names(), flags.positions));
  options.alignment = static_cast<render::Alignment>(place_of(render::alignment_names(), flags.alignment));
  if (options.alignment == render::Alignment::Depth &&
      (options.flow.backend != "variational" || options.positions != render::Positions::Parallax))
    return fail(
        ErrorCode::InvalidArgument,
        "--alignment depth goes with --flow variational and --positions parallax, which say how depth "
        "is found; take --alignment flow");
  if (!flags.depth_range.empty()) {
    const Result<std::pair<double, double>> range = parse_range(flags.depth_range);
    if (!range) return forward(range);
    std::tie(options.nearest, options.farthest) = *range;
  }
  const Result<std::array<float, 3>> background = parse_color(flags.background);
  if (!background) return forward(background);
  options.background = *background;
  if (Result<void> ok = check(options); !ok) return forward(ok);
  return options;
}

Result<void> suit_cameras(const RendererFlags& flags, const Rig& rig, render::RendererOptions& options) {
  constexpr int kCorners = 4;
  if (flags.blend->count() == 0 && render::camera_grid(rig.cameras)) options.cameras = kCorners;
  for (const auto& [flag, serial, index] :
       {std::tuple{"--show-camera", &flags.show_camera, &options.shown_camera},
        std::tuple{"--show-towards", &flags.show_towards, &options.towards_camera}}) {
    if (serial->empty()) continue;
    *index = camera_index(rig, *serial);
    if (*index < 0)
      return fail(
          ErrorCode::InvalidArgument,
          text(flag, " '", *serial, "' is no camera of this take; `floatstage take info` lists them"));
  }
  return {};
}

std::string method_help() {
  std::string help = "Method:";
  for (const render::RendererInfo& r : render::renderers()) help += text("\n  ", r.name, ": ", r.help);
  return help;
}

}  // namespace floatstage::apps
