#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "core/result.h"
#include "render/renderer.h"

namespace floatstage::apps {

/// The renderer's options as flags, the same for every verb that renders.
struct RendererFlags {
  render::RendererOptions options;
  bool balance = false;
  std::string show = "color", positions = "parallax", background = "000000", back_end = "auto";
};

void add_renderer_flags(CLI::App& verb, RendererFlags& flags);
/// --renderer alone, for verbs that choose the rest by themselves.
void add_back_end_flag(CLI::App& verb, std::string& back_end);
Result<render::RendererOptions> renderer_options(const RendererFlags& flags);

/// "Method:" and a line for each: nearest, linear, floating.
std::string method_help();

}  // namespace floatstage::apps
