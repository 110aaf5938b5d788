#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "core/result.h"
#include "render/renderer.h"

namespace floatstage::apps {

/// The renderer's options as flags, the same for every verb that renders.
struct RendererFlags {
  render::RendererOptions options;
  std::string show = "color", background = "000000";
};

void add_renderer_flags(CLI::App& verb, RendererFlags& flags);
Result<render::RendererOptions> renderer_options(const RendererFlags& flags);

/// "Method:" and a line for each: nearest, linear, floating.
std::string method_help();

}  // namespace floatstage::apps
