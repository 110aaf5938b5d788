#include "apps/renderer_options.h"

#include "apps/flags.h"
#include "core/text.h"

namespace floatstage::apps {
namespace {

std::vector<std::string> known_flows() {
  std::vector<std::string> names = render::flow_backends();
  names.emplace_back("none");
  return names;
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
  add_blend(verb, o.cameras);
  add_background(verb, flags.background);
  verb.add_flag("--balance", flags.balance,
                "Bring the cameras' colours to one another by what they see of the subject, where "
                "`calibrate color` did not: for cameras of unequal exposure")
      ->group(kGroupPicture);
  verb.add_option("--show", flags.show, "What the picture shows: the colours, or an intermediate")
      ->capture_default_str()
      ->check(one_of(render::render_output_names()))
      ->group(kGroupPicture);
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
      verb.add_option("--positions", flags.positions,
                      "Where floating puts what photographs show at different places: parallax (where it is "
                      "whatever depth the hull misses there) or mean (Eq. 11.3)")
          ->check(one_of(render::position_names()))};
  for (CLI::Option* option : tuning) option->capture_default_str()->group(kGroupTuning);
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
  const bool hex = flags.background.size() == 6 &&
                   flags.background.find_first_not_of("0123456789abcdefABCDEF") == std::string::npos;
  if (!hex)
    return fail(ErrorCode::InvalidArgument,
                text("--background '", flags.background, "' is not a colour; write it as rrggbb"));
  for (std::size_t i = 0; i < 3; ++i)
    options.background[i] =
        static_cast<float>(std::stoi(flags.background.substr(2 * i, 2), nullptr, 16)) / 255.f;
  if (Result<void> ok = check(options); !ok) return forward(ok);
  return options;
}

std::string method_help() {
  std::string help = "Method:";
  for (const render::RendererInfo& r : render::renderers()) help += text("\n  ", r.name, ": ", r.help);
  return help;
}

}  // namespace floatstage::apps
