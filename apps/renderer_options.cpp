#include "apps/renderer_options.h"

#include <algorithm>

#include "core/text.h"

namespace floatstage::apps {

void add_renderer_flags(CLI::App& verb, RendererFlags& flags) {
  render::RendererOptions& o = flags.options;
  verb.add_option("--cameras", o.cameras, "Photographs blended per view")->capture_default_str();
  verb.add_option("--soft-radius", o.soft_radius, "Radius of soft visibility, px")->capture_default_str();
  verb.add_option("--flow", o.flow.backend, "Flow back-end")->capture_default_str();
  verb.add_option("--flow-preset", o.flow.preset, "ultrafast, fast or medium")->capture_default_str();
  verb.add_option("--flow-finest-scale", o.flow.finest_scale,
                  "Pyramid level at which the flow stops; 0: full resolution")
      ->capture_default_str();
  std::string names;
  for (const std::string& n : render::render_output_names()) names += (names.empty() ? "" : ", ") + n;
  verb.add_option("--output", flags.output, "What is shown: " + names)->capture_default_str();
  verb.add_option("--background", flags.background, "Colour behind the performer, rrggbb")
      ->capture_default_str();
}

Result<render::RendererOptions> renderer_options(const RendererFlags& flags) {
  render::RendererOptions options = flags.options;
  const std::vector<std::string>& names = render::render_output_names();
  const auto found = std::find(names.begin(), names.end(), flags.output);
  if (found == names.end())
    return fail(ErrorCode::InvalidArgument, text("--output '", flags.output, "' is unknown; see --help"));
  options.output = static_cast<render::RenderOutput>(found - names.begin());
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
  for (const render::RendererInfo& r : render::renderers()) help += text(" ", r.name, " (", r.help, ")");
  return help + ".";
}

}  // namespace floatstage::apps
